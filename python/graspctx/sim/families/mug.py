"""Mugs: a hollow lathe with a handle along +x."""

import numpy as np

from ..mesh import join, tube
from .handle import side_handle
from .profile import (
    Section,
    centre_height,
    foot_line,
    hollow_side,
    lying_tilt,
    rotation_to_side,
    turn_sections,
    upside_down,
)
from .shape import ObjectShape, RestingPose
from .solids import tube_solids


def _lying_mug(profile, handle_m):
    """The two poses of a mug on its side: it rolls until the handle touches the table, left or right."""
    centre = centre_height(profile)
    middle, slope = lying_tilt(profile, centre)
    tilt = np.arctan(slope)
    # Signed distance beyond the resting plane, for a handle turned by `turn` away from straight down.
    turns = np.linspace(0, np.pi, 721)
    down = np.cos(turns)[:, None] * handle_m[:, 0] + np.sin(turns)[:, None] * handle_m[:, 1]
    beyond = (down - slope * (handle_m[:, 2] - centre) - middle).max(axis=1)
    turn = turns[np.argmax(beyond <= 0)]
    # Object +x (the handle) goes to -x (down) at a turn of pi.
    return [rotation_to_side(tilt, np.pi + sign * turn) for sign in (-1, 1)]


def make_mug(shape_seed: int) -> ObjectShape:
    """A hollow mug with a handle; the grasp region is the handle."""
    rng = np.random.default_rng(shape_seed)
    height = rng.uniform(0.070, 0.125)
    top = rng.uniform(0.031, 0.050)
    bottom = top * rng.choice([1.0, rng.uniform(0.7, 1.0), rng.uniform(1.0, 1.15)])
    bulge = rng.choice([0.0, rng.uniform(-0.12, 0.0), rng.uniform(0.0, 0.2)]) * top
    wall = rng.uniform(0.003, 0.0055)
    rounding = rng.uniform(0.002, 0.014)
    recess = rng.choice([0.0, rng.uniform(0.001, 0.003)])
    floor = recess + rng.uniform(0.004, 0.009)

    def outer_radius(z):
        s = np.clip(z / height, 0, 1)
        return bottom + (top - bottom) * s + bulge * np.sin(np.pi * s)

    z = np.linspace(1.5 * rounding, height - wall / 2, 48)
    side = np.stack([outer_radius(z), z], axis=1)
    foot = foot_line(float(outer_radius(0.0)), side[0], rounding, recess)
    rim, inside = hollow_side(side, wall, floor, rounding)
    crest = int(np.argmax(rim[:, 1]))
    outside = np.concatenate([foot, side[1:], rim[1 : crest + 1]])
    turned = turn_sections(
        [Section("outside", outside), Section("inside", rim[crest:]), Section("inside", inside)], sides=80
    )
    rings, handle_sizes = side_handle(
        rng,
        outer_radius,
        wall / 2,
        (rounding + 0.002, height - 0.005),
        reach_m=rng.uniform(0.020, 0.042),
        width_m=rng.uniform(0.008, 0.020),
        thickness_m=rng.uniform(0.005, 0.010),
    )
    around = 2 * np.pi * top
    # The pattern runs on from the wall over the handle: no seam where the grasp region begins.
    radius = np.hypot(rings[..., 0], rings[..., 1])
    wall_radius = outer_radius(rings[..., 2])
    u = np.arctan2(rings[..., 1], rings[..., 0]) * wall_radius + 0.8 * (radius - wall_radius)
    handle = tube(rings, np.stack([u / around, turned.v_at(rings[..., 2])], axis=-1), region=True)
    lying = _lying_mug(turned.profile, handle.vertices_m)
    return ObjectShape(
        family="mug",
        shape_seed=shape_seed,
        dimensions_m={
            "height": float(turned.profile[:, 1].max()),
            "top_radius": top,
            "bottom_radius": bottom,
            "wall": wall,
            **handle_sizes,
        },
        mesh=join(turned.mesh, handle),
        parts=turned.parts,
        unrolled_m=(around, turned.length_m),
        resting_poses=(
            RestingPose("standing", 0.84, np.eye(3)),
            upside_down(0.04),
            RestingPose("lying", 0.06, lying[0]),
            RestingPose("lying", 0.06, lying[1]),
        ),
        region_name="handle",
        plain_share=0.3,
        solids_m=turned.solids_m + tube_solids(rings),
    )
