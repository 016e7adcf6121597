"""Teapots: a closed body with a lid, a spout along -x, a handle along +x or over the top."""

import numpy as np

from ..mesh import Mesh, join, tube
from .handle import band_section, even_curve, side_handle, swept_band
from .profile import Section, along, bezier, foot_line, rounded, turn_sections
from .shape import ObjectShape, RestingPose
from .solids import tube_solids

_SPOUT_SIDES = 24
_SPOUT_RINGS = 36
_MOUTH_RINGS = 4
"""Of the rings of a spout, these from its tip are hollow."""


def make_teapot(shape_seed: int) -> ObjectShape:
    """A teapot; the grasp region is the handle."""
    rng = np.random.default_rng(shape_seed)
    belly = rng.uniform(0.052, 0.082)
    height = belly * rng.uniform(1.15, 2.0)  # of the body, without its lid
    foot = belly * rng.uniform(0.55, 0.85)
    opening = belly * rng.uniform(0.38, 0.60)
    side_start = (foot * rng.uniform(0.95, 1.0), rng.uniform(0.004, 0.007))
    side = _body_side(rng, side_start, (belly, height * rng.uniform(0.32, 0.60)), (opening, height))
    lid = _lid_line(rng, opening, height)
    base = foot_line(foot, side_start, 0.001, rng.uniform(0.0005, 0.002))
    turned = turn_sections(
        [Section("outside", base), Section("outside", side), Section("lid", lid)], sides=80
    )
    around = 2 * np.pi * belly
    lid_top = float(lid[:, 1].max())

    def outer_radius(z):
        return np.interp(z, side[:, 1], side[:, 0])

    overhead = bool(rng.random() < 0.3)
    width, thickness = rng.uniform(0.009, 0.018), rng.uniform(0.006, 0.010)
    if overhead:
        rings = _overhead_handle(rng, side, lid_top, width, thickness)
        sizes = {"handle_width": width, "handle_thickness": thickness}
        handle_uv = _uv_along(rings, around, turned.length_m, turned.v_at(side[[0, -1], 1]))
    else:
        limits = (0.14 * height, 0.90 * height)
        reach = rng.uniform(0.030, 0.048)
        rings, sizes = side_handle(
            rng, outer_radius, 0.004, limits, reach_m=reach, width_m=width, thickness_m=thickness
        )
        handle_uv = _uv_around(rings, around, outer_radius, turned)
    outer, inner = _spout(rng, outer_radius, height, belly)
    spout_rings = np.concatenate([outer, inner])
    # Turned by half a turn, so that the coordinate does not wrap where the spout is.
    spout_uv = _uv_around(spout_rings * [-1, -1, 1], around, outer_radius, turned)
    spout_uv[..., 0] += 0.5
    spout = _without_empty_faces(tube(spout_rings, spout_uv, region=False))
    return ObjectShape(
        family="teapot",
        shape_seed=shape_seed,
        dimensions_m={
            "height": lid_top,
            "body_height": height,
            "body_radius": belly,
            "opening_radius": opening,
            "spout_reach": float(-outer[..., 0].min() - belly),
            "handle_top": float(rings[..., 2].max()),
            **sizes,
        },
        mesh=join(turned.mesh, tube(rings, handle_uv, region=True), spout),
        parts=turned.parts,
        unrolled_m=(around, turned.length_m),
        resting_poses=(RestingPose("standing", 1.0, np.eye(3)),),
        region_name="handle",
        plain_share=0.35,
        solids_m=turned.solids_m + tube_solids(rings) + _spout_solids(outer, inner),
    )


def _body_side(rng, start, belly, opening):
    """(P, 2) from the foot out to the belly and in to the opening; it climbs all the way."""
    low, high = belly[1] - start[1], opening[1] - belly[1]
    below = bezier(
        start,
        (start[0] + rng.uniform(0.3, 0.95) * (belly[0] - start[0]), start[1] + 0.05 * low),
        (belly[0], belly[1] - rng.uniform(0.35, 0.7) * low),
        belly,
        28,
    )
    above = bezier(
        belly,
        (belly[0], belly[1] + rng.uniform(0.35, 0.75) * high),
        (opening[0] + rng.uniform(0.2, 0.75) * (belly[0] - opening[0]), opening[1] - 0.06 * high),
        opening,
        28,
    )
    return np.concatenate([below, above[1:]])


def _lid_line(rng, opening, height):
    """(P, 2) a lid in its groove, with a round knob, from the opening to the axis."""
    edge = rng.uniform(-0.001, 0.003)
    groove = rounded(
        [
            (opening, height),
            (opening - 0.0015, height + 0.0006),
            (opening - 0.0015, height + 0.0012),
            (opening + edge, height + 0.0018),
            (opening + edge - 0.0002, height + 0.0040),
        ],
        [0, 0.0004, 0.0004, 0.0006, 0],
        points=4,
    )
    dome = rng.uniform(0.12, 0.50) * opening
    neck, knob = rng.uniform(0.004, 0.006), rng.uniform(0.0075, 0.0125)
    neck_height = height + 0.004 + dome
    cap = bezier(
        groove[-1],
        groove[-1] + [-rng.uniform(0.0, 0.3) * opening, 0.8 * dome],
        (neck + 0.45 * opening, neck_height - 0.1 * dome),
        (neck + 0.001, neck_height),
        20,
    )
    centre = neck_height + 0.003 + np.sqrt(knob**2 - neck**2)
    angle = np.linspace(-np.arccos(neck / knob), np.pi / 2, 16)
    flat = rng.uniform(0.6, 1.0)
    ball = np.stack([knob * np.cos(angle), centre + knob * np.sin(angle)], axis=1)
    ball[:, 1] = ball[0, 1] + flat * (ball[:, 1] - ball[0, 1])
    ball[-1, 0] = 0.0
    return np.concatenate([groove, cap[1:], ball])


