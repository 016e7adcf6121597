"""Mugs: a hollow lathe with a handle along +x."""

import numpy as np

from ..mesh import join, lathe, tube
from .profile import along, rotation_to_side
from .shape import ObjectShape, RestingPose
from .solids import lathe_solids, tube_solids


def _handle(rng, outer_radius_m, wall_m, height_m, foot_m):
    """A mug's handle: a rounded band along a superellipse. Its ends stop in the middle of the wall."""
    band_width = rng.uniform(0.008, 0.020)
    band_thickness = rng.uniform(0.005, 0.010)
    low_limit = foot_m + band_thickness / 2 + 0.002
    high_limit = height_m - band_thickness / 2 - 0.005
    span = rng.uniform(0.55, 0.92) * (high_limit - low_limit)
    low = low_limit + rng.uniform(0.15, 0.85) * (high_limit - low_limit - span)
    high = low + span
    reach = rng.uniform(0.020, 0.042)
    power = 2 / rng.uniform(1.7, 3.2)
    skew = rng.uniform(-0.15, 0.45)

    turn = np.linspace(0, np.pi, 400)
    z = (low + high) / 2 + span / 2 * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** power
    out = reach * np.sin(turn) ** power * (1 + skew * np.cos(turn)) / (1 + abs(skew))
    curve = np.stack([np.interp(z, [low, high], outer_radius_m(np.array([low, high]))) + out, z], axis=1)
    walked = along(curve)
    even = np.linspace(0, walked[-1], 56)
    curve = np.stack([np.interp(even, walked, curve[:, k]) for k in range(2)], axis=1)
    for _ in range(6):  # rounds the corners of square handles so that the band does not fold
        curve[1:-1] = 0.25 * curve[:-2] + 0.5 * curve[1:-1] + 0.25 * curve[2:]

    tangent = np.gradient(curve, axis=0)
    tangent[0], tangent[-1] = (1, 0), (-1, 0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    inward = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
    sides = 20
    angle = 2 * np.pi * np.arange(sides) / sides
    roundness = 2 / rng.uniform(2.0, 3.5)
    across = band_width / 2 * np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** roundness
    through = band_thickness / 2 * np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** roundness
    from_wall = np.minimum(even, even[-1] - even)
    widen = 1 + rng.uniform(0, 0.35) * np.exp(-from_wall / 0.006)
    rings = np.empty((len(curve), sides, 3))
    rings[..., 0] = curve[:, None, 0] + inward[:, None, 0] * through
    rings[..., 1] = across * widen[:, None]
    rings[..., 2] = curve[:, None, 1] + inward[:, None, 1] * through

    def into_wall(ring):
        ring = ring.copy()
        ring[:, 0] = np.sqrt((outer_radius_m(ring[:, 2]) - wall_m / 2) ** 2 - ring[:, 1] ** 2)
        return ring

    rings = np.concatenate([into_wall(rings[0])[None], rings[1:-1], into_wall(rings[-1])[None]])
    sizes = {
        "handle_reach": reach,
        "handle_low": low,
        "handle_high": high,
        "handle_width": band_width,
        "handle_thickness": band_thickness,
    }
    return rings, sizes


def _lying_mug(profile, handle_m, height_m):
    """The two poses of a mug on its side: it rolls until the handle touches the table, left or right."""
    outer = profile[: np.argmax(profile[:, 1]) + 1]
    # It rests on the edge of the profile's convex hull under its middle: of all chords, the outermost.
    centre = 0.487 * height_m  # no point of the profile lies just there
    chords = []
    for first in outer[outer[:, 1] < centre]:
        for second in outer[outer[:, 1] > centre]:
            slope = (second[0] - first[0]) / (second[1] - first[1])
            chords.append((first[0] + slope * (centre - first[1]), slope))
    middle, slope = max(chords)
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
    floor = rng.uniform(0.004, 0.009)
    rounding = rng.uniform(0.002, 0.014)

    def outer_radius(z):
        s = np.clip(z / height, 0, 1)
        return bottom + (top - bottom) * s + bulge * np.sin(np.pi * s)

    z = np.linspace(0, height, 41)
    side = np.stack([outer_radius(z), z], axis=1)
    corner = np.linspace(0, np.pi / 2, 9)
    foot_z = rounding * (1 - np.cos(corner))
    foot = np.stack([outer_radius(foot_z) - rounding * (1 - np.sin(corner)), foot_z], axis=1)
    rim_angle = np.linspace(0, np.pi, 11)
    lip = wall / 2
    rim = np.stack(
        [outer_radius(height) - lip + lip * np.cos(rim_angle), height + lip * np.sin(rim_angle) - lip], 1
    )
    inside_z = np.linspace(height - lip, floor + rounding, 30)[1:]
    inside = np.stack([outer_radius(inside_z) - wall, inside_z], axis=1)
    bowl_z = floor + rounding * (1 - np.cos(corner[::-1]))
    bowl = np.stack([outer_radius(bowl_z) - wall - rounding * (1 - np.sin(corner[::-1])), bowl_z], axis=1)[1:]
    wall_up = side[(side[:, 1] > rounding + 1e-4) & (side[:, 1] < height - lip - 1e-4)]
    profile = np.concatenate([[[0, 0]], foot, wall_up, rim, inside, bowl, [[0, floor]]])
    length = along(profile)
    v = length / length[-1]
    rim_v = v[len(foot) + len(wall_up) + 6]
    body = lathe(profile[:, 0], profile[:, 1], v, sides=80, turn_rad=np.pi / 80)

    rings, handle_sizes = _handle(rng, outer_radius, wall, height, rounding)
    around = 2 * np.pi * top
    # The pattern runs on from the wall over the handle: no seam where the grasp region begins.
    outside = slice(1, 1 + len(foot) + len(wall_up))
    uv = np.stack(
        [
            (
                np.arctan2(rings[..., 1], rings[..., 0]) * outer_radius(rings[..., 2])
                + 0.8 * (np.hypot(rings[..., 0], rings[..., 1]) - outer_radius(rings[..., 2]))
            )
            / around,
            np.interp(rings[..., 2], profile[outside, 1], v[outside]),
        ],
        axis=-1,
    )
    handle = tube(rings, uv, region=True)
    lying = _lying_mug(profile, handle.vertices_m, height)
    return ObjectShape(
        family="mug",
        shape_seed=shape_seed,
        dimensions_m={
            "height": height,
            "top_radius": top,
            "bottom_radius": bottom,
            "wall": wall,
            **handle_sizes,
        },
        mesh=join(body, handle),
        parts={"outside": (0.0, rim_v), "inside": (rim_v, 1.0)},
        unrolled_m=(around, length[-1]),
        resting_poses=(
            RestingPose("standing", 0.88, np.eye(3)),
            RestingPose("lying", 0.06, lying[0]),
            RestingPose("lying", 0.06, lying[1]),
        ),
        region_name="handle",
        plain_share=0.3,
        solids_m=lathe_solids(*profile.T, sides=80, turn_rad=np.pi / 80) + tube_solids(rings),
    )
