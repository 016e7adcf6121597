"""Bodies made of sections across an axis: what the handles and heads of tools are."""

import numpy as np

from ..mesh import Mesh, skin, stops
from .profile import along

HANDLE_REGION = 0.85
"""The grasp region of a tool: its handle, from the end up to this share of the way to the head.

It ends before the head does so that the border of two materials is not the border of the region.
"""
PARTS_APART_M = 0.006
"""Free texture between two parts of a body, and before the texture repeats: from afar, they would mix."""


def oval_sections(
    centres_m, across_m, up_m, half_across_m, half_up_m, *, squareness=1.0, sides=24
) -> np.ndarray:
    """(R, S, 3) superellipses around each centre.

    Args:
        centres_m: (R, 3).
        across_m, up_m: (3,) or (R, 3) unit vectors that span each section; across x up is the way of travel.
        half_across_m, half_up_m: (R,) or one half size for all.
        squareness: (R,) or one for all: 1 is an ellipse, smaller is more like a rectangle.
        sides: S, a multiple of 4.
    """
    count = len(centres_m)
    angle = 2 * np.pi * np.arange(sides) / sides
    half_across, half_up, power = (
        np.broadcast_to(a, count)[:, None] for a in (half_across_m, half_up_m, squareness)
    )
    cos, sin = np.round(np.cos(angle), 12), np.round(np.sin(angle), 12)
    x = half_across * np.sign(cos) * np.abs(cos) ** power
    y = half_up * np.sign(sin) * np.abs(sin) ** power
    across, up = (np.broadcast_to(a, (count, 3))[:, None] for a in (across_m, up_m))
    return centres_m[:, None] + x[..., None] * across + y[..., None] * up


def rounded_ends(length_m: float, radius_m: float, step_m: float, cuts=(), *, both=True):
    """Places along a body whose ends are rounded, and how much each is narrower there.

    Args:
        length_m: from 0 to here.
        radius_m: of the rounding.
        step_m: longest distance of neighbours.
        cuts: places that are among them.
        both: whether the end at `length_m` is rounded too.

    Returns:
        (R,) places and (R,) metres to take off the half sizes.
    """
    turn = np.linspace(0, np.pi / 2, 6)
    foot, inset = radius_m * (1 - np.cos(turn)), radius_m * (1 - np.sin(turn))
    last = length_m - radius_m if both else length_m
    body = stops(radius_m, last, step_m, cuts)
    places, take = np.concatenate([foot, body[1:]]), np.concatenate([inset, 0 * body[1:]])
    if both:
        places = np.concatenate([places, length_m - foot[-2::-1]])
        take = np.concatenate([take, inset[-2::-1]])
    return places, take


def skin_sections(rings_m: np.ndarray, unrolled_m, v_from: float = 0.0, *, region=None) -> tuple[Mesh, float]:
    """Skin sections with a texture as large as it is.

    Round the body it is repeated a whole number of times; round a thin one it goes to the far side and back.

    Args:
        rings_m: (R, S, 3) as `mesh.skin` takes them.
        unrolled_m: (around, along) size of the texture.
        v_from: texture coordinate of the first ring.
        region: as `mesh.skin` takes it.

    Returns:
        The mesh, and the texture coordinate of its last ring.
    """
    closed = np.concatenate([rings_m, rings_m[:, :1]], axis=1)
    walked = np.stack([along(ring) for ring in closed])
    largest = walked[:, -1].max() / unrolled_m[0]
    u = walked / walked[:, -1:]
    u = u * max(1, round(largest)) if largest > 0.6 else (0.5 - np.abs(u - 0.5)) * largest
    v = v_from + along(rings_m.mean(axis=1)) / unrolled_m[1]
    return skin(rings_m, u, v, region=region), float(v[-1])
