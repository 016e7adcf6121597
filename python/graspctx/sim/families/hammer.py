"""Hammers: a handle along z and a head across its end, the striking face towards +x."""

import numpy as np

from ..mesh import centre_of_mass_m, join
from .resting import resting_poses
from .sections import HANDLE_REGION, PARTS_APART_M, oval_sections, rounded_ends, skin_sections
from .shape import ObjectShape
from .solids import tube_solids


def _along_x(outline, squareness=1.0):
    """Rings of a body along x; outline is (R, 3): x, half size along y, half size along z."""
    x, half_y, half_z = np.asarray(outline, float).T
    centres = np.stack([x, 0 * x, 0 * x], axis=1)
    return oval_sections(centres, [0, 1.0, 0], [0, 0, 1.0], half_y, half_z, squareness=squareness)


def _mallet(rng):
    half = rng.uniform(0.024, 0.036)
    reach = half * rng.uniform(1.25, 1.9)
    belly = half * rng.uniform(1.0, 1.08)
    end = [(0.75 * reach, half, half), (reach - 0.003, half, half), (reach, half - 0.003, half - 0.003)]
    outline = [(-x, y, z) for x, y, z in end[::-1]] + [(0, belly, belly), *end]
    return [_along_x(outline)], {"head_length": 2 * reach, "face_radius": half, "head_height": 2 * belly}


def _steel_head(rng, kind, eye_half_m):
    """The closed tubes of a head whose eye lies round the origin, and what it measures.

    Args:
        eye_half_m: (x, y) half sizes of the handle in the eye.
    """
    half = max(rng.uniform(0.011, 0.019), eye_half_m[1] + 0.0025)
    eye = max(eye_half_m[0] + 0.002, half)
    reach = eye + rng.uniform(0.028, 0.052)
    chamfer = rng.uniform(0.0008, 0.002)
    neck = rng.uniform(0.72, 0.95) * half
    face = max(0.25 * reach, 0.006)
    striking = [
        (eye + 0.002, neck, neck),
        (reach - face - 0.004, neck, neck),
        (reach - face, half, half),
        (reach - chamfer, half, half),
        (reach, half - chamfer, half - chamfer),
    ]
    body = [(-eye, half, half), (eye, half, half)]
    squareness = 1.0 if rng.random() < 0.6 else rng.uniform(0.45, 0.8)
    claws, back = [], reach
    if kind == "club":
        rear = [(-x, y, z) for x, y, z in striking[::-1]]
    elif kind == "pein":
        back = eye + rng.uniform(0.028, 0.048)
        rear = [(-back, 0.95 * half, 0.0014), (-back + 0.002, half, 0.003)]
    elif kind == "ball":
        ball = rng.uniform(0.75, 0.98) * half
        back = eye + 0.010 + 2 * ball
        turn = np.linspace(0.15, 0.75 * np.pi, 13)
        rear = [(ball - back - ball * np.cos(t), ball * np.sin(t), ball * np.sin(t)) for t in turn]
        rear.append((-eye - 0.002, 0.72 * ball, 0.72 * ball))
    else:
        rear = []
        claws, back = _claws(rng, half, eye)
    sizes = {"head_length": reach + back, "face_radius": half, "head_height": 2 * half}
    return [_along_x([*rear, *body, *striking], squareness), *claws], sizes


def _claws(rng, half, eye):
    """Two tines that start in the eye, part and droop towards -x; and how far they reach."""
    reach = eye + rng.uniform(0.045, 0.070)
    s = np.linspace(1, 0, 14)  # 0 at the eye
    x = -(eye - 0.006) - (reach - eye + 0.006) * s
    z = -rng.uniform(0.004, 0.030) * s**2
    half_width = half * (0.42 + 0.06 * s)
    half_thick = 0.75 * half * (1 - s) + 0.0012
    tubes = []
    for side in (1, -1):
        centres = np.stack([x, side * (half_width + 0.0005 + 0.0025 * s), z], axis=1)
        tubes.append(
            oval_sections(centres, [0, 1.0, 0], [0, 0, 1.0], half_width, half_thick, squareness=0.5, sides=16)
        )
    return tubes, reach


def make_hammer(shape_seed: int) -> ObjectShape:
    """A hammer with a claw, a pein, a ball or a second face, or a mallet; the grasp region is its handle.

    The region goes from the handle's end to HANDLE_REGION of the way to the head.
    """
    rng = np.random.default_rng(shape_seed)
    kind = str(rng.choice(["claw", "claw", "pein", "ball", "club", "mallet"]))
    length = rng.uniform(0.19, 0.30)  # up to the head
    half_width = rng.uniform(0.011, 0.017)
    flat = rng.uniform(0.68, 0.95)
    neck = rng.uniform(0.70, 1.0)
    eye_half = neck * half_width * np.array([1, flat])
    head, sizes = _mallet(rng) if kind == "mallet" else _steel_head(rng, kind, eye_half)
    top = length + sizes["head_height"] / 2
    head = [rings + np.array([0, 0, top]) for rings in head]

    # The handle swells in the hand and towards its end, and thins out to its neck.
    region_end = HANDLE_REGION * length
    places, inset = rounded_ends(top, rng.uniform(0.003, 0.006), 0.008, [region_end], both=False)
    s = places / length
    thinned = np.clip((s - 0.35) / 0.4, 0, 1)
    swell = 1 + rng.uniform(0, 0.22) * np.exp(-(((s - rng.uniform(0.12, 0.4)) / 0.16) ** 2))
    end = 1 + rng.uniform(0, 0.15) * np.exp(-((s / 0.06) ** 2))
    half = half_width * (1 + (neck - 1) * thinned**2 * (3 - 2 * thinned)) * swell * end
    handle = oval_sections(
        np.stack([0 * places, 0 * places, places], axis=1),
        [1.0, 0, 0],
        [0, 1.0, 0],
        half - inset,
        flat * half - inset,
        squareness=rng.uniform(0.6, 1.0),
    )

    head_along = sizes["head_length"]
    unrolled = (np.pi * half_width * (1 + flat), top + head_along + 2 * PARTS_APART_M)
    skinned, v_end = skin_sections(handle, unrolled, region=places[1:] <= region_end + 1e-9)
    v_head = v_end + PARTS_APART_M / unrolled[1]
    # Claws start where the head's body ends: their texture follows its.
    skins = [skin_sections(rings, unrolled, v_head)[0] for rings in head]
    mesh = join(skinned, *skins)
    border = (v_end + v_head) / 2
    parts = {"handle": (0.0, border), "head": (border, 1.0)}
    if rng.random() < 0.4:
        parts["grip"] = (0.0, v_end * rng.uniform(0.3, 0.65))
    return ObjectShape(
        family="hammer",
        shape_seed=shape_seed,
        dimensions_m={
            "handle_length": length,
            "handle_width": 2 * half_width,
            "handle_thickness": 2 * half_width * flat,
            **sizes,
        },
        mesh=mesh,
        parts=parts,
        unrolled_m=unrolled,
        resting_poses=resting_poses(mesh.vertices_m, centre_of_mass_m(mesh)),
        region_name="handle",
        plain_share=0.5,
        solids_m=tuple(piece for rings in (handle, *head) for piece in tube_solids(rings)),
    )
