"""Contact sheets of segmented scenes: the truth outlined in red, segments in green."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import graspctx as gc
import numpy as np
from PIL import Image, ImageDraw
from scipy import ndimage

TRUTH, SEGMENT, CAPTION = (255, 0, 0), (0, 255, 0), (255, 255, 0)
_COLUMNS, _TILE = 4, (480, 360)


def read_depth_m(file: Path) -> np.ndarray:
    """(H, W) depth in metres of a data set's scene, NaN where there is none."""
    depth = np.asarray(Image.open(file), np.float64) * 1e-4
    depth[depth == 0] = np.nan
    return depth


def write_scenes(file: Path, folders: Sequence[Path], cues: str) -> None:
    """Segment scenes of data sets again and write them with their truth on one sheet."""
    tiles = []
    for folder in folders:
        left, right = (gc.read_image(folder / f"{side}.png") for side in ("left", "right"))
        found = gc.segment_objects(left, right, gc.StereoCamera.load(folder / "calib.txt"), cues=cues)
        truth = gc.read_image(folder / "left_mask.png")
        tiles.append(_tile(left, f"{folder.parent.name}/{folder.name}", found, truth))
    _write_sheet(file, tiles)


def write_pairs(
    file: Path, pairs: Sequence[tuple[str, np.ndarray, np.ndarray, gc.StereoCamera]], cues: str
) -> None:
    """Segment pairs, each with a caption before its views and camera, and write them on one sheet."""
    _write_sheet(
        file,
        [
            _tile(left, caption, gc.segment_objects(left, right, camera, cues=cues))
            for caption, left, right, camera in pairs
        ],
    )


def _tile(left, caption, found, truth=None):
    picture = np.repeat(left[..., None], 3, axis=2) if left.ndim == 2 else left.copy()
    if truth is not None:
        picture[_outlines(truth)] = TRUTH
    picture[_outlines(found)] = SEGMENT
    tile = Image.fromarray(picture).resize(_TILE, Image.Resampling.BILINEAR)
    ImageDraw.Draw(tile).text((5, 4), caption, fill=CAPTION)
    return tile


def _outlines(ids):
    """The inner border, 2 px wide, of every instance."""
    inner = np.zeros(ids.shape, bool)
    for number in np.unique(ids[ids > 0]):
        mask = ids == number
        inner |= mask & ~ndimage.binary_erosion(mask, iterations=2)
    return inner


def _write_sheet(file, tiles):
    width, height = _TILE
    sheet = Image.new("RGB", (min(len(tiles), _COLUMNS) * width, -(-len(tiles) // _COLUMNS) * height))
    for number, tile in enumerate(tiles):
        row, column = divmod(number, _COLUMNS)
        sheet.paste(tile, (column * width, row * height))
    partial = file.with_name(file.name + ".partial")
    sheet.save(partial, "png")
    partial.replace(file)
