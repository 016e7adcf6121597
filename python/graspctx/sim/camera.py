"""The pair of cameras, and where it stands."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StereoCamera:
    """A rectified pair. Pixel centres at integers; the right camera is `baseline_m` along +x of the left.

    Attributes:
        image_size: (width, height) px.
        focal_px, centre_px: of both views.
    """

    image_size: tuple[int, int]
    focal_px: float
    centre_px: tuple[float, float]
    baseline_m: float

    def project(self, points_m: np.ndarray) -> np.ndarray:
        """(N, 3) points in the left camera's frame to (N, 2) pixels of the left view."""
        return self.focal_px * points_m[:, :2] / points_m[:, 2:] + np.array(self.centre_px)

    def sees_all(self, points_m: np.ndarray, margin_px: float) -> bool:
        """Whether (N, 3) points in the left camera's frame are in both views, off their borders."""
        highest = np.array(self.image_size) - margin_px
        if points_m[:, 2].min() < 0.2:
            return False
        for shift_m in (0.0, self.baseline_m):
            pixels = self.project(points_m - [shift_m, 0, 0])
            if (pixels < margin_px).any() or (pixels > highest).any():
                return False
        return True


@dataclass(frozen=True)
class Viewpoint:
    """How the pair looks at the objects.

    Attributes:
        azimuth_deg: where it stands around the table, from the table's x towards its y.
        elevation_deg: angle between the line of sight and the table.
        roll_deg: turn about the line of sight; positive turns the picture clockwise.
        distance_m: from the middle of the two cameras to the middle of the objects.
        aim: (2,) tangents of the angles, right and down, at which the middle of the objects is seen.
    """

    azimuth_deg: float
    elevation_deg: float
    roll_deg: float
    distance_m: float
    aim: tuple[float, float]

    def cam_from_table(self, middle_m: np.ndarray, baseline_m: float) -> np.ndarray:
        """(4, 4) of the left camera.

        Args:
            middle_m: (3,) middle of the objects, table frame.
            baseline_m: distance of the two cameras.
        """
        azimuth, elevation, roll = np.radians([self.azimuth_deg, self.elevation_deg, self.roll_deg])
        c = np.cos(elevation)
        forward = -np.array([np.cos(azimuth) * c, np.sin(azimuth) * c, np.sin(elevation)])
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        c, s = np.cos(roll), np.sin(roll)
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        rotation = turn @ np.stack([right, np.cross(forward, right), forward])
        ray = np.array([*self.aim, 1.0])
        seen_at = ray / np.linalg.norm(ray) * self.distance_m
        cam_from_table = np.eye(4)
        cam_from_table[:3, :3] = rotation
        left_from_middle_m = np.array([baseline_m / 2, 0, 0])
        cam_from_table[:3, 3] = seen_at + left_from_middle_m - rotation @ middle_m
        return cam_from_table
