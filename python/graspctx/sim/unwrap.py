"""Texture coordinates for any surface: wrapped around it like paper, with its top and bottom laid flat."""

from __future__ import annotations

import numpy as np

ELONGATED = 1.5
"""An object this many times longer than it is wide is wrapped about its long side."""


def unwrap(vertices_m: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, tuple[float, float]]:
    """Texture coordinates in even size, without a seam around the object.

    The axis is z, or x or y if the object is elongated there. Faces that look away from it are wrapped: u is
    the way along the outline (the convex hull seen along the axis), v the height. Faces that look along the
    axis are laid flat; those that look around it (the sides of a handle) take their distance from the axis as
    u. Nothing is stretched to more than twice its size; parts nearer to the axis than the outline are
    squeezed around, as on a lathe.

    Args:
        vertices_m: (V, 3).
        faces: (F, 3).

    Returns:
        (uv (F, 3, 2), (around, along) metres that u and v from 0 to 1 stand for).
    """
    from scipy.spatial import ConvexHull

    axis = 2
    size = np.ptp(vertices_m, axis=0)
    longest = int(size.argmax())
    if size[longest] > ELONGATED * np.delete(size, longest).max():
        axis = longest
    x, y, z = np.asarray(vertices_m, float)[:, [(axis + 1) % 3, (axis + 2) % 3, axis]].T
    hull = ConvexHull(np.stack([x, y], axis=1))
    corners = hull.points[hull.vertices]
    x, y, z = x - corners[:, 0].mean(), y - corners[:, 1].mean(), z - z.min()
    points = np.stack([x, y, z], axis=1)
    outline = _Outline(corners - corners.mean(axis=0))

    triangles = points[faces]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    angle = np.arctan2(y, x)[faces]
    middle = triangles.mean(axis=1)
    away = outline.normal(np.arctan2(middle[:, 1], middle[:, 0]))
    facing = np.abs(
        np.stack(
            [
                (normal[:, :2] * away).sum(1),  # away from the axis, or towards it
                normal[:, 1] * away[:, 0] - normal[:, 0] * away[:, 1],  # around it
                normal[:, 2],  # along it
            ]
        )
    ).argmax(axis=0)[:, None]

    walked = outline.walked(angle)
    walked -= outline.length * np.round(
        (walked - walked[:, :1]) / outline.length
    )  # no face goes round the back
    distance = np.hypot(x, y)[faces]
    u = np.select([facing == 0, facing == 1], [walked, distance], x[faces])
    v = np.where(facing == 2, (y - y.min())[faces], z[faces])
    along = max(np.ptp(z), np.ptp(y))
    return np.stack([u / outline.length, v / along], axis=-1), (float(outline.length), float(along))


class _Outline:
    """A convex polygon around the origin, walked along by angle."""

    def __init__(self, corners: np.ndarray):
        edges = np.roll(corners, -1, axis=0) - corners  # counter-clockwise, as Qhull orders them
        self._normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)
        self._normals /= np.linalg.norm(self._normals, axis=1, keepdims=True)
        self._offsets = (self._normals * corners).sum(axis=1)
        self._angles = np.linspace(-np.pi, np.pi, 1441)
        direction = np.stack([np.cos(self._angles), np.sin(self._angles)], axis=1)
        # A ray leaves a convex polygon at the first side's line that it meets from inside.
        rate = direction @ self._normals.T
        reach = np.where(rate > 1e-12, self._offsets / np.maximum(rate, 1e-12), np.inf)
        self._side = reach.argmin(axis=1)
        points = direction * reach.min(axis=1)[:, None]
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self._walked = np.concatenate([[0.0], np.cumsum(steps)])
        self.length = float(self._walked[-1])

    def walked(self, angle):
        """Length walked from angle -pi, counter-clockwise."""
        return np.interp(angle, self._angles, self._walked)

    def normal(self, angle):
        """(…, 2) outward normal where a ray of this angle leaves."""
        nearest = np.round((angle + np.pi) / (2 * np.pi) * (len(self._angles) - 1)).astype(int)
        return self._normals[self._side[nearest]]
