"""Masks that get worse and worse, as those of Fig. 6, made from an object's true mask.

They are in pixels of the image, most of them worse than those of augment_views, the same for the same seed.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

DILATIONS_PX = (4, 8, 16)
WEDGE_REACH = 0.3  # of the object's longer side
WEDGE_HALF_ANGLE_RAD = np.deg2rad(35)
CUT_SHARE = 0.2

DEGRADED = {
    "again": "the true mask once more: what does not return here is chance in the method itself",
    **{f"dilate{radius}": f"dilated by {radius} px of the image" for radius in DILATIONS_PX},
    "wedge": f"with a wedge of what is below it, {np.rad2deg(2 * WEDGE_HALF_ANGLE_RAD):.0f}° wide, "
    f"{WEDGE_REACH:.0%} of its longer side beyond it",
    "cut20": f"{CUT_SHARE:.0%} of its pixels cut off by a line of any direction",
}


def mask_seed(scene: dict) -> int:
    """The seed of the worse masks of a scene's objects, from what read_scene gives."""
    return int(scene["seed"]) + int(scene["index"])


def degraded_mask(mask: np.ndarray, name: str, seed: int) -> np.ndarray:
    """A mask made worse: (H, W) bool.

    Args:
        mask: (H, W) bool, with an object.
        name: a key of DEGRADED.
        seed: of the wedge's and the cut's direction.
    """
    rng = np.random.default_rng([seed, list(DEGRADED).index(name)])
    if name == "again":
        return mask.copy()
    if name == "wedge":
        return with_wedge(mask, rng.uniform(0.15, 0.85) * np.pi)
    if name == "cut20":
        return cut_off(mask, rng.uniform(0, 2 * np.pi))
    return dilated(mask, int(name.removeprefix("dilate")))


def dilated(mask: np.ndarray, radius_px: float) -> np.ndarray:
    """All pixels that lie no farther than radius_px from the mask: (H, W) bool."""
    return ndimage.distance_transform_edt(~mask) <= radius_px


def with_wedge(mask: np.ndarray, direction_rad: float) -> np.ndarray:
    """The mask and a wedge, seen from its centroid, of what lies beyond it; direction from +u towards +v."""
    v, u = np.mgrid[: mask.shape[0], : mask.shape[1]]
    rows, columns = np.nonzero(mask)
    angle = np.arctan2(v - rows.mean(), u - columns.mean()) - direction_rad
    inside = np.abs((angle + np.pi) % (2 * np.pi) - np.pi) <= WEDGE_HALF_ANGLE_RAD
    longer_side = 1 + max(np.ptp(rows), np.ptp(columns))
    return mask | (inside & dilated(mask, WEDGE_REACH * longer_side))


def cut_off(mask: np.ndarray, direction_rad: float) -> np.ndarray:
    """The mask without the share CUT_SHARE of its pixels that lies farthest in a direction from +u to +v."""
    v, u = np.nonzero(mask)
    along = np.cos(direction_rad) * u + np.sin(direction_rad) * v
    kept = np.argsort(along, kind="stable")[: max(1, round((1 - CUT_SHARE) * len(along)))]
    result = np.zeros_like(mask)
    result[v[kept], u[kept]] = True
    return result
