"""What scenes are drawn from: for each named axis of difficulty, the values it takes."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

CHOICES = {
    "table": ("textured", "faint", "uniform"),
    "background": ("wall", "room", "far"),
    "background_texture": ("textured", "faint", "uniform"),
    "pose": ("any", "standing", "lying", "leaning"),
    "spacing": ("apart", "touching"),
    "shadow": ("cast", "none"),
}
"""Values of the axes that are named."""

LIMITS = {
    "occlusion": (0.0, 1.0),
    "elevation_deg": (5.0, 85.0),
    "distance_m": (0.3, 3.0),
    "roll_deg": (-45.0, 45.0),
    "baseline_m": (0.01, 0.5),
    "fov_deg": (20.0, 100.0),
    "brightness": (20.0, 235.0),
    "noise": (0.0, 30.0),
    "blur_px": (0.0, 5.0),
    "exposure_ratio": (0.3, 3.0),
    "vertical_offset_px": (-20.0, 20.0),
}
"""Lowest and highest value of the axes that are numbers."""

Weights = Mapping[str, float]
Range = tuple[float, float]


@dataclass(frozen=True)
class Difficulty:
    """How scenes are drawn: weights for axes with named values, a range for axes that are numbers.

    Attributes:
        table: texture of the table; "faint" has a few grey levels of contrast, "uniform" none.
        background: a "wall" close behind the objects, the walls of a "room", or walls "far" away.
        background_texture: of walls and floor.
        pose: of each object: "any" of its family's resting poses, "standing" or "lying" where the family has
            such a pose, or "leaning" against another object (such a scene has two objects or more).
        spacing: whether objects stand "apart" (12 mm and more) or "touching" (under 2 mm).
        shadow: whether the strongest light casts one.
        occlusion: the most hidden share, in the left view, of any object.
        elevation_deg: of the camera's line of sight, above the table.
        distance_m: from the cameras' middle to the middle of the objects.
        roll_deg: turn about the line of sight.
        baseline_m: distance of the two cameras.
        fov_deg: horizontal field of view.
        brightness: mean grey level of the left view.
        noise: standard deviation, grey levels.
        blur_px: standard deviation.
        exposure_ratio: of the right view to the left one.
        vertical_offset_px: how much lower everything lies in the right view than it should.
    """

    table: Weights
    background: Weights
    background_texture: Weights
    pose: Weights
    spacing: Weights
    shadow: Weights
    occlusion: Range
    elevation_deg: Range
    distance_m: Range
    roll_deg: Range
    baseline_m: Range
    fov_deg: Range
    brightness: Range
    noise: Range
    blur_px: Range
    exposure_ratio: Range
    vertical_offset_px: Range

    def choose(self, rng, axis: str) -> str:
        """Draw a value of a named axis."""
        weights = getattr(self, axis)
        shares = np.cumsum(list(weights.values()))
        return list(weights)[int(np.searchsorted(shares, rng.random() * shares[-1], side="right"))]

    def draw(self, rng, axis: str) -> float:
        """Draw a value of an axis that is a number."""
        return float(rng.uniform(*getattr(self, axis)))

    def to_dict(self) -> dict:
        """For JSON."""
        axes = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: dict(value) if name in CHOICES else list(value) for name, value in axes.items()}


DEFAULT = Difficulty(
    table={"textured": 0.72, "faint": 0.16, "uniform": 0.12},
    background={"wall": 0.25, "room": 0.6, "far": 0.15},
    background_texture={"textured": 0.6, "faint": 0.25, "uniform": 0.15},
    pose={"any": 1.0},
    spacing={"apart": 0.7, "touching": 0.3},
    shadow={"cast": 0.85, "none": 0.15},
    occlusion=(0.0, 0.85),
    elevation_deg=(20.0, 64.0),
    distance_m=(0.55, 0.90),
    roll_deg=(-5.0, 5.0),
    baseline_m=(0.0776, 0.0824),
    fov_deg=(54.4, 58.2),
    brightness=(75.0, 140.0),
    noise=(0.5, 2.5),
    blur_px=(0.0, 0.7),
    exposure_ratio=(0.97, 1.03),
    vertical_offset_px=(0.0, 0.0),
)
"""A good pair of cameras over a table: what the shipped models are trained on."""

EASY = replace(
    DEFAULT,
    table={"textured": 1.0},
    background={"room": 1.0},
    background_texture={"textured": 1.0},
    spacing={"apart": 1.0},
    occlusion=(0.0, 0.3),
    elevation_deg=(30.0, 55.0),
    distance_m=(0.55, 0.75),
    roll_deg=(-1.0, 1.0),
    noise=(0.3, 1.0),
    blur_px=(0.0, 0.4),
    exposure_ratio=(1.0, 1.0),
)
"""Textured tables, little hidden, a quiet sensor."""

HARD = Difficulty(
    table={"textured": 0.34, "faint": 0.33, "uniform": 0.33},
    background={"wall": 0.5, "room": 0.25, "far": 0.25},
    background_texture={"textured": 0.4, "faint": 0.3, "uniform": 0.3},
    pose={"any": 0.55, "lying": 0.2, "leaning": 0.25},
    spacing={"apart": 0.4, "touching": 0.6},
    shadow={"cast": 1.0},
    occlusion=(0.0, 0.85),
    elevation_deg=(13.0, 75.0),
    distance_m=(0.5, 1.2),
    roll_deg=(-20.0, 20.0),
    baseline_m=(0.05, 0.12),
    fov_deg=(46.0, 70.0),
    brightness=(45.0, 165.0),
    noise=(1.0, 6.0),
    blur_px=(0.0, 1.2),
    exposure_ratio=(0.8, 1.25),
    vertical_offset_px=(-1.5, 1.5),
)
"""Everything that makes stereo and segmentation fail, as far as cameras do such things."""

DIFFICULTIES = {"easy": EASY, "default": DEFAULT, "hard": HARD}


def with_axis(difficulty: Difficulty, setting: str) -> Difficulty:
    """Change one axis.

    Args:
        difficulty: what to start from.
        setting: "AXIS=VALUE": names with commas between them, equally likely ("table=faint,uniform"), or a
            number or range ("noise=3", "roll_deg=-20-20").

    Raises:
        ValueError: no such axis, or it does not take this value.
    """
    axis, _, text = setting.partition("=")
    if axis in CHOICES:
        values = text.split(",")
        unknown = [value for value in values if value not in CHOICES[axis]]
        if unknown:
            raise ValueError(f"axis {axis}: unknown value '{unknown[0]}'; known: {', '.join(CHOICES[axis])}")
        return replace(difficulty, **{axis: {value: 1.0 for value in values}})
    if axis not in LIMITS:
        raise ValueError(f"'{setting}': unknown axis '{axis}'; known: {', '.join([*CHOICES, *LIMITS])}")
    number = r"(-?\d*\.?\d+)"
    parsed = re.fullmatch(f"{number}(?:-{number})?", text)
    if parsed is None:
        raise ValueError(f"axis {axis}: '{text}' is not a number or LOW-HIGH")
    low, high = float(parsed[1]), float(parsed[2] or parsed[1])
    lowest, highest = LIMITS[axis]
    if not lowest <= low <= high <= highest:
        raise ValueError(f"axis {axis}: '{text}' is not within {lowest:g} to {highest:g}, low before high")
    return replace(difficulty, **{axis: (low, high)})
