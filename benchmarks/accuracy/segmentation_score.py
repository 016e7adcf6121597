"""How well the segmentation of one scene fits its truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

LEAST_VISIBLE_PX, LEAST_VISIBLE_SHARE = 150, 0.25
"""An object counts if the left view shows so much of it; less is neither found nor missed."""
FOUND_IOU = 0.5
"""A segment that fits an object better has found it: no other can, and it cannot have found another."""
NOTHING_SHARE = 0.3
"""A false segment less of which lies on objects lies on nothing."""
LEAST_HOLE_PX = 30
DEPTH_QUANTILES = np.arange(0.05, 1, 0.05)


@dataclass(frozen=True)
class ObjectScore:
    """How an object that counts was segmented.

    Attributes:
        id: in the truth's mask.
        iou: of the segment that fits best; 0 if none touches it.
        hole_filled: share of the background seen through holes of the object that its segment covers; None if
            there is no such hole, or the object was not found.
        plane_angle_deg, plane_height_mm: error of the table plane, in height at the object's foot; None if no
            plane was found.
        depth_errors_mm: quantiles (0.05, 0.10 … 0.95) of the absolute depth error over the object's segment;
            None if the object was not found or has no depth.
        depth_known: share of the segment on the object that has depth; None if the object was not found.
    """

    id: int
    iou: float
    hole_filled: float | None = None
    plane_angle_deg: float | None = None
    plane_height_mm: float | None = None
    depth_errors_mm: tuple[float, ...] | None = None
    depth_known: float | None = None

    @property
    def found(self) -> bool:
        """Whether a segment fits it well enough."""
        return self.iou > FOUND_IOU


@dataclass(frozen=True)
class SceneScore:
    """How a scene was segmented.

    Attributes:
        objects: those that count.
        false: segments that found no object, those that do not count included.
        false_on_nothing: those of them that hardly lie on any object.
        plane_found: whether there is a table plane.
    """

    objects: tuple[ObjectScore, ...]
    false: int
    false_on_nothing: int
    plane_found: bool


def counts(entry: dict) -> bool:
    """Whether an object of scene.json can be expected to be found."""
    share = entry.get("visible_share", {}).get("left", 1.0)
    return entry["visible_px"]["left"] >= LEAST_VISIBLE_PX and share >= LEAST_VISIBLE_SHARE


def score_scene(
    truth: np.ndarray,
    found: np.ndarray,
    scene: dict,
    *,
    plane: tuple[Sequence[float], float] | None = None,
    depth_m: np.ndarray | None = None,
    true_depth_m: np.ndarray | None = None,
) -> SceneScore:
    """Compare a segmentation with the truth.

    Args:
        truth: (H, W) ids of scene's objects, 0 = background.
        found: (H, W) ids of the segments, 0 = background.
        scene: content of scene.json.
        plane: (normal, offset_m) of the table plane that was found, in the camera frame.
        depth_m: (H, W) depth, NaN where unknown.
        true_depth_m: (H, W), NaN where there is none.
    """
    overlap = np.zeros((256, 256), np.int64)  # segment, object
    np.add.at(overlap, (found.ravel(), truth.ravel()), 1)
    segment_px, object_px = overlap.sum(axis=1), overlap.sum(axis=0)
    union = segment_px[:, None] + object_px[None] - overlap
    iou = np.where(overlap > 0, overlap / np.maximum(union, 1), 0.0)
    iou[0] = iou[:, 0] = 0

    segments = [number for number in range(1, 256) if segment_px[number]]
    false = [number for number in segments if iou[number].max() <= FOUND_IOU]
    on_nothing = [
        number for number in false if overlap[number, 1:].sum() < NOTHING_SHARE * segment_px[number]
    ]
    objects = []
    for entry in scene["objects"]:
        if not counts(entry):
            continue
        segment = int(iou[:, entry["id"]].argmax())
        score = {"id": entry["id"], "iou": float(iou[segment, entry["id"]])}
        if score["iou"] > FOUND_IOU:
            score["hole_filled"] = _hole_filled(truth, truth == entry["id"], found == segment)
            if depth_m is not None and true_depth_m is not None:
                on_object = (truth == entry["id"]) & (found == segment)
                score.update(_depth_errors(depth_m[on_object], true_depth_m[on_object]))
        if plane is not None:
            score.update(_plane_errors(plane, scene["table_plane"], entry["cam_from_object"]))
        objects.append(ObjectScore(**score))
    return SceneScore(tuple(objects), len(false), len(on_nothing), plane is not None)


def _hole_filled(truth: np.ndarray, object_mask: np.ndarray, segment: np.ndarray) -> float | None:
    hole = ndimage.binary_fill_holes(object_mask) & (truth == 0)
    return float(segment[hole].mean()) if hole.sum() >= LEAST_HOLE_PX else None


def _depth_errors(depth_m: np.ndarray, true_depth_m: np.ndarray) -> dict:
    error_mm = 1000 * np.abs(depth_m - true_depth_m)[np.isfinite(true_depth_m)]
    known = np.isfinite(error_mm)
    if not known.any():
        return {"depth_known": 0.0}
    return {
        "depth_known": float(known.mean()),
        "depth_errors_mm": tuple(np.quantile(error_mm[known], DEPTH_QUANTILES).tolist()),
    }


def _plane_errors(plane, true_plane, cam_from_object) -> dict:
    normal, offset_m = np.asarray(plane[0]), plane[1]
    true_normal, true_offset_m = np.asarray(true_plane["normal"]), true_plane["offset_m"]
    origin = np.asarray(cam_from_object)[:3, 3]
    foot = origin - true_normal * (true_normal @ origin + true_offset_m)
    # By the sine of half the angle: the cosine of a small one has no digits left.
    angle = 2 * np.arcsin(min(1.0, np.linalg.norm(normal - true_normal) / 2))
    return {
        "plane_angle_deg": float(np.degrees(angle)),
        "plane_height_mm": float(1000 * abs(normal @ foot + offset_m)),
    }
