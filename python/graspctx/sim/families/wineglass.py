"""Wine glasses: foot, stem and bowl, turned in one piece."""

import numpy as np

from .profile import Section, lying, turn_sections, upside_down
from .shape import ObjectShape, RestingPose


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
    foot_line = np.concatenate([[[0, 0], [foot - edge / 3, 0], [foot, edge / 2]], foot_top])
    crest = len(rim) // 2
    turned = turn_sections(
        [
            Section("outside", foot_line),
            Section("outside", stem_line, region=True),
            Section("outside", np.concatenate([stem_line[-1:], bowl_out, rim[: crest + 1]])),
            Section("inside", np.concatenate([rim[crest:], bowl_in[1:-1], [[0, inner_bottom]]])),
        ],
        sides=72,
    )
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
        mesh=turned.mesh,
        parts=turned.parts,
        unrolled_m=(2 * np.pi * belly * 0.7, turned.length_m),
        resting_poses=(
            RestingPose("standing", 0.88, np.eye(3)),
            upside_down(0.04),
            lying(turned.profile, 0.08),
        ),
        region_name="stem",
        plain_share=0.4,
        solids_m=turned.solids_m,
    )
