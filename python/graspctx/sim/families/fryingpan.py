"""Frying pans: a flat lathe with a handle along +x."""

from dataclasses import replace

import numpy as np

from ..mesh import centre_of_mass_m, join, lathe
from .profile import along
from .resting import resting_poses
from .sections import HANDLE_REGION, PARTS_APART_M, oval_sections, rounded_ends, skin_sections
from .shape import ObjectShape
from .solids import lathe_solids, tube_solids

_SIDES = 96


def make_fryingpan(shape_seed: int) -> ObjectShape:
    """A frying pan; the grasp region is its handle, from the end to 1 - HANDLE_REGION off the wall."""
    rng = np.random.default_rng(shape_seed)
    rim = rng.uniform(0.070, 0.125)
    height = rng.uniform(0.028, 0.055)
    flare = height * rng.uniform(0.15, 0.75)
    wall = rng.uniform(0.0022, 0.0040)
    floor = rng.uniform(0.003, 0.006)
    rounding = rng.uniform(0.25, 0.5) * height
    foot = rim - flare

    # The outside goes from the foot in a bend to the rim; the inside is a wall's thickness further in.
    bend = np.linspace(0, np.pi / 2, 9)
    slope = np.arctan2(flare, height)
    bend_z = rounding * (1 - np.cos(bend))
    outer_r = foot + np.tan(slope) * bend_z - rounding * (1 - np.sin(bend)) * 0.8
    lip = wall / 2
    wall_z = np.linspace(rounding, height - lip, 8)[1:]
    outer = np.concatenate(
        [np.stack([outer_r, bend_z], 1), np.stack([foot + np.tan(slope) * wall_z, wall_z], 1)]
    )
    lip_turn = np.linspace(0, np.pi, 9)[1:]
    tip = outer[-1]
    lip_line = np.stack([tip[0] - lip + lip * np.cos(lip_turn), tip[1] + lip * np.sin(lip_turn)], 1)
    inner = outer[::-1][1:] - [wall, 0]
    inner = inner[inner[:, 1] > floor + 1e-4]
    inner_foot = np.interp(floor, outer[:, 1], outer[:, 0]) - wall
    profile = np.concatenate([[[0, 0], [0.5 * outer[0, 0], 0]], outer, lip_line, inner])
    profile = np.concatenate([profile, [[inner_foot - 0.0005, floor], [0.5 * inner_foot, floor], [0, floor]]])
    walked = along(profile)

    handle = rng.uniform(0.110, 0.190)
    half_width = rng.uniform(0.008, 0.0145)
    half_thick = half_width * rng.uniform(0.35, 0.75)
    start_z = rng.uniform(0.55, 0.8) * height
    start_z = min(start_z, height - lip - half_thick - 0.001)
    rise = rng.uniform(0.0, 0.28) * handle
    places, inset = rounded_ends(handle, 0.8 * half_thick, 0.006, [(1 - HANDLE_REGION) * handle])
    places, inset = places[5:], inset[5:]
    places[0] = 0.0
    s = places / handle
    neck = rng.uniform(0.55, 1.0)
    half = half_width * (neck + (1 - neck) * np.clip(s / 0.45, 0, 1) ** 2 * (3 - 2 * np.clip(s / 0.45, 0, 1)))
    curve = rng.uniform(0.0, 1.0)
    centres = np.stack([places, 0 * places, start_z + rise * (curve * s + (1 - curve) * s**2)], axis=1)
    rings = oval_sections(
        centres, [0, 1.0, 0], [0, 0, 1.0], half - inset, half_thick - inset, squareness=rng.uniform(0.5, 1.0)
    )
    # The handle starts in the middle of the wall.
    outside = np.concatenate([outer, [tip]])

    def outer_radius(z):
        return np.interp(z, outside[:, 1], outside[:, 0])

    rings[..., 0] += outer_radius(start_z)
    rings[0, :, 0] = np.sqrt((outer_radius(rings[0, :, 2]) - wall / 2) ** 2 - rings[0, :, 1] ** 2)

    unrolled = (2 * np.pi * rim, float(walked[-1] + along(centres)[-1] + 2 * PARTS_APART_M))
    v = walked / unrolled[1]
    body = lathe(profile[:, 0], profile[:, 1], v, sides=_SIDES)
    region = places[:-1] >= (1 - HANDLE_REGION) * handle - 1e-9
    v_handle = float(v[-1] + PARTS_APART_M / unrolled[1])
    grip, _ = skin_sections(rings, unrolled, v_handle, region=region)
    mesh = join(body, grip)
    border = (float(v[-1]) + v_handle) / 2
    rim_v = float(v[2 + len(outer) + 3])
    poses = resting_poses(mesh.vertices_m, centre_of_mass_m(mesh))
    # Pans are put down the right way up.
    poses = tuple(replace(p, weight=p.weight * (1.0 if p.name == "standing" else 0.15)) for p in poses)
    return ObjectShape(
        family="fryingpan",
        shape_seed=shape_seed,
        dimensions_m={
            "rim_radius": rim,
            "foot_radius": foot,
            "height": height,
            "wall": wall,
            "handle_length": handle,
            "handle_width": 2 * half_width,
            "handle_thickness": 2 * half_thick,
            "handle_rise": rise,
        },
        mesh=mesh,
        parts={
            "outside": (0.0, rim_v),
            "inside": (rim_v, border),
            "handle": (border, 1.0),
        },
        unrolled_m=unrolled,
        resting_poses=poses,
        region_name="handle",
        plain_share=0.6,
        solids_m=lathe_solids(profile[:, 0], profile[:, 1], sides=_SIDES) + tube_solids(rings),
    )
