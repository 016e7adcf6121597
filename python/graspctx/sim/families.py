"""The object families: mug, pencil and wine glass, in wide proportions.

Object frame: z is the axis of the lathe, upwards when the object stands; the origin is the middle of its foot
(for the pencil, its tip). A mug's handle points along +x.
"""

from dataclasses import dataclass

import numpy as np

from .mesh import Mesh, join, lathe, tube


@dataclass(frozen=True)
class RestingPose:
    """One way to lie on a table.

    Attributes:
        name: "standing" or "lying".
        weight: how often it is drawn, relative to the object's other poses.
        table_from_object: (3, 3) rotation; the table's z points up. The object also rests when it is turned
            about z or moved along the table.
    """

    name: str
    weight: float
    table_from_object: np.ndarray


@dataclass(frozen=True)
class ObjectShape:
    """One object: its mesh, its grasp region and how it rests.

    Attributes:
        family, shape_seed: what made it.
        dimensions_m: named lengths, metres.
        mesh: the surface, with the grasp region flagged.
        parts: parts of the surface by name, each an interval (v0, v1) of the texture coordinate v.
        unrolled_m: (around, along) size of the texture on the object, metres.
        resting_poses: ways to lie on a table.
    """

    family: str
    shape_seed: int
    dimensions_m: dict[str, float]
    mesh: Mesh
    parts: dict[str, tuple[float, float]]
    unrolled_m: tuple[float, float]
    resting_poses: tuple[RestingPose, ...]


def _arc(centre, radius_m, start_rad, stop_rad, count):
    angle = np.linspace(start_rad, stop_rad, count)
    return np.stack([centre[0] + radius_m * np.cos(angle), centre[1] + radius_m * np.sin(angle)], axis=1)


def _along(profile: np.ndarray) -> np.ndarray:
    """(P,) length walked along a (P, 2) profile, metres."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])


def _rotation_to_side(tilt_rad: float, turn_rad: float) -> np.ndarray:
    """(3, 3): turn about the object's axis, then lay it on its -x side, tilted by `tilt_rad`."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    c, s = np.cos(np.pi / 2 - tilt_rad), np.sin(np.pi / 2 - tilt_rad)
    # Takes object -x to table -z (down) and object z to table -x.
    lay = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    return lay @ turn


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
    walked = _along(curve)
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
    return [_rotation_to_side(tilt, np.pi + sign * turn) for sign in (-1, 1)]


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
    length = _along(profile)
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
    )


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
    v = z / length
    v_cone, v_end = cone / length, ferrule / length
    if sharpened:
        parts["lead"] = (0.0, lead * v_cone)
        parts["wood"] = (lead * v_cone, v_cone)
    parts["outside"] = (v_cone, v_end)
    if eraser:
        parts["metal"] = (v_end, (ferrule + band) / length)
        parts["rubber"] = ((ferrule + band) / length, 1.0)
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
        resting_poses=(RestingPose("lying", 1.0, _rotation_to_side(0.0, turn)),),
    )


