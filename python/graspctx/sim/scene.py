"""What stands in a scene: camera, table, objects, light; drawn from a seed, before anything is rendered."""

from dataclasses import dataclass

import numpy as np

from .families import ObjectShape, make_object
from .splits import draw_seed, split_number
from .textures import TABLE_TEXTURES


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


@dataclass(frozen=True)
class PlacedObject:
    """An object in the scene.

    Attributes:
        id: 1, 2, … as in the masks.
        table_from_object: (4, 4).
        gloss: specular strength in [0, 1].
    """

    id: int
    shape: ObjectShape
    texture_seed: int
    table_from_object: np.ndarray
    gloss: float


@dataclass(frozen=True)
class Light:
    """A far light, from `position_m` (table frame) to the table's middle; RGB strength in [0, 1]."""

    position_m: np.ndarray
    strength: np.ndarray
    casts_shadow: bool


@dataclass(frozen=True)
class Sensor:
    """What the cameras do to the picture.

    Attributes:
        brightness: mean grey level that the exposure aims at.
        gain: of each view, on top of the common exposure.
        blur_px, noise: standard deviations, pixels and grey levels.
    """

    brightness: float
    gain: tuple[float, float]
    blur_px: float
    noise: float


@dataclass(frozen=True)
class Scene:
    """Everything that is rendered. Table frame: z up, table surface at z = 0.

    Attributes:
        seed, index: the data set's seed and the scene's place in it.
        split: of its shapes, textures and everything else that is drawn; see splits.py.
        cam_from_table: (4, 4) left camera.
        table_half_size_m: half the table's width and depth.
        table_turn_rad: turn of the table top about z.
        room_m: distances of the three walls behind the table, and the table's height over the floor.
    """

    seed: int
    index: int
    split: str
    camera: StereoCamera
    cam_from_table: np.ndarray
    objects: tuple[PlacedObject, ...]
    table_texture: str
    table_texture_seed: int
    table_texture_size_m: float
    table_half_size_m: tuple[float, float]
    table_turn_rad: float
    surface_seeds: tuple[int, int]
    room_m: tuple[float, float]
    lights: tuple[Light, ...]
    ambient: float
    sensor: Sensor

    @property
    def table_plane(self) -> tuple[np.ndarray, float]:
        """(normal (3,), offset_m) in the left camera's frame: normal · P + offset_m is the height of P."""
        normal = self.cam_from_table[:3, 2]
        return normal, float(-normal @ self.cam_from_table[:3, 3])


def _turn_z(angle_rad):
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _place(shape: ObjectShape, rng, at_m) -> np.ndarray:
    """(4, 4) table_from_object: a resting pose, turned, with the object's middle above `at_m`."""
    weights = np.array([pose.weight for pose in shape.resting_poses])
    pose = shape.resting_poses[rng.choice(len(weights), p=weights / weights.sum())]
    table_from_object = np.eye(4)
    table_from_object[:3, :3] = _turn_z(rng.uniform(0, 2 * np.pi)) @ pose.table_from_object
    points = shape.mesh.vertices_m @ table_from_object[:3, :3].T
    low, high = points.min(axis=0), points.max(axis=0)
    table_from_object[:3, 3] = [*(at_m - (low + high)[:2] / 2), -low[2]]
    return table_from_object


def _points_on_table(placed: PlacedObject) -> np.ndarray:
    """(N, 3) every third vertex, table frame."""
    pose = placed.table_from_object
    return placed.shape.mesh.vertices_m[::3] @ pose[:3, :3].T + pose[:3, 3]


def _place_objects(rng, families, count, fixed_family, split):
    placed: list[PlacedObject] = []
    footprints: list[np.ndarray] = []
    spread = 0.0 if count == 1 else 0.07 + 0.035 * count
    for i in range(count):
        family = fixed_family if i == 0 else families[int(rng.integers(len(families)))]
        shape = make_object(family, draw_seed(rng, split))
        texture_seed, gloss = draw_seed(rng, split), float(rng.uniform(0.0, 0.6) ** 1.5)
        for _ in range(60):
            at = rng.uniform(-spread, spread, 2)
            candidate = PlacedObject(len(placed) + 1, shape, texture_seed, _place(shape, rng, at), gloss)
            footprint = _points_on_table(candidate)[:, :2]
            gaps = [np.linalg.norm(footprint[:, None] - other[None], axis=-1).min() for other in footprints]
            if not gaps or min(gaps) > 0.012:
                placed.append(candidate)
                footprints.append(footprint[::4])
                break
    return tuple(placed)


