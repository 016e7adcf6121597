"""Bowls: wide, open, on a foot."""

import numpy as np

from .profile import Section, bezier, foot_line, hollow_side, split_at, turn_sections, upside_down
from .shape import ObjectShape, RestingPose


def bowl_side(rng, start, top_m: float, height_m: float) -> np.ndarray:
    """(P, 2) a round outer side from `start`, (radius, height), to the rim; from full to steep or flaring."""
    foot, low = start
    fullness, steepness = rng.uniform(0.25, 0.85), rng.uniform(0.2, 0.6)
    flare = rng.choice([0.0, rng.uniform(0.0, 0.12)]) * top_m
    return bezier(
        start,
        (foot + fullness * (top_m - foot), low + 0.04 * (height_m - low)),
        (top_m - flare, low + (1 - steepness) * (height_m - low)),
        (top_m, height_m),
        48,
    )


def make_bowl(shape_seed: int) -> ObjectShape:
    """A rice, cereal, salad or mixing bowl; the grasp region is the rim, outside and inside."""
    rng = np.random.default_rng(shape_seed)
    top = rng.uniform(0.050, 0.125)
    height = top * rng.uniform(0.52, 1.05)
    foot = top * rng.uniform(0.36, 0.62)
    foot_height = rng.uniform(0.003, 0.009)
    wall = rng.uniform(0.0026, 0.0055)
    recess = rng.uniform(0.0, 0.6) * foot_height
    floor = foot_height + wall * rng.uniform(0.9, 1.4)
    rim_depth = np.clip(0.22 * height, 0.010, 0.020)

    side_start = (foot * rng.uniform(0.93, 1.0), foot_height)
    side = bowl_side(rng, side_start, top, height - wall / 2)
    rim, inside = hollow_side(side, wall, floor, rng.uniform(0.3, 0.9) * wall)
    below, grasped_outside = split_at(side, [height - rim_depth])
    floor_side, grasped_inside = split_at(inside[:-1][::-1], [height - rim_depth])
    crest = int(np.argmax(rim[:, 1]))
    turned = turn_sections(
        [
            Section("outside", foot_line(foot, side_start, min(0.0015, foot_height / 4), recess)),
            Section("outside", below),
            Section("outside", grasped_outside, region=True),
            Section("outside", rim[: crest + 1], region=True),
            Section("inside", rim[crest:], region=True),
            Section("inside", grasped_inside[::-1], region=True),
            Section("inside", np.concatenate([floor_side[::-1], inside[-1:]])),
        ],
        sides=96,
    )
    return ObjectShape(
        family="bowl",
        shape_seed=shape_seed,
        dimensions_m={
            "height": float(turned.profile[:, 1].max()),
            "top_radius": top,
            "foot_radius": foot,
            "wall": wall,
            "rim_depth": float(rim_depth),
        },
        mesh=turned.mesh,
        parts=turned.parts,
        unrolled_m=(2 * np.pi * top, turned.length_m),
        resting_poses=(RestingPose("standing", 0.92, np.eye(3)), upside_down(0.08)),
        region_name="rim",
        plain_share=0.35,
        solids_m=turned.solids_m,
    )