def make_wineglass(shape_seed: int) -> ObjectShape:
    """An opaque goblet: foot, stem, bowl; the grasp region is the stem."""
    rng = np.random.default_rng(shape_seed)
    kind = rng.choice(["round", "round", "flute", "cone"])
    bowl_height = {
        "round": rng.uniform(0.055, 0.105),
        "flute": rng.uniform(0.09, 0.13),
        "cone": rng.uniform(0.04, 0.08),
    }[kind]
    belly = {
        "round": rng.uniform(0.028, 0.046),
        "flute": rng.uniform(0.021, 0.028),
        "cone": rng.uniform(0.036, 0.054),
    }[kind]
    stem_length = rng.uniform(0.045, 0.100)
    stem = rng.uniform(0.0032, 0.0065)
    foot = rng.uniform(0.027, 0.042)
    edge = rng.uniform(0.0015, 0.004)
    rise = rng.uniform(0.006, 0.016)
    wall = rng.uniform(0.0016, 0.0035)
    narrowing = rng.uniform(0.62, 1.0) if kind == "round" else rng.uniform(0.8, 1.05)
    belly_at = rng.uniform(0.35, 0.7)
    opening_power = rng.uniform(0.75, 1.1)
    stem_bottom = edge + rise
    stem_top = stem_bottom + stem_length
    height = stem_top + bowl_height

    def bowl_radius(s, largest):
        """Radius at height s in [0, 1] of the bowl."""
        if kind == "cone":
            return largest * np.clip(s, 0, 1) ** opening_power
        below = np.sqrt(np.clip(1 - (1 - s / belly_at) ** 2, 0, 1))
        above = 1 - (1 - narrowing) * np.clip((s - belly_at) / (1 - belly_at), 0, 1) ** 2
        return largest * np.where(s < belly_at, below, above)

    q = np.linspace(0, 1, 20)
    foot_power = rng.uniform(2.5, 5.0)
    foot_top = np.stack([foot + (stem - foot) * q, edge + rise * q**foot_power], axis=1)
    stem_s = np.linspace(0, 1, 24)
    waist = rng.uniform(-0.25, 0.15)
    knob = rng.choice([0.0, 0.0, rng.uniform(0.3, 0.9)]) * np.exp(
        -(((stem_s - rng.uniform(0.6, 0.9)) / 0.06) ** 2)
    )
    ends = np.minimum(stem_s, 1 - stem_s)
    stem_radius = stem * (1 + waist * np.sin(np.pi * stem_s) + knob * np.minimum(1, ends / 0.05))
    stem_line = np.stack([stem_radius, stem_bottom + stem_length * stem_s], axis=1)
    # Even steps along the quarter turn at the bottom of the bowl, then up.
    s = 1 - np.cos(np.linspace(0, np.pi / 2, 30))
    bowl_out = np.stack([bowl_radius(s, belly), stem_top + bowl_height * s], axis=1)
    bowl_out = bowl_out[bowl_out[:, 0] > stem]
    bowl_out = bowl_out[bowl_out[:, 1] < height - wall / 2]
    rim_angle = np.linspace(0, np.pi, 9)
    rim_radius = bowl_radius(1.0, belly)
    rim = np.stack(
        [rim_radius - wall / 2 * (1 - np.cos(rim_angle)), height - wall / 2 * (1 - np.sin(rim_angle))], axis=1
    )
    inner_bottom = stem_top + (wall * 1.5 if kind != "cone" else 0.12 * bowl_height + wall)
    s_in = s[::-1]
    inner_z = inner_bottom + (height - wall / 2 - inner_bottom) * s_in
    bowl_in = np.stack(
        [bowl_radius(s_in, belly - wall) * (rim_radius - wall) / bowl_radius(1.0, belly - wall), inner_z], 1
    )
    bowl_in = bowl_in[1:-1]
    profile = np.concatenate(
        [
            [[0, 0], [foot - edge / 3, 0], [foot, edge / 2]],
            foot_top,
            stem_line[1:],
            bowl_out,
            rim,
            bowl_in,
            [[0, inner_bottom]],
        ]
    )
    profile[:, 0] = np.where(np.abs(profile[:, 0]) < 1e-9, 0.0, profile[:, 0])
    length = _along(profile)
    v = length / length[-1]
    first_stem = 3 + len(foot_top) - 1
    in_stem = np.zeros(len(profile) - 1, bool)
    in_stem[first_stem : first_stem + len(stem_line) - 1] = True
    rim_v = v[first_stem + len(stem_line) + len(bowl_out) + 4]
    return ObjectShape(
        family="wineglass",
        shape_seed=shape_seed,
        dimensions_m={
            "height": height,
            "bowl_height": bowl_height,
            "bowl_radius": belly,
            "rim_radius": float(rim_radius),
            "stem_length": stem_length,
            "stem_radius": stem,
            "foot_radius": foot,
            "wall": wall,
        },
        mesh=lathe(profile[:, 0], profile[:, 1], v, sides=72, region=in_stem),
        parts={"outside": (0.0, rim_v), "inside": (rim_v, 1.0)},
        unrolled_m=(2 * np.pi * belly * 0.7, length[-1]),
        resting_poses=(RestingPose("standing", 1.0, np.eye(3)),),
    )


FAMILIES = {"mug": make_mug, "pencil": make_pencil, "wineglass": make_wineglass}
"""Families by name: each makes an ObjectShape from a shape seed."""


def make_object(family: str, shape_seed: int) -> ObjectShape:
    """The object that `shape_seed` stands for in a family; always the same one."""
    if family not in FAMILIES:
        raise ValueError(f"unknown family '{family}'; known: {', '.join(FAMILIES)}")
    return FAMILIES[family](shape_seed)