def _overhead_handle(rng, side, lid_top_m, width_m, thickness_m):
    """(R, S, 3) rings of an arch over the lid, from the shoulder towards +x to that towards -x."""
    shoulder = side[int(np.argmax(side[:, 0])) :]
    reach = shoulder[-1, 0] + rng.uniform(0.35, 0.6) * (shoulder[0, 0] - shoulder[-1, 0])
    # The ends go straight down into the body until all of the band is under its surface.
    farthest = np.hypot(reach + thickness_m / 2, width_m / 2) + 0.002
    bottom, surface = (
        np.interp(-r, -shoulder[:, 0], shoulder[:, 1]) for r in (farthest, reach - thickness_m)
    )
    top = lid_top_m + rng.uniform(0.022, 0.050)
    turn = np.linspace(0, np.pi, 200)
    squareness = rng.uniform(0.75, 1.0)
    arch_x = np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** squareness * reach
    arch_x *= 1 + rng.uniform(0.0, 0.25) * np.sin(turn) ** 2
    arch = np.stack([arch_x, surface + (top - surface) * np.sin(turn) ** squareness], axis=1)
    curve = np.concatenate([[[reach, bottom]], arch, [[-reach, bottom]]])
    return swept_band(even_curve(curve, 72), *band_section(width_m, thickness_m, rng.uniform(2.0, 3.2)))


def _spout(rng, outer_radius, height, belly):
    """(outer, inner) rings of a spout along -x: from inside the body to its lip, and back into its mouth."""
    base = min(rng.uniform(0.012, 0.019), 0.16 * height)
    tip = rng.uniform(0.0058, 0.0085)
    low = height * rng.uniform(0.30, 0.42)
    rise = rng.uniform(0.35, 1.2)  # slope of the lip's direction
    lip = np.array([-(belly + rng.uniform(0.026, 0.055)), height * rng.uniform(0.92, 1.08)])
    start = np.array([-float(outer_radius(low)), low])
    # Far enough inside for the whole ring to be under the surface.
    while (
        np.hypot(start[0] - 0.4 * base, base) > outer_radius(np.array([low - base, low + base])).min() - 0.002
    ):
        start[0] += 0.001
    forward = np.array([-1.0, rise]) / np.hypot(1.0, rise)
    length = np.linalg.norm(lip - start)
    curve = bezier(
        start,
        start + length * rng.uniform(0.3, 0.5) * np.array([-0.95, 0.3]),
        lip - length * rng.uniform(0.2, 0.45) * forward,
        lip,
        200,
    )
    curve = even_curve(curve, _SPOUT_RINGS)
    s = np.linspace(0, 1, _SPOUT_RINGS)
    radius = tip + (base - tip) * (1 - s) ** rng.uniform(1.0, 1.8)
    angle = 2 * np.pi * np.arange(_SPOUT_SIDES) / _SPOUT_SIDES
    outer = swept_band(curve, radius[:, None] * np.sin(angle), radius[:, None] * np.cos(angle))
    wall = rng.uniform(0.0016, 0.0024)
    middle = outer.mean(axis=1, keepdims=True)
    inner = (middle + (outer - middle) * (1 - wall / radius)[:, None, None])[-_MOUTH_RINGS:][::-1]
    return outer, np.concatenate(
        [inner, np.broadcast_to(inner[-1:].mean(axis=1, keepdims=True), inner[:1].shape)]
    )


def _spout_solids(outer, inner):
    """Convex pieces: the closed length as a tube, the mouth as sectors of its wall."""
    pieces = list(tube_solids(outer[: 1 - _MOUTH_RINGS]))
    mouth_outer, mouth_inner = outer[-_MOUTH_RINGS:], inner[:_MOUTH_RINGS][::-1]
    sector = _SPOUT_SIDES // 8
    for first in range(0, _SPOUT_SIDES, sector):
        sides = np.arange(first, first + sector + 1) % _SPOUT_SIDES
        ends = sides[[0, -1]]
        pieces.append(np.concatenate([mouth_outer[:, sides], mouth_inner[:, ends]], axis=1).reshape(-1, 3))
    return tuple(pieces)


def _uv_around(rings_m, around_m, outer_radius, turned):
    """(R, S, 2) texture coordinates of rings off the wall towards +x: those of the wall run on."""
    x, y, z = np.moveaxis(rings_m, -1, 0)
    u = np.arctan2(y, x) / (2 * np.pi) + 0.8 * (np.hypot(x, y) - outer_radius(z)) / around_m
    return np.stack([u, turned.v_at(z)], axis=-1)


def _uv_along(rings_m, around_m, length_m, side_v):
    """(R, S, 2) texture coordinates of a band that leaves the side at its top: to and fro over the side's."""
    middle = rings_m.mean(axis=1)
    walked = along(middle) / length_m
    low, high = side_v
    phase = (high - low) + walked
    v = low + np.abs((phase + (high - low)) % (2 * (high - low)) - (high - low))
    across = rings_m[..., 1] + rings_m[..., 0] - middle[:, None, 0] + rings_m[..., 2] - middle[:, None, 2]
    return np.stack([across / around_m, np.broadcast_to(v[:, None], across.shape)], axis=-1)


def _without_empty_faces(mesh: Mesh) -> Mesh:
    """The mesh without the faces that a ring shrunk to a point leaves."""
    a, b, c = np.moveaxis(mesh.vertices_m[mesh.faces], 1, 0)
    kept = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-14
    return Mesh(mesh.vertices_m, mesh.faces[kept], mesh.uv[kept], mesh.region[kept])
