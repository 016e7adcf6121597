"""Small scenes of known truth for the tests: no files, no renderer."""

import graspctx as gc
import numpy as np

WIDTH, HEIGHT = 320, 240
FOCAL_PX, BASELINE_M = 300.0, 0.08
BACKGROUND_PX, OBJECT_PX = 16.0, 32.0  # disparities: a wall at 1.5 m, a disc at 0.75 m
DISC_CENTRE_PX, DISC_RADIUS_PX = (170, 120), 42


def camera() -> gc.StereoCamera:
    return gc.StereoCamera(
        focal_px=FOCAL_PX,
        centre_px=((WIDTH - 1) / 2, (HEIGHT - 1) / 2),
        baseline_m=BASELINE_M,
        width_px=WIDTH,
        height_px=HEIGHT,
    )


def smooth_noise(rng: np.random.Generator, height: int, width: int) -> np.ndarray:
    """Texture with edges a few pixels apart, 0 to 1."""
    coarse = rng.random((height // 4 + 2, width // 4 + 2))
    rows, columns = np.arange(height) / 4, np.arange(width) / 4
    r, c = rows.astype(int)[:, None], columns.astype(int)[None]
    fr, fc = (rows % 1)[:, None], (columns % 1)[None]
    top = coarse[r, c] * (1 - fc) + coarse[r, c + 1] * fc
    bottom = coarse[r + 1, c] * (1 - fc) + coarse[r + 1, c + 1] * fc
    return top * (1 - fr) + bottom * fr


def disc_scene(seed: int = 1) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both views (RGB) of a textured disc before a textured wall, and the disc's mask in the left one."""
    rng = np.random.default_rng(seed)
    margin = 64
    wall = smooth_noise(rng, HEIGHT, WIDTH + margin)
    disc = smooth_noise(rng, HEIGHT, WIDTH + margin)
    tint = np.array([220, 90, 40])
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    views = []
    for is_right in (False, True):
        shift_wall, shift_disc = (int(BACKGROUND_PX), int(OBJECT_PX)) if is_right else (0, 0)
        inside = (u + shift_disc - DISC_CENTRE_PX[0]) ** 2 + (v - DISC_CENTRE_PX[1]) ** 2 <= DISC_RADIUS_PX**2
        background = wall[:, shift_wall : shift_wall + WIDTH, None] * [120, 140, 150]
        front = (0.4 + 0.6 * disc[:, shift_disc : shift_disc + WIDTH, None]) * tint
        views.append(np.where(inside[..., None], front, background).astype(np.uint8))
    mask = (u - DISC_CENTRE_PX[0]) ** 2 + (v - DISC_CENTRE_PX[1]) ** 2 <= DISC_RADIUS_PX**2
    return views[0], views[1], mask.astype(np.uint8)


def disc_model(**options: object) -> gc.GraspModel:
    """A model that takes the upper part of the disc for graspable, trained on a few such views."""
    features, labels, groups = [], [], []
    for group in range(6):
        left, _, mask = disc_scene(seed=100 + group)
        view = gc.foveal_view(left, mask)
        patches = gc.describe_view(view)
        features.append(patches.features)
        labels.append(patches.centres[:, 1] < 90)
        groups.append(np.full(len(patches), group))
    return gc.train_model(
        np.concatenate(features),
        np.concatenate(labels),
        np.concatenate(groups),
        name="disc",
        classes=["disc"],
        folds=3,
        svm_c=[10],
        gamma_times_dimension=[1],
        **options,
    )
