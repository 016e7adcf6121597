"""The files of one scene; docs/dataset-format.md defines them."""

from __future__ import annotations

import io
import json
import zlib

import numpy as np
from PIL import Image

from .render import View
from .scene import Scene
from .scene_json import describe_scene

DEPTH_UNIT_M = 1e-4
LOOKS = 5
"""Counts the changes after which the same seed gives other pictures."""


def encode_scene(scene: Scene, left: View, right: View) -> dict[str, bytes]:
    """The content of every file in the scene's folder, by name."""
    files = {}
    for name, view in (("left", left), ("right", right)):
        # Noise does not repeat: looking for repetitions takes time and makes the file larger.
        files[f"{name}.png"] = _png(view.colour, compress_type=zlib.Z_HUFFMAN_ONLY)
        files[f"{name}_mask.png"] = _png(view.instances)
        files[f"{name}_label.png"] = _png(view.region.astype(np.uint8) * 255)
        depth = np.round(view.depth_m / DEPTH_UNIT_M)
        files[f"{name}_depth.png"] = _png(np.where(depth <= 65535, depth, 0).astype(np.uint16))
    files["calib.txt"] = calibration_text(scene, left.depth_m.min()).encode()
    files["scene.json"] = encode_json(describe_scene(scene, left, right))
    return files


def calibration_text(scene: Scene, nearest_m: float) -> str:
    """Middlebury's calib.txt: pixels, and the baseline in millimetres."""
    camera = scene.camera
    focal, (cx, cy) = camera.focal_px, camera.centre_px
    matrix = f"[{focal:g} 0 {cx:g}; 0 {focal:g} {cy:g}; 0 0 1]"
    largest = focal * camera.baseline_m / nearest_m
    lines = {
        "cam0": matrix,
        "cam1": matrix,
        "doffs": "0",
        "baseline": f"{camera.baseline_m * 1000:g}",
        "width": f"{camera.image_size[0]}",
        "height": f"{camera.image_size[1]}",
        "ndisp": f"{16 * int(np.ceil((largest + 1) / 16))}",
    }
    return "".join(f"{key}={value}\n" for key, value in lines.items())


def encode_json(content: dict) -> bytes:
    """JSON as all files of a data set have it."""
    return (json.dumps(content, indent=1) + "\n").encode()


def _png(pixels: np.ndarray, **options) -> bytes:
    file = io.BytesIO()
    # Stronger compression takes three times as long to save a tenth.
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "png", compress_level=1, **options)
    return file.getvalue()
