"""Cups without a handle: paper cups, tumblers, tea bowls."""

import numpy as np

from .bowl import bowl_side
from .profile import Section, foot_line, hollow_side, lying, split_at, turn_sections, upside_down
from .shape import ObjectShape, RestingPose

CUP_REGION = 0.5
"""The grasp region of a cup: this share of its height, in the middle of the outer wall."""


def make_cup(shape_seed: int) -> ObjectShape:
    """A hollow cup; the grasp region is the wall outside, halfway up.

    A hand closes round it as round a can. The rim is left to bowls, the handle to mugs: labels of one kind on
    different parts of alike objects spoil what is learned from them together.
    """
    rng = np.random.default_rng(shape_seed)
    kind = str(rng.choice(["paper", "tumbler", "tea"]))
    if kind == "paper":
        height, top = rng.uniform(0.070, 0.135), rng.uniform(0.034, 0.046)
        bottom = top * rng.uniform(0.64, 0.78)
        wall, rounding = rng.uniform(0.0012, 0.0020), 0.0006
        recess = rng.uniform(0.003, 0.008)
        floor = recess + rng.uniform(0.0015, 0.0025)
    elif kind == "tumbler":
        height, top = rng.uniform(0.075, 0.150), rng.uniform(0.029, 0.045)
        bottom = top * rng.uniform(0.70, 1.0)
        wall, rounding = rng.uniform(0.0018, 0.0040), rng.uniform(0.001, 0.005)
        recess, floor = 0.0, rng.uniform(0.004, 0.014)
    else:
        height, top = rng.uniform(0.045, 0.085), rng.uniform(0.034, 0.050)
        bottom = top * rng.uniform(0.42, 0.65)
        wall, rounding = rng.uniform(0.0025, 0.0045), 0.001
        recess = rng.uniform(0.0, 0.002)
        floor = rng.uniform(0.004, 0.007) + wall
    bead = rng.uniform(0.0018, 0.0028) if kind == "paper" else 0.0
    rim_start = height - (2 * bead or wall / 2)
    if kind == "tea":
        side_start = (bottom * rng.uniform(0.92, 1.0), rng.uniform(0.003, 0.006))
        side = bowl_side(rng, side_start, top, rim_start)
    else:
        bulge = rng.choice([0.0, rng.uniform(-0.06, 0.14)]) * top * (kind == "tumbler")
        z = np.linspace(4 * rounding, rim_start, 48)
        side = np.stack(
            [bottom + (top - bottom) * z / height + bulge * np.sin(np.pi * z / height), z], axis=1
        )
        side_start = side[0]
    rim, inside = hollow_side(side, wall, floor, min(2.5 * rounding, 0.01) if kind != "tea" else wall / 2)
    if bead:
        rim = _rolled_edge(rim[0], rim[-1], bead)
        inside = np.concatenate([rim[-1:], inside])
    below, grasped, above = split_at(side, height * (1 + CUP_REGION * np.array([-1, 1])) / 2)
    crest = int(np.argmax(rim[:, 1]))
    turned = turn_sections(
        [
            Section("outside", foot_line(bottom, side_start, rounding, recess)),
            Section("outside", below),
            Section("outside", grasped, region=True),
            Section("outside", above),
            Section("outside", rim[: crest + 1]),
            Section("inside", rim[crest:]),
            Section("inside", inside),
        ],
        sides=72,
    )
    return ObjectShape(
        family="cup",
        shape_seed=shape_seed,
        dimensions_m={
            "height": float(turned.profile[:, 1].max()),
            "top_radius": top,
            "bottom_radius": bottom,
            "wall": wall,
        },
        mesh=turned.mesh,
        parts=turned.parts,
        unrolled_m=(2 * np.pi * top, turned.length_m),
        resting_poses=(
            RestingPose("standing", 0.80, np.eye(3)),
            upside_down(0.10),
            *([lying(turned.profile, 0.10)] if kind != "tea" else []),
        ),
        region_name="wall",
        plain_share=0.3,
        solids_m=turned.solids_m,
    )


def _rolled_edge(outer_end, inner_end, bead_m):
    """(P, 2) the bead of a paper cup's rim: out from the wall, round, and back to its inner side."""
    centre = np.array([inner_end[0] + bead_m, outer_end[1] + bead_m])
    angle = np.linspace(-np.pi / 2, np.pi, 19)[:, None]
    circle = centre + bead_m * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([[outer_end], circle])
