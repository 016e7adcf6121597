"""Pencils: prisms and cylinders, sharpened or not."""

import numpy as np

from ..mesh import lathe
from .profile import rotation_to_side, texture_v
from .shape import ObjectShape, RestingPose
from .solids import lathe_solids

PENCIL_REGION = 0.4
"""The grasp region of a pencil: this share of its length, in the middle."""


def make_pencil(shape_seed: int) -> ObjectShape:
    """A prism or a cylinder, sharpened or not, maybe with an eraser; the grasp region is its middle."""
    rng = np.random.default_rng(shape_seed)
    length = rng.uniform(0.110, 0.195)
    radius = rng.uniform(0.0034, 0.0058)
    sides = int(rng.choice([6, 6, 32, 3])) if radius > 0.0042 else int(rng.choice([6, 6, 32]))
    apothem = radius * np.cos(np.pi / sides)
    sharpened = rng.random() < 0.85
    eraser = rng.random() < 0.4
    cone = radius * rng.uniform(4.0, 7.0) if sharpened else 0.0

    profile, parts = [(0.0, 0.0)], {}
    if sharpened:
        lead = rng.uniform(0.18, 0.3)
        profile += [
            (0.12 * radius, 0.0),
            (lead * radius, lead * cone),
            (apothem * 0.98, cone),
            (radius, cone),
        ]
    else:
        profile += [(radius, 0.0)]
    ferrule = length - rng.uniform(0.016, 0.026) if eraser else length
    middle = length * (1 + PENCIL_REGION * np.array([-1, 1])) / 2
    profile += [(radius, z) for z in np.linspace(profile[-1][1], middle[0], 8)[1:]]
    profile += [(radius, z) for z in np.linspace(*middle, 9)[1:]]
    profile += [(radius, z) for z in np.linspace(middle[1], ferrule, 8)[1:]]
    if eraser:
        metal = apothem * 0.99
        band = (length - ferrule) * rng.uniform(0.45, 0.65)
        profile += [(metal, ferrule), (metal, ferrule + band), (metal * 0.93, ferrule + band)]
        profile += [(metal * 0.93, length - 0.2 * radius), (metal * 0.7, length)]
    profile = np.array([*profile, (0.0, length)])

    z = profile[:, 1]
    v = texture_v(z / length)
    v_cone, v_end = texture_v(cone / length), texture_v(ferrule / length)
    if sharpened:
        v_lead = texture_v(lead * cone / length)
        parts["lead"] = (0.0, float(v_lead))
        parts["wood"] = (float(v_lead), float(v_cone))
    parts["outside"] = (float(v_cone), float(v_end))
    if eraser:
        v_band = texture_v((ferrule + band) / length)
        parts["metal"] = (float(v_end), float(v_band))
        parts["rubber"] = (float(v_band), 1.0)
    in_middle = (z[:-1] >= middle[0] - 1e-9) & (z[1:] <= middle[1] + 1e-9)
    mesh = lathe(profile[:, 0], z, v, sides=sides, region=in_middle, turn_rad=np.pi / sides)
    # A flat side of the prism faces -x, which goes down.
    turn = 0.0 if sides % 2 == 0 else np.pi
    return ObjectShape(
        family="pencil",
        shape_seed=shape_seed,
        dimensions_m={"length": length, "radius": radius, "cone": cone, "sides": float(sides)},
        mesh=mesh,
        parts=parts,
        unrolled_m=(2 * np.pi * radius, length),
        resting_poses=(RestingPose("lying", 1.0, rotation_to_side(0.0, turn)),),
        region_name="middle",
        plain_share=0.5,
        solids_m=lathe_solids(*profile.T, sides=sides, turn_rad=np.pi / sides),
    )
