"""What a scene and its objects count for: the axes of EVALUATION's table, and those of difficulty."""

from __future__ import annotations

import collections
from collections.abc import Iterable

import numpy as np

TABLES = {"textured": "textured", "faint": "faint", "uniform": "plain"}
"""What scene.json calls a table, and what the rows do."""
AXES = ("all", "textured", "faint", "plain", "single", "clutter", "low")
COMBINED = tuple(f"{kind} {table}" for kind in ("single", "clutter", "low") for table in TABLES.values())
MAIN_AXES = (*AXES, *COMBINED)

_SCENE_BINS = {
    "elevation_deg": (30, 45),
    "distance_m": (0.65, 0.8),
    "roll_deg": (2.5, 10),
    "baseline_m": (0.07, 0.09),
    "fov_deg": (54, 60),
    "brightness": (90, 120),
    "noise": (1, 2, 4),
    "blur_px": (0.3, 0.6),
    "exposure_ratio": (1.03, 1.1),
    "vertical_offset_px": (0.25, 0.75),
}
"""Edges between the bins of numbers; magnitudes where the sign is a matter of left and right, up and down."""
_SCENE_NAMES = ("background", "background_texture", "objects", "leaning", "spacing", "shadow")
_OBJECT_BINS = {"occlusion": (0.05, 0.3), "visible_px": (1000, 4000), "height_m": (0.02, 0.06)}


def scene_axes(info: dict, low_set: bool) -> tuple[str, ...]:
    """The axes that a scene counts for."""
    table = TABLES[info["table_texture"]]
    axes = []
    if not low_set:
        kind = "single" if len(info["objects"]) == 1 else "clutter"
        axes += ["all", table, kind, f"{kind} {table}", *_difficulty_of_scene(info)]
    if all(entry.get("low") for entry in info["objects"]):
        axes += ["low", f"low {table}"]
    return tuple(axes)


def object_axes(info: dict, entry: dict, low_set: bool) -> tuple[str, ...]:
    """The axes that an object of a scene counts for."""
    axes = [axis for axis in scene_axes(info, low_set) if not axis.startswith("low")]
    if not low_set:
        numbers = {
            "occlusion": 1 - entry.get("visible_share", {}).get("left", 1.0),
            "visible_px": entry["visible_px"]["left"],
            "height_m": entry.get("height_m"),
        }
        axes += [_bin(axis, numbers[axis], edges) for axis, edges in _OBJECT_BINS.items()]
        axes += [f"family={entry['family']}", f"pose={entry.get('pose')}"]
    if entry.get("low"):
        axes += ["low", f"low {TABLES[info['table_texture']]}"]
    return tuple(axis for axis in axes if axis is not None)


def _difficulty_of_scene(info):
    difficulty = info.get("axes", {})
    axes = [
        f"{axis}={str(difficulty[axis]).lower()}" for axis in _SCENE_NAMES if difficulty.get(axis) is not None
    ]
    for axis, edges in _SCENE_BINS.items():
        value = difficulty.get(axis)
        if value is not None:
            value = max(value, 1 / value) if axis == "exposure_ratio" else abs(value)
            axes.append(_bin(axis, value, edges))
    return axes


def _bin(axis, value, edges):
    if value is None:
        return None
    number = int(np.searchsorted(edges, value, side="right"))
    if number == 0:
        return f"{axis} < {edges[0]:g}"
    if number == len(edges):
        return f"{axis} >= {edges[-1]:g}"
    return f"{axis} {edges[number - 1]:g} to {edges[number]:g}"


def informative(objects: Iterable[str], scenes: Iterable[str]) -> list[str]:
    """The axes in the order of printing, without those of difficulty that all scenes agree on."""
    names = sorted({*objects, *scenes} - set(MAIN_AXES))
    stems = collections.Counter(_stem(name) for name in names)
    main = [axis for axis in MAIN_AXES if axis in objects or axis in scenes]
    return main + [name for name in names if stems[_stem(name)] > 1]


def _stem(axis):
    return axis.replace("=", " ").split()[0]
