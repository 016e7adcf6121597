"""The content of a scene's scene.json; docs/dataset-format.md defines it."""

from __future__ import annotations

import numpy as np

from .render import View
from .scene import Scene


def describe_scene(scene: Scene, left: View, right: View) -> dict:
    """What stands where in a scene, and how much of it both views see."""
    camera = scene.camera
    normal, offset_m = scene.table_plane
    objects = []
    for placed in scene.objects:
        seen = {name: view.instances == placed.id for name, view in (("left", left), ("right", right))}
        labelled = {"left": left.region & seen["left"], "right": right.region & seen["right"]}
        objects.append(
            {
                "id": placed.id,
                "family": placed.shape.family,
                "shape_seed": placed.shape.shape_seed,
                "texture_seed": placed.texture_seed,
                "dimensions_m": {
                    name: round(float(value), 6) for name, value in placed.shape.dimensions_m.items()
                },
                "cam_from_object": _rounded(scene.cam_from_table @ placed.table_from_object),
                "visible_px": {name: int(mask.sum()) for name, mask in seen.items()},
                "label_px": {name: int(mask.sum()) for name, mask in labelled.items()},
            }
        )
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
        "table_texture": scene.table_texture,
        "objects": objects,
    }


def _rounded(values):
    """Nested lists with 9 decimals, without negative zeros."""
    return (np.round(np.asarray(values, float), 9) + 0.0).tolist()