def _look_at(rng, objects, camera):
    """(4, 4) cam_from_table that has every object in both views; None if this draw does not."""
    elevation = rng.uniform(np.radians(20), np.radians(64))
    distance = rng.uniform(0.55, 0.90)
    aim_off = rng.uniform(-1, 1, 2) * (0.16, 0.11)
    roll = np.radians(np.clip(rng.normal(0, 2), -5, 5))
    points = np.concatenate([_points_on_table(placed) for placed in objects])
    target = (points.min(axis=0) + points.max(axis=0)) / 2
    azimuth = rng.uniform(0, 2 * np.pi)
    back = np.array(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    )
    forward = -back
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    rotation = np.stack([right, down, forward])  # camera axes as rows
    yaw, pitch = np.arctan(aim_off)
    c, s = np.cos(yaw), np.sin(yaw)
    rotation = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ rotation
    c, s = np.cos(pitch), np.sin(pitch)
    rotation = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ rotation
    rotation = _turn_z(roll) @ rotation
    cam_from_table = np.eye(4)
    cam_from_table[:3, :3] = rotation
    # The middle of the two cameras is `distance` from the target.
    cam_from_table[:3, 3] = -rotation @ (target + back * distance) + [camera.baseline_m / 2, 0, 0]
    seen = points @ rotation.T + cam_from_table[:3, 3]
    width, height = camera.image_size
    margin = 0.015 * width
    for shift in (0.0, camera.baseline_m):
        pixels = camera.project(seen - [shift, 0, 0])
        if (
            pixels.min() < margin
            or pixels[:, 0].max() > width - margin
            or pixels[:, 1].max() > height - margin
        ):
            return None
    return cam_from_table


def draw_scene(
    seed: int, index: int, *, families, objects=(1, 1), image_size=(640, 480), split="train"
) -> Scene:
    """Draw scene number `index` of the data set `seed`. It depends on nothing else.

    Args:
        families: names of families, or objects; the first object's goes round them, the others' are drawn.
        objects: (fewest, most) objects.
        image_size: (width, height) px.
        split: one of splits.SPLITS; two splits share no shape, no texture and no other draw.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, index, split_number(split)]))
    width, height = image_size
    scale = width / 640
    camera = StereoCamera(
        image_size=(width, height),
        focal_px=float(round(600 * scale * rng.uniform(0.96, 1.04), 2)),
        centre_px=((width - 1) / 2, (height - 1) / 2),
        baseline_m=float(round(0.08 * rng.uniform(0.97, 1.03), 5)),
    )
    count = int(rng.integers(objects[0], objects[1] + 1))
    cam_from_table = None
    while cam_from_table is None:
        placed = _place_objects(rng, families, count, families[index % len(families)], split)
        for _ in range(40):
            cam_from_table = _look_at(rng, placed, camera)
            if cam_from_table is not None:
                break

    key = rng.uniform([-0.9, -0.9, 1.0], [0.9, 0.9, 2.0])
    fill = rng.uniform([-1.5, -1.5, 0.8], [1.5, 1.5, 1.8])
    tint = 1 + rng.uniform(-0.08, 0.08, 3)
    lights = (
        Light(key, np.clip(rng.uniform(0.35, 0.62) * tint, 0, 1), bool(rng.random() < 0.85)),
        Light(fill, np.clip(rng.uniform(0.05, 0.25) / tint, 0, 1), False),
    )
    return Scene(
        seed=seed,
        index=index,
        split=split,
        camera=camera,
        cam_from_table=cam_from_table,
        objects=placed,
        table_texture=str(rng.choice(TABLE_TEXTURES, p=[0.76, 0.14, 0.10])),
        table_texture_seed=draw_seed(rng, split),
        table_texture_size_m=float(rng.uniform(0.5, 1.1)),
        table_half_size_m=(float(rng.uniform(0.35, 1.0)), float(rng.uniform(0.35, 1.0))),
        table_turn_rad=float(rng.uniform(0, 2 * np.pi)),
        surface_seeds=(draw_seed(rng, split), draw_seed(rng, split)),
        room_m=(float(rng.uniform(1.3, 3.2)), float(rng.uniform(0.5, 0.9))),
        lights=lights,
        ambient=float(rng.uniform(0.22, 0.42)),
        sensor=Sensor(
            brightness=float(rng.uniform(80, 135)),
            gain=(1.0, float(rng.uniform(0.97, 1.03))),
            blur_px=float(rng.uniform(0.0, 0.6)),
            noise=float(rng.uniform(0.5, 2.0)),
        ),
    )
