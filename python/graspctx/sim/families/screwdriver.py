"""Screwdrivers: a thick handle and a thin shaft along z, from the handle's end to the tip."""

import numpy as np

from ..mesh import centre_of_mass_m
from .resting import resting_poses
from .sections import HANDLE_REGION, PARTS_APART_M, oval_sections, rounded_ends, skin_sections
from .shape import ObjectShape
from .solids import tube_solids

_SIDES = 24


def make_screwdriver(shape_seed: int) -> ObjectShape:
    """A screwdriver, flat or pointed; the grasp region is its handle, up to HANDLE_REGION of its length."""
    rng = np.random.default_rng(shape_seed)
    handle = rng.uniform(0.070, 0.120)
    radius = rng.uniform(0.0095, 0.0180)
    shaft = rng.uniform(0.060, 0.180)
    shaft_radius = rng.uniform(0.0022, min(0.0045, 0.33 * radius))
    flat_blade = rng.random() < 0.5
    region_end = HANDLE_REGION * handle

    places, inset = rounded_ends(handle, rng.uniform(0.2, 0.6) * radius, 0.005, [region_end])
    s = places / handle
    waist = rng.uniform(0.0, 0.4) * np.exp(-(((s - rng.uniform(0.72, 0.9)) / 0.1) ** 2))
    taper = rng.uniform(-0.05, 0.2)
    half = np.maximum(radius * (1 - waist - taper * s) - inset, 1.3 * shaft_radius)
    # Flutes, a hexagon, or neither: as shares of the radius at each side.
    style = rng.choice(["round", "flutes", "hexagon"])
    turn = 2 * np.pi * np.arange(_SIDES) / _SIDES
    depth = {"round": 0.0, "flutes": min(0.09, 0.0007 / radius), "hexagon": 0.0}[style]
    scale = 1 - depth * (0.5 + 0.5 * np.cos(6 * turn))
    if style == "hexagon":
        rounded = rng.uniform(0.3, 0.9)
        scale = 1 - rounded * (1 - np.cos(np.pi / 6) / np.cos((turn + np.pi / 6) % (np.pi / 3) - np.pi / 6))
    even = np.clip(np.minimum(s, 1 - s) / 0.08, 0, 1)[:, None]

    def rings(z, half_x, half_y, squareness=1.0):
        centres = np.stack([0 * z, 0 * z, z], axis=1)
        return oval_sections(
            centres, [1.0, 0, 0], [0, 1.0, 0], half_x, half_y, squareness=squareness, sides=_SIDES
        )

    grip = rings(places, half, half)
    grip[..., :2] *= (1 - even + even * scale)[..., None]
    total = handle + shaft
    if flat_blade:
        blade = shaft_radius * rng.uniform(4.0, 6.0)
        z = np.array([handle, total - blade, total - 0.4 * blade, total])
        half_x = shaft_radius * np.array([1, 1, rng.uniform(1.0, 1.5), rng.uniform(1.0, 1.5)])
        half_y = shaft_radius * np.array([1, 1, 0.3, 0.16])
        rod = rings(z, half_x, half_y, np.array([1, 1, 0.6, 0.4]))
    else:
        point = shaft_radius * rng.uniform(1.5, 3.0)
        half = shaft_radius * np.array([1, 1, 0.35])
        rod = rings(np.array([handle, total - point, total]), half, half)
    spaced = np.linspace(handle, rod[1, 0, 2], int(np.ceil((rod[1, 0, 2] - handle) / 0.008)) + 1)
    rod = np.concatenate([rings(spaced, shaft_radius, shaft_radius), rod[2:]])

    all_rings = np.concatenate([grip, rod])
    unrolled = (2 * np.pi * radius, float(total + PARTS_APART_M))
    region = all_rings[1:, 0, 2] <= region_end + 1e-9
    mesh, _ = skin_sections(all_rings, unrolled, region=region)
    v_shaft = handle / unrolled[1]
    parts = {"handle": (0.0, v_shaft), "shaft": (v_shaft, 1.0)}
    if rng.random() < 0.3:
        start = rng.uniform(0.1, 0.5) * v_shaft
        end = rng.choice([rng.uniform(0.6, 0.78), 1.0]) * v_shaft
        parts["grip"] = (start, float(end))
    return ObjectShape(
        family="screwdriver",
        shape_seed=shape_seed,
        dimensions_m={
            "handle_length": handle,
            "handle_radius": radius,
            "shaft_length": shaft,
            "shaft_radius": shaft_radius,
        },
        mesh=mesh,
        parts=parts,
        unrolled_m=unrolled,
        resting_poses=resting_poses(mesh.vertices_m, centre_of_mass_m(mesh)),
        region_name="handle",
        plain_share=0.6,
        solids_m=(*tube_solids(grip), *tube_solids(rod)),
    )
