"""Cartons: from a bar of soap to a box of cereals."""

from dataclasses import replace

import numpy as np

from ..mesh import centre_of_mass_m, rounded_box
from .resting import resting_poses
from .shape import ObjectShape

BOX_REGION = 0.4
"""The grasp region reaches over this share of a carton's longest edge, in the middle."""


def make_box(shape_seed: int) -> ObjectShape:
    """A carton; its grasp region is the narrow side, on both ends of the middle length: x = ± width / 2.

    Wherever a carton lies, a hand can close there: over the width when it lies flat, over the thickness when
    that side is up. The region has the middle of the two sides that the longest and the shortest edge bound,
    and a margin on the large faces beside them, where the fingers touch in the second case.
    """
    rng = np.random.default_rng(shape_seed)
    width = rng.uniform(0.045, 0.160)
    thickness = max(0.012, width * rng.uniform(0.15, 0.8))
    length = min(0.290, width * rng.uniform(1.15, 2.4))
    rounding = min(rng.uniform(0.0006, 0.003), thickness / 8)
    margin = min(0.020, 0.15 * width)

    border_x = width / 2 - margin
    border_z = length * (1 + BOX_REGION * np.array([-1, 1])) / 2
    unrolled = (2 * (width + thickness), length)
    mesh = rounded_box(
        (width, thickness, length),
        rounding,
        unrolled_m=unrolled,
        cuts_x_m=(-border_x, border_x),
        cuts_z_m=border_z,
    )
    x, _, z = mesh.vertices_m[mesh.faces].mean(axis=1).T
    mesh = replace(mesh, region=(np.abs(x) > border_x) & (z > border_z[0]) & (z < border_z[1]))
    # Cartons stand more often than they fall so.
    poses = resting_poses(mesh.vertices_m, centre_of_mass_m(mesh))
    poses = tuple(replace(pose, weight=pose.weight**0.5) for pose in poses)
    return ObjectShape(
        family="box",
        shape_seed=shape_seed,
        dimensions_m={"width": width, "thickness": thickness, "length": length, "margin": margin},
        mesh=mesh,
        parts={"outside": (0.0, 1.0)},
        unrolled_m=unrolled,
        resting_poses=poses,
        region_name="narrow side",
        plain_share=0.25,
        solids_m=(mesh.vertices_m,),
    )
