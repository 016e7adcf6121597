"""Pairs of images that hold no object, or are no stereo pair: where the only right answer is none."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import graspctx as gc
import numpy as np
from scipy import ndimage

RENDERED = ("empty_textured", "empty_faint", "empty_plain")
"""Cases that need rendered scenes without objects."""
FROM_SCENES = ("swapped", "identical", "unrelated")
"""Cases made from the pictures of scenes with objects."""
MADE_UP = ("wall", "noise", "ten_dots", "constant")
CASES = {
    "empty_textured": "a textured table with nothing on it",
    "empty_faint": "the same, of a few grey levels of contrast",
    "empty_plain": "the same, of one colour",
    "wall": "a wall that fills both views, upright, from any side; textured, faint and plain in turn",
    "noise": "noise, another in each view; normal or uniform, grey or coloured",
    "swapped": "a scene's right view as the left one and the other way round",
    "identical": "a scene's left view twice",
    "unrelated": "the left view of a scene and the right one of another",
    "ten_dots": "ten bright dots on grey: anywhere in each view, or in both at any distance, in turn",
    "constant": "one colour, with and without the noise of a sensor in turn",
}

Pair = tuple[np.ndarray, np.ndarray, gc.StereoCamera]


def made_up_pair(case: str, seed: int, index: int, image_size: tuple[int, int] = (640, 480)) -> Pair:
    """A pair of one of the MADE_UP cases: left and right view, RGB, and their camera. The same for the same
    arguments."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, MADE_UP.index(case), index]))
    width, height = image_size
    camera = gc.StereoCamera(
        focal_px=width / 2 / np.tan(np.radians(rng.uniform(54, 58)) / 2),
        centre_px=((width - 1) / 2, (height - 1) / 2),
        baseline_m=rng.uniform(0.078, 0.082),
        width_px=width,
        height_px=height,
    )
    make = {"wall": _wall, "noise": _noise, "ten_dots": _ten_dots, "constant": _constant}[case]
    left, right = make(rng, index, camera)
    return left, right, camera


def pair_from_scenes(case: str, scene: Path, other: Path) -> Pair:
    """A pair of one of the FROM_SCENES cases, of the pictures in one scene's folder or two."""
    left, right = gc.read_image(scene / "left.png"), gc.read_image(scene / "right.png")
    camera = gc.StereoCamera.load(scene / "calib.txt")
    if case == "swapped":
        return right, left, camera
    if case == "identical":
        return left, left, camera
    return left, gc.read_image(other / "right.png"), camera


def _wall(rng, index, camera):
    from graspctx.sim.surfaces import SURFACE_KINDS, surface_texture

    texture = surface_texture(int(rng.integers(2**48)), SURFACE_KINDS[index % len(SURFACE_KINDS)])
    texture_m = rng.uniform(0.8, 2.0)  # after which it repeats
    # Cameras that look up at it see what a table is from above: here they look up by 5° at most.
    yaw, down = np.radians(rng.uniform(-40, 40)), np.radians(rng.uniform(-5, 20))
    normal = np.array([np.sin(yaw), np.cos(yaw) * np.sin(down), -np.cos(yaw) * np.cos(down)])
    distance_m, roll = rng.uniform(0.6, 2.0), np.radians(rng.uniform(-5, 5))
    across = np.cross(normal, [np.sin(roll), -np.cos(roll), 0.0])
    across /= np.linalg.norm(across)
    axes = np.stack([across, np.cross(normal, across)])
    at_m = rng.uniform(0, 2, 2)
    noise, exposure = rng.uniform(0.5, 2.5), rng.uniform(0.97, 1.03)

    views = []
    for origin, factor in ((np.zeros(3), 1.0), (np.array([camera.baseline_m, 0, 0]), exposure)):
        v, u = np.mgrid[: 2 * camera.height_px, : 2 * camera.width_px] / 2 - 0.25  # averaged over the pixel
        centre_u, centre_v = camera.centre_px
        rays = np.stack(
            [(u - centre_u) / camera.focal_px, (v - centre_v) / camera.focal_px, np.ones_like(u)], -1
        )
        reach = (-distance_m - normal @ origin) / (rays @ normal)
        points = origin + rays * reach[..., None]
        texels = (points @ axes.T + at_m) / texture_m * len(texture)
        light = np.stack(
            [
                ndimage.map_coordinates(
                    texture[..., channel].astype(np.float32),
                    np.moveaxis(texels, -1, 0),
                    order=1,
                    mode="grid-wrap",
                )
                for channel in range(3)
            ],
            -1,
        )
        light = light.reshape(camera.height_px, 2, camera.width_px, 2, 3).mean(axis=(1, 3))
        views.append(_seen(rng, factor * light, noise))
    return views


def _noise(rng, index, camera):
    shape = (camera.height_px, camera.width_px, 1 if index % 4 < 2 else 3)
    views = []
    for _ in range(2):
        if index % 2:
            view = rng.uniform(0, 255, shape)
        else:
            view = 120 + np.geomspace(3, 60, 5)[index // 2 % 5] * rng.standard_normal(shape)
        views.append(np.repeat(_bytes(view), 4 - shape[2], axis=2)[..., :3])
    return views


def _ten_dots(rng, index, camera):
    level, noise = rng.uniform(40, 160), rng.uniform(0, 2)
    v, u = np.mgrid[: camera.height_px, : camera.width_px]
    views = np.full((2, camera.height_px, camera.width_px, 3), level)
    for _ in range(10):
        radius, colour = rng.uniform(0.8, 3), rng.uniform(level + 50, 255, 3)
        at = rng.uniform(0.05, 0.95, (2, 2)) * (camera.width_px, camera.height_px)
        if index % 2:  # the same dot in both views
            at[0, 0] = max(at[0, 0], 0.25 * camera.width_px)
            at[1] = at[0] - (rng.uniform(0.01, 0.2) * camera.width_px, 0)
        for view, (dot_u, dot_v) in zip(views, at):
            view[(u - dot_u) ** 2 + (v - dot_v) ** 2 <= radius**2] = colour
    return [_seen(rng, view, noise) for view in views]


def _constant(rng, index, camera):
    colour = ([0, 0, 0], [255, 255, 255], [128, 128, 128], rng.uniform(0, 255, 3))[index // 2 % 4]
    view = np.broadcast_to(np.asarray(colour, float), (camera.height_px, camera.width_px, 3))
    return [_seen(rng, view, rng.uniform(0.5, 2.5) if index % 2 else 0.0) for _ in range(2)]


def _seen(rng, light, noise):
    return _bytes(light + noise * rng.standard_normal(light.shape))


def _bytes(light):
    return np.clip(light + 0.5, 0, 255).astype(np.uint8)


def scenes_in_turn(sets: Sequence[Sequence[Path]]) -> list[tuple[Path, Path]]:
    """Scenes of all sets, one of each in turn, each with another of its own set, or with itself if alone."""
    return [
        (scenes[index], scenes[(index + 1) % len(scenes)])
        for index in range(max(map(len, sets), default=0))
        for scenes in sets
        if index < len(scenes)
    ]
