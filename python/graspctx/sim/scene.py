"""What stands in a scene: cameras, table, objects, room, light; drawn from a seed, before rendering."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .camera import StereoCamera, Viewpoint
from .difficulty import DEFAULT, Difficulty
from .families import ObjectShape
from .placing import PlacedObject, place_objects, visible_shares
from .sensor import Sensor
from .splits import draw_seed, split_number

PLACINGS, VIEWS, LEANINGS = 24, 40, 10
"""How often to place objects anew, to look at each placing anew, to lean one if that is asked for."""


class NoViewError(ValueError):
    """Objects do not fit into the views with the distances and fields of view that are asked for."""


@dataclass(frozen=True)
class Light:
    """A far light, from `position_m` (table frame) to the table's middle; RGB strength in [0, 1]."""

    position_m: np.ndarray
    strength: np.ndarray
    casts_shadow: bool


@dataclass(frozen=True)
class Table:
    """The table top, its middle at the origin of the table frame.

    Attributes:
        texture: kind, one of surfaces.SURFACE_KINDS.
        texture_size_m: how much of the table the texture covers before it repeats.
        half_size_m: half the width and depth.
        turn_rad: turn about z.
    """

    texture: str
    texture_seed: int
    texture_size_m: float
    half_size_m: tuple[float, float]
    turn_rad: float


@dataclass(frozen=True)
class Background:
    """Walls and floor.

    Attributes:
        kind: "wall", "room" or "far", as in Difficulty.
        texture: kind, one of surfaces.SURFACE_KINDS.
        texture_seeds: of the floor and of the walls.
        walls: for each wall the angle about z at which it stands, and its distance from the table's middle.
        floor_m: height of the table over the floor.
    """

    kind: str
    texture: str
    texture_seeds: tuple[int, int]
    walls: tuple[tuple[float, float], ...]
    floor_m: float


@dataclass(frozen=True)
class Scene:
    """Everything that is rendered. Table frame: z up, table surface at z = 0.

    Attributes:
        seed, index: the data set's seed and the scene's place in it.
        split: of its shapes, textures and everything else that is drawn; see splits.py.
        cam_from_table: (4, 4) left camera.
        spacing: of the objects, "apart" or "touching".
    """

    seed: int
    index: int
    split: str
    camera: StereoCamera
    viewpoint: Viewpoint
    cam_from_table: np.ndarray
    objects: tuple[PlacedObject, ...]
    spacing: str
    table: Table
    background: Background
    lights: tuple[Light, ...]
    ambient: float
    sensor: Sensor

    @property
    def table_plane(self) -> tuple[np.ndarray, float]:
        """(normal (3,), offset_m) in the left camera's frame: normal · P + offset_m is the height of P."""
        normal = self.cam_from_table[:3, 2]
        return normal, float(-normal @ self.cam_from_table[:3, 3])


