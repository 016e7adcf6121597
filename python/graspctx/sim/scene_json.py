"""The content of a scene's scene.json; docs/dataset-format.md defines it."""

from __future__ import annotations

import numpy as np

from .placing import PlacedObject
from .render import View
from .scene import Scene

LOW_M = 0.02
"""Objects lower than this are called low: they are worth a pixel or two of disparity."""


def describe_scene(scene: Scene, left: View, right: View) -> dict:
    """What stands where in a scene, and how much of it both views see."""
    camera = scene.camera
    normal, offset_m = scene.table_plane
    views = {"left": left, "right": right}
    objects = [_describe_object(scene, placed, views) for placed in scene.objects]
    return {
        "schema": 1,
        "seed": scene.seed,
        "index": scene.index,
        "split": scene.split,
        "image_size": list(camera.image_size),
        "camera": {
            "focal_px": camera.focal_px,
            "centre_px": list(camera.centre_px),
            "baseline_m": camera.baseline_m,
            "doffs_px": 0.0,
        },
        "cam_from_table": _rounded(scene.cam_from_table),
        "table_plane": {"normal": _rounded(normal), "offset_m": _rounded(offset_m)},
        "table_texture": scene.table.texture,
        "axes": _describe_axes(scene, objects, left),
        "objects": objects,
    }


def _describe_object(scene: Scene, placed: PlacedObject, views: dict[str, View]) -> dict:
    seen = {name: view.instances == placed.id for name, view in views.items()}
    visible_px = {name: int(mask.sum()) for name, mask in seen.items()}
    label_px = {name: int((views[name].region & mask).sum()) for name, mask in seen.items()}
    unhidden_px = {name: view.unhidden_px[placed.id] for name, view in views.items()}
    height_m = float(placed.points_m[:, 2].max())
    return {
        "id": placed.id,
        "family": placed.shape.family,
        "shape_seed": placed.shape.shape_seed,
        "texture_seed": placed.texture_seed,
        "dimensions_m": {name: round(float(value), 6) for name, value in placed.shape.dimensions_m.items()},
        "cam_from_object": _rounded(scene.cam_from_table @ placed.table_from_object),
        "pose": placed.pose,
        "leans_on": placed.leans_on,
        "height_m": round(height_m, 6),
        "low": height_m < LOW_M,
        "visible_px": visible_px,
        "label_px": label_px,
        "visible_share": _shares(visible_px, unhidden_px),
        "visible_label_share": _shares(label_px, visible_px),
    }


def _describe_axes(scene: Scene, objects: list[dict], left: View) -> dict:
    """What the scene has on each axis of difficulty.Difficulty: measured where it can be."""
    camera, sensor = scene.camera, scene.sensor
    return {
        "table": scene.table.texture,
        "background": scene.background.kind,
        "background_texture": scene.background.texture,
        "objects": len(objects),
        "low": any(entry["low"] for entry in objects),
        "leaning": any(entry["pose"] == "leaning" for entry in objects),
        "spacing": scene.spacing,
        "occlusion": round(1 - min((entry["visible_share"]["left"] for entry in objects), default=1), 4),
        "shadow": "cast" if any(light.casts_shadow for light in scene.lights) else "none",
        "brightness": round(float(left.colour.mean()), 2),
        "elevation_deg": round(scene.viewpoint.elevation_deg, 3),
        "roll_deg": round(scene.viewpoint.roll_deg, 3),
        "distance_m": round(scene.viewpoint.distance_m, 4),
        "baseline_m": camera.baseline_m,
        "fov_deg": round(float(np.degrees(2 * np.arctan(camera.image_size[0] / 2 / camera.focal_px))), 3),
        "noise": round(sensor.noise, 3),
        "blur_px": round(sensor.blur_px, 3),
        "exposure_ratio": round(sensor.exposure_ratio, 4),
        "vertical_offset_px": round(sensor.vertical_offset_px, 3),
    }


def _shares(part: dict[str, int], whole: dict[str, int]) -> dict[str, float]:
    return {name: round(count / max(whole[name], 1), 4) for name, count in part.items()}


def _rounded(values):
    """Nested lists with 9 decimals, without negative zeros."""
    return (np.round(np.asarray(values, float), 9) + 0.0).tolist()
