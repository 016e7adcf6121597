"""Spoons, from tea spoons to wooden ones: a handle along z, then the bowl, which opens to +x."""

import numpy as np

from ..mesh import centre_of_mass_m, skin
from .profile import along
from .resting import resting_poses
from .sections import HANDLE_REGION, PARTS_APART_M
from .shape import ObjectShape

_ACROSS = 17  # points from rim to rim, on each of the two faces


def _faces_of_sections(z, rim_x, half_width, sag, half_thick):
    """(R, 2, _ACROSS, 3) upper and lower face of a spoon: across each section from y = -half_width on."""
    turn = np.linspace(-np.pi / 2, np.pi / 2, _ACROSS)
    y = np.round(np.sin(turn), 12)
    edge = (1 - np.abs(y) ** 4) ** 0.5
    faces = np.empty((len(z), 2, _ACROSS, 3))
    hollow = rim_x[:, None] - sag[:, None] * (1 - y**2)
    faces[:, 0, :, 0] = hollow + half_thick[:, None] * edge
    faces[:, 1, :, 0] = hollow - half_thick[:, None] * edge
    faces[..., 1] = (half_width[:, None] * y)[:, None]
    faces[..., 2] = z[:, None, None]
    return faces


def _shell_solids(faces, ring_step, across_step):
    """Convex pieces of the shell between the two faces: patches of a few sections and a part of the width."""
    pieces = []
    rings = range(0, len(faces) - 1, ring_step)
    for first in rings:
        last = min(first + ring_step, len(faces) - 1)
        for start in range(0, _ACROSS - 1, across_step):
            end = min(start + across_step, _ACROSS - 1)
            pieces.append(np.unique(faces[first : last + 1, :, start : end + 1].reshape(-1, 3), axis=0))
    return pieces


def make_spoon(shape_seed: int) -> ObjectShape:
    """A spoon; the grasp region is its handle, from the end to HANDLE_REGION of the way to the bowl."""
    rng = np.random.default_rng(shape_seed)
    wooden = rng.random() < 0.35
    length = rng.uniform(0.20, 0.32) if wooden else rng.uniform(0.125, 0.27)
    bowl_length = length * (rng.uniform(0.20, 0.30) if wooden else rng.uniform(0.24, 0.34))
    bowl_half = min(bowl_length * rng.uniform(0.30, 0.46), 0.040)
    depth = bowl_half * (rng.uniform(0.20, 0.45) if wooden else rng.uniform(0.25, 0.65))
    handle_half = (
        rng.uniform(0.0045, 0.0075) if wooden else np.clip(length * rng.uniform(0.016, 0.034), 0.003, 0.009)
    )
    neck_half = handle_half * (rng.uniform(0.8, 1.0) if wooden else rng.uniform(0.35, 0.8))
    handle_thick = handle_half * rng.uniform(0.6, 1.0) if wooden else rng.uniform(0.0010, 0.0019)
    bowl_thick = rng.uniform(0.0014, 0.0024) if wooden else rng.uniform(0.0007, 0.0012)
    handle = length - bowl_length
    region_end = HANDLE_REGION * handle

    turn = np.linspace(0, 0.48 * np.pi, 8)[1:]
    end = handle_half * rng.uniform(0.5, 1.0)
    start = end * (1 - np.cos(turn))
    body = np.unique(np.concatenate([np.arange(end, handle, 0.006)[1:], [region_end]]))
    q = -np.cos(np.linspace(0, np.pi, 34))[1:-1]  # from -1 at the handle to 1 at the tip
    z = np.concatenate([[0.02 * end], start, body[body < handle - 0.002], handle + bowl_length * (q + 1) / 2])
    z = np.unique(z)
    q = np.clip(2 * (z - handle) / bowl_length - 1, -1, 1)

    s = np.clip(z / handle, 0, 1)
    stalk = handle_half + (neck_half - handle_half) * s ** rng.uniform(0.8, 2.5)
    stalk = stalk * np.sqrt(np.clip(1 - (1 - np.clip(z / end, 0, 1)) ** 2, 0, 1))
    stalk = stalk * np.sqrt(np.clip((1 - q) / 1.2, 0, 1)) ** (q > -0.2)
    egg = 1 + rng.uniform(-0.1, 0.25) * -q
    oval = bowl_half * np.sqrt(np.clip(1 - q**2, 0, 1)) * egg
    half_width = (stalk**4 + oval**4) ** 0.25
    sag = depth * np.clip(1 - q**2, 0, 1) ** 0.8
    blend = np.clip((q + 1) / 0.8, 0, 1)
    half_thick = handle_thick + (bowl_thick - handle_thick) * blend**2 * (3 - 2 * blend)
    half_thick = half_thick * np.sqrt(np.clip(half_width / (0.3 * neck_half), 0.2, 1))
    # The stalk is arched and comes down to the rim of the bowl.
    rise, arch = rng.uniform(-0.01, 0.09) * length, rng.uniform(0.0, 0.05) * length
    rim_x = rise * (1 - s) ** 2 + arch * 4 * s * (1 - s) ** 2
    faces = _faces_of_sections(z, rim_x, half_width, sag, half_thick)

    # Round the section, from -y over the upper face to +y and back over the lower one.
    rings = np.concatenate([faces[:, 0], faces[:, 1, -2:0:-1]], axis=1)
    around = 4 * max(bowl_half, handle_half)
    walked = along(np.stack([z, rim_x - sag], axis=1))
    unrolled = (around, float(walked[-1] + PARTS_APART_M))
    u = np.concatenate([rings[..., 1], rings[:, :1, 1]], axis=1) / around
    mesh = skin(rings, u, walked / unrolled[1], region=z[1:] <= region_end + 1e-9)

    parts = {"whole": (0.0, 1.0)}
    if rng.random() < 0.3:
        parts["grip"] = (0.0, float(np.interp(rng.uniform(0.3, 0.76) * handle, z, walked / unrolled[1])))
    in_bowl = int(np.searchsorted(z, handle - 0.15 * bowl_length))
    solids = [*_shell_solids(faces[: in_bowl + 1], 4, _ACROSS - 1), *_shell_solids(faces[in_bowl:], 3, 2)]
    return ObjectShape(
        family="spoon",
        shape_seed=shape_seed,
        dimensions_m={
            "length": length,
            "bowl_length": bowl_length,
            "bowl_width": 2 * bowl_half,
            "bowl_depth": depth,
            "handle_width": 2 * handle_half,
            "handle_thickness": 2 * handle_thick,
        },
        mesh=mesh,
        parts=parts,
        unrolled_m=unrolled,
        resting_poses=resting_poses(mesh.vertices_m, centre_of_mass_m(mesh), up=(1.0, 0, 0)),
        region_name="handle",
        plain_share=0.7,
        solids_m=tuple(solids),
    )