def draw_scene(
    seed: int,
    index: int,
    *,
    families: list[str | ObjectShape],
    objects: tuple[int, int] = (1, 1),
    image_size: tuple[int, int] = (640, 480),
    split: str = "train",
    difficulty: Difficulty = DEFAULT,
) -> Scene:
    """Draw scene number `index` of the data set `seed`. It depends on nothing else.

    Args:
        families: names of families, or objects; the first object's goes round them, the others' are drawn.
        objects: (fewest, most) objects; (0, 0) leaves the table empty. Scenes in which something leans or is
            to be hidden have at least two.
        image_size: (width, height) px.
        split: one of splits.SPLITS; two splits share no shape, no texture and no other draw.
        difficulty: what the axes are drawn from. Where the objects do not allow an occlusion, a pose or a
            spacing the scene has what comes near; scene.json says what it has.

    Raises:
        NoViewError: the objects do not fit into the views.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, index, split_number(split)]))
    camera = _draw_camera(rng, image_size, difficulty)
    count = int(rng.integers(objects[0], objects[1] + 1))
    if set(difficulty.pose) == {"leaning"} or difficulty.occlusion[0] > 0:
        count = max(count, 2)
    placed, spacing, viewpoint, cam_from_table = _draw_view(
        rng, camera, families, count, families[index % len(families)], split, difficulty
    )
    table = _draw_table(rng, placed, split, difficulty)
    background = _draw_background(rng, placed, cam_from_table, viewpoint, split, difficulty)
    lights, ambient = _draw_lights(rng, background, viewpoint, difficulty)
    return Scene(
        seed=seed,
        index=index,
        split=split,
        camera=camera,
        viewpoint=viewpoint,
        cam_from_table=cam_from_table,
        objects=placed,
        spacing=spacing,
        table=table,
        background=background,
        lights=lights,
        ambient=ambient,
        sensor=Sensor(
            brightness=difficulty.draw(rng, "brightness"),
            exposure_ratio=difficulty.draw(rng, "exposure_ratio"),
            blur_px=difficulty.draw(rng, "blur_px"),
            noise=difficulty.draw(rng, "noise"),
            vertical_offset_px=difficulty.draw(rng, "vertical_offset_px"),
        ),
    )


def _draw_camera(rng, image_size, difficulty):
    width, height = image_size
    half_view = np.radians(difficulty.draw(rng, "fov_deg")) / 2
    return StereoCamera(
        image_size=(width, height),
        focal_px=float(round(width / 2 / np.tan(half_view), 2)),
        centre_px=((width - 1) / 2, (height - 1) / 2),
        baseline_m=float(round(difficulty.draw(rng, "baseline_m"), 5)),
    )


def _draw_view(rng, camera, families, count, first_family, split, difficulty):
    """Place objects and look at them until both views have all of them, hidden as much as asked for."""
    lowest, highest = difficulty.occlusion
    best, best_miss = None, np.inf
    for placing in range(PLACINGS):
        placed, spacing = place_objects(rng, families, count, first_family, split, difficulty)
        leans = any(item.pose == "leaning" for item in placed)
        if set(difficulty.pose) == {"leaning"} and not leans and placing < LEANINGS - 1:
            continue
        points = np.concatenate([item.points_m for item in placed] or [np.zeros((1, 3))])
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        seen_from = 0
        for _ in range(VIEWS):
            viewpoint = Viewpoint(
                azimuth_deg=_draw_azimuth_deg(rng, placed, towards_one=lowest > 0),
                elevation_deg=difficulty.draw(rng, "elevation_deg"),
                roll_deg=difficulty.draw(rng, "roll_deg"),
                distance_m=difficulty.draw(rng, "distance_m"),
                aim=tuple(rng.uniform(-1, 1, 2) * (0.16, 0.11)),
            )
            cam_from_table = viewpoint.cam_from_table(middle, camera.baseline_m)
            seen = points @ cam_from_table[:3, :3].T + cam_from_table[:3, 3]
            if not camera.sees_all(seen, margin_px=0.015 * camera.image_size[0]):
                continue
            view = placed, spacing, viewpoint, cam_from_table
            if len(placed) <= 1 and lowest == 0:
                return view
            hidden = 1 - visible_shares(camera, cam_from_table, placed).min()
            miss = max(lowest - hidden, hidden - highest, 0.0)
            if miss == 0:
                return view
            if miss < best_miss:
                best, best_miss = view, miss
            seen_from += 1
            if seen_from == 12:
                break
    if best is None:
        raise NoViewError(
            f"scene does not fit: {count} objects at distance_m {difficulty.distance_m} with fov_deg "
            f"{difficulty.fov_deg} are not within both views; ask for fewer objects or a greater distance"
        )
    return best


def _draw_azimuth_deg(rng, placed, *, towards_one):
    """Any direction; or one in which two objects stand behind each other."""
    azimuth = rng.uniform(0, 360)
    if not towards_one or len(placed) < 2:
        return float(azimuth)
    first, second = rng.choice(len(placed), 2, replace=False)
    apart = placed[first].points_m[:, :2].mean(axis=0) - placed[second].points_m[:, :2].mean(axis=0)
    return float(np.degrees(np.arctan2(apart[1], apart[0])) + rng.normal(0, 12))


def _draw_table(rng, placed, split, difficulty):
    reach = max((np.linalg.norm(item.points_m[:, :2], axis=1).max() for item in placed), default=0.0)
    half_size = np.maximum(rng.uniform(0.35, 1.0, 2), reach + 0.03)
    return Table(
        texture=difficulty.choose(rng, "table"),
        texture_seed=draw_seed(rng, split),
        texture_size_m=float(rng.uniform(0.5, 1.1)),
        half_size_m=(float(half_size[0]), float(half_size[1])),
        turn_rad=float(rng.uniform(0, 2 * np.pi)),
    )


def _draw_background(rng, placed, cam_from_table, viewpoint, split, difficulty):
    kind = difficulty.choose(rng, "background")
    table_from_cam = np.linalg.inv(cam_from_table)
    # All walls are behind the cameras and the objects.
    room = float(np.abs(table_from_cam[:2, 3]).max() * np.sqrt(2) + 0.3)
    distance = {"wall": (1.3, 3.2), "room": (1.3, 3.2), "far": (3.6, 5.0)}[kind]
    distance = max(float(rng.uniform(*distance)), room)
    turn = rng.uniform(0, 2 * np.pi)
    walls = [(float(turn + side * np.pi / 2), distance) for side in range(4)]
    behind = np.radians(viewpoint.azimuth_deg + 180 + rng.uniform(-35, 35))
    outwards = np.array([np.cos(behind), np.sin(behind)])
    reach = max(((item.points_m[:, :2] @ outwards).max() for item in placed), default=0.0)
    close = float(max(reach, 0.0) + rng.uniform(0.04, 0.45))
    if kind == "wall":
        walls.append((float(behind), close))
    return Background(
        kind=kind,
        texture=difficulty.choose(rng, "background_texture"),
        texture_seeds=(draw_seed(rng, split), draw_seed(rng, split)),
        walls=tuple(walls),
        floor_m=float(rng.uniform(0.5, 0.9)),
    )


def _draw_lights(rng, background, viewpoint, difficulty):
    key = rng.uniform([-0.9, -0.9, 1.0], [0.9, 0.9, 2.0])
    fill = rng.uniform([-1.5, -1.5, 0.8], [1.5, 1.5, 1.8])
    if background.kind == "wall":
        # The lamp is on this side of the wall.
        for light in (key, fill):
            angle = background.walls[-1][0]
            outwards = np.array([np.cos(angle), np.sin(angle), 0])
            light -= 2 * max(light @ outwards, 0.0) * outwards
    tint = 1 + rng.uniform(-0.08, 0.08, 3)
    lights = (
        Light(
            key,
            np.clip(rng.uniform(0.35, 0.62) * tint, 0, 1),
            difficulty.choose(rng, "shadow") == "cast",
        ),
        Light(fill, np.clip(rng.uniform(0.05, 0.25) / tint, 0, 1), False),
    )
    return lights, float(rng.uniform(0.22, 0.42))
