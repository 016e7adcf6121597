"""Erasers: small rounded blocks, some in a paper sleeve."""

from dataclasses import replace

import numpy as np

from ..mesh import centre_of_mass_m, rounded_box
from .resting import resting_poses
from .shape import ObjectShape

ERASER_REGION = 0.4
"""The grasp region of an eraser: this share of its length, in the middle."""


def make_eraser(shape_seed: int) -> ObjectShape:
    """A block, maybe in a sleeve; the grasp region is the middle of its two narrow sides, x = ± width / 2."""
    rng = np.random.default_rng(shape_seed)
    length = rng.uniform(0.032, 0.075)
    width = min(rng.uniform(0.014, 0.034), length / 1.3)
    thickness = max(0.007, width * rng.uniform(0.38, 0.75))
    rounding = min(rng.uniform(0.0008, 0.0045), 0.3 * thickness)
    margin = max(0.25 * width, 1.3 * rounding)
    border_x = width / 2 - margin
    border_z = length * (1 + ERASER_REGION * np.array([-1, 1])) / 2

    bare = length - 2 * rounding  # a sleeve ends where the rounding starts, or before
    sleeve, band = 0.0, None
    if rng.random() < 0.55:
        sleeve = bare * rng.uniform(0.45, 0.85)
        start = rounding + 1e-4 + (bare - sleeve - 2e-4) * rng.choice([0.0, 1.0, rng.random()])
        band = (start, start + sleeve, rng.uniform(0.0003, 0.0006))
    unrolled = (2 * (width + thickness), length + sleeve)
    mesh = rounded_box(
        (width, thickness, length),
        rounding,
        unrolled_m=unrolled,
        step_m=0.005,
        cuts_x_m=(-border_x, border_x),
        cuts_z_m=border_z,
        band=band,
    )
    points = mesh.vertices_m
    parts, solids = {"outside": (0.0, 1.0)}, (points,)
    if band:
        parts = {"rubber": (0.0, length / unrolled[1]), "outside": (length / unrolled[1], 1.0)}
        beside = (np.abs(points[:, 0]) <= width / 2 + 1e-9) & (np.abs(points[:, 1]) <= thickness / 2 + 1e-9)
        in_band = (points[:, 2] >= band[0] - 1e-9) & (points[:, 2] <= band[1] + 1e-9)
        solids = (points[beside], points[in_band])
    x, _, z = mesh.vertices_m[mesh.faces].mean(axis=1).T
    mesh = replace(mesh, region=(np.abs(x) > border_x) & (z > border_z[0]) & (z < border_z[1]))
    return ObjectShape(
        family="eraser",
        shape_seed=shape_seed,
        dimensions_m={
            "length": length,
            "width": width,
            "thickness": thickness,
            "margin": margin,
            "sleeve": sleeve,
        },
        mesh=mesh,
        parts=parts,
        unrolled_m=unrolled,
        resting_poses=resting_poses(mesh.vertices_m, centre_of_mass_m(mesh)),
        region_name="middle",
        plain_share=0.5,
        solids_m=solids,
    )
