"""Put objects on the table: which way they rest, how far apart, and how much of each a camera sees."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .camera import StereoCamera
from .difficulty import Difficulty
from .families import ObjectShape, make_object
from .geometry import gap_m, outline, surface_points
from .leaning import lean
from .splits import draw_seed

APART_M, TOUCHING_M = 0.012, 0.0006
PROP_HEIGHT_M = 0.03
"""What others lean on is at least this high."""


@dataclass(frozen=True)
class PlacedObject:
    """An object in the scene.

    Attributes:
        id: 1, 2, … as in the masks.
        table_from_object: (4, 4).
        pose: name of the resting pose, or "leaning".
        leans_on: id of the object it leans on.
        gloss: specular strength in [0, 1].
    """

    id: int
    shape: ObjectShape
    texture_seed: int
    table_from_object: np.ndarray
    pose: str
    leans_on: int | None
    gloss: float

    @property
    def points_m(self) -> np.ndarray:
        """(V, 3) the mesh's vertices, table frame."""
        return self.shape.mesh.vertices_m @ self.table_from_object[:3, :3].T + self.table_from_object[:3, 3]


def place_objects(
    rng,
    families: list[str | ObjectShape],
    count: int,
    first_family: str | ObjectShape,
    split: str,
    difficulty: Difficulty,
) -> tuple[tuple[PlacedObject, ...], str]:
    """Draw objects and put them around the table's middle.

    An object for which there is no room is left out; one that finds nothing to lean on rests by itself.

    Returns:
        The objects, by id, and their spacing ("apart" or "touching").
    """
    spacing = difficulty.choose(rng, "spacing")
    drawn = []
    for i in range(count):
        family = first_family if i == 0 else families[int(rng.integers(len(families)))]
        shape = make_object(family, draw_seed(rng, split))
        texture_seed, gloss = draw_seed(rng, split), float(rng.uniform(0.0, 0.6) ** 1.5)
        drawn.append(
            PlacedObject(i, shape, texture_seed, np.eye(4), difficulty.choose(rng, "pose"), None, gloss)
        )
    spread = 0.0 if count == 1 else 0.07 + 0.035 * count
    # One leans at most half of the objects: somebody has to carry them.
    leaners = [i for i, item in enumerate(drawn) if item.pose == "leaning"][: count // 2]
    resting = [i for i in range(count) if i not in leaners]
    placed: dict[int, PlacedObject] = {}
    for i in resting:
        candidate = _place_resting(rng, drawn[i], list(placed.values()), spread, spacing)
        if candidate:
            placed[i] = candidate
    for i in leaners:
        candidate = _place_leaning(rng, drawn[i], list(placed.values()))
        if candidate is None:
            candidate = _place_resting(rng, drawn[i], list(placed.values()), spread, spacing)
        if candidate:
            placed[i] = candidate
    ids = {i: number for number, i in enumerate(sorted(placed), start=1)}
    objects = tuple(
        replace(
            placed[i], id=ids[i], leans_on=None if placed[i].leans_on is None else ids[placed[i].leans_on]
        )
        for i in sorted(placed)
    )
    return objects, spacing if len(objects) > 1 else "apart"  # what stands alone touches nothing


def _turn_z(angle_rad):
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _rest(rng, item: PlacedObject) -> PlacedObject:
    """In a resting pose, turned, with the object's middle above the table's."""
    poses = [pose for pose in item.shape.resting_poses if pose.name == item.pose] or item.shape.resting_poses
    weights = np.array([pose.weight for pose in poses])
    pose = poses[rng.choice(len(weights), p=weights / weights.sum())]
    table_from_object = np.eye(4)
    table_from_object[:3, :3] = _turn_z(rng.uniform(0, 2 * np.pi)) @ pose.table_from_object
    points = item.shape.mesh.vertices_m @ table_from_object[:3, :3].T
    low, high = points.min(axis=0), points.max(axis=0)
    table_from_object[:3, 3] = [*(-(low + high)[:2] / 2), -low[2]]
    return replace(item, table_from_object=table_from_object, pose=pose.name)


def _moved(item: PlacedObject, by_m) -> PlacedObject:
    table_from_object = item.table_from_object.copy()
    table_from_object[:2, 3] += by_m
    return replace(item, table_from_object=table_from_object)


def _place_resting(rng, item, others, spread_m, spacing):
    rested = _rest(rng, item)
    footprint = outline(rested.points_m[:, :2])
    outlines = [outline(other.points_m[:, :2]) for other in others]
    for _ in range(60):
        at = rng.uniform(-spread_m, spread_m, 2)
        gaps = [gap_m(footprint + at, other) for other in outlines]
        if not gaps or min(gaps) > APART_M:
            break
    else:
        return None
    if spacing == "touching" and gaps:
        nearest = outlines[int(np.argmin(gaps))].mean(axis=0)
        clear, near = 0.0, 1.0  # shares of the way to the nearest object's middle
        for _ in range(20):
            share = (clear + near) / 2
            there = footprint + at + share * (nearest - at)
            if min(gap_m(there, other) for other in outlines) > TOUCHING_M:
                clear = share
            else:
                near = share
        at = at + clear * (nearest - at)
    return _moved(rested, at)


def _place_leaning(rng, item, others):
    props = [other for other in others if np.ptp(other.points_m[:, 2]) > PROP_HEIGHT_M]
    for prop in [props[k] for k in rng.permutation(len(props))[:2]]:
        table_from_object = lean(rng, item, prop, [other for other in others if other is not prop])
        if table_from_object is not None:
            return replace(item, table_from_object=table_from_object, pose="leaning", leans_on=prop.id)
    return None


def visible_shares(
    camera: StereoCamera, cam_from_table: np.ndarray, objects: tuple[PlacedObject, ...]
) -> np.ndarray:
    """(N,) about how much of what the left camera would see of each object alone it sees with the others."""
    cell_px = camera.image_size[0] / 128
    columns, rows = 128, int(np.ceil(camera.image_size[1] / cell_px))
    nearest = np.full((len(objects), columns * rows), np.inf)
    for k, item in enumerate(objects):
        cam_from_object = cam_from_table @ item.table_from_object
        points = surface_points(item.shape.mesh, 4000) @ cam_from_object[:3, :3].T + cam_from_object[:3, 3]
        column, row = np.clip(camera.project(points) / cell_px, 0, [columns - 1, rows - 1]).astype(int).T
        np.minimum.at(nearest[k], row * columns + column, points[:, 2])
    covered = np.isfinite(nearest)
    seen = covered & (nearest <= nearest.min(axis=0))
    return seen.sum(axis=1) / np.maximum(covered.sum(axis=1), 1)
