"""Sheets of responses: patches coloured by P, the mask that was given, the label, and the best patch.

Dark to yellow is P from 0 to 1; the mask is outlined in white, the label in cyan. The ring is the most
probable patch: green on the label, red beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import graspctx as gc
import numpy as np
import report
from grasp_point_methods import Method
from PIL import Image, ImageDraw
from scipy import ndimage

MASK, LABEL, HIT, MISS, TEXT = (255, 255, 255), (0, 220, 255), (0, 255, 0), (255, 0, 0), (0, 0, 0)
_TILE_PX, _TITLE_PX, _MARGIN = 220, 18, 0.2  # the margin is a share of the object's longer side
_LEAST, _MIDDLE, _MOST = np.array([(20, 10, 90), (215, 70, 90), (255, 240, 60)], float)


def colour_of(probability: float) -> tuple[int, int, int]:
    """Dark blue at 0, red at 0.5, yellow at 1."""
    low, high = (_LEAST, _MIDDLE) if probability < 0.5 else (_MIDDLE, _MOST)
    share = 2 * probability - (probability >= 0.5)
    return tuple(int(value) for value in low + share * (high - low))


def response_tile(view: gc.LabelledView, method: Method, around: np.ndarray | None = None) -> Image.Image:
    """What a method makes of an object at the view's mask, in the picture around it.

    Args:
        around: (H, W) bool, the mask that the picture is cut out around; by default the view's own.
    """
    mask, label = view.mask > 0, view.label > 0
    rows, columns = np.nonzero(mask if around is None else around)
    side = 1 + max(np.ptp(rows), np.ptp(columns))
    half = side * (0.5 + _MARGIN)
    left, top = columns.min() + (np.ptp(columns) + 1) / 2 - half, rows.min() + (np.ptp(rows) + 1) / 2 - half
    box = (left, top, left + 2 * half, top + 2 * half)
    scale = _TILE_PX / (2 * half)

    def cut(pixels, resample):
        size = (_TILE_PX, _TILE_PX)
        return Image.fromarray(pixels).transform(size, Image.Transform.EXTENT, box, resample)

    image = np.repeat(view.image[..., None], 3, axis=2) if view.image.ndim == 2 else view.image
    tile = cut(image, Image.Resampling.BILINEAR)
    patches, scores = method.score(view)
    centres = np.asarray(patches.fovea.image_from_view(patches.described.patches.centres.astype(float)))
    centres = (centres - (left, top) + 0.5) * scale
    half_patch = 5 / patches.fovea.scale * scale
    response = tile.copy()
    draw = ImageDraw.Draw(response)
    for (u, v), score in zip(centres, scores):
        square = [u - half_patch, v - half_patch, u + half_patch, v + half_patch]
        draw.rectangle(square, fill=colour_of(float(score)))
    tile = Image.blend(tile, response, 0.6)
    for outlined, colour in ((mask, MASK), (label, LABEL)):
        inside = np.asarray(cut(outlined.astype(np.uint8) * 255, Image.Resampling.NEAREST)) > 0
        pixels = np.array(tile)
        pixels[inside & ~ndimage.binary_erosion(inside)] = colour
        tile = Image.fromarray(pixels)
    if len(scores):
        best = int(np.argmax(scores))
        u, v = centres[best]
        ring = [u - 9, v - 9, u + 9, v + 9]
        hit = bool(patches.described.labels[best])
        ImageDraw.Draw(tile).ellipse(ring, outline=HIT if hit else MISS, width=3)
    return tile


def write_sheet(file: Path, lines: Sequence[Sequence[tuple[str, Image.Image]]]) -> None:
    """Write lines of titled tiles as a PNG; whole or not at all. Nothing is written without lines.

    Raises:
        BadInputError: the file cannot be written.
    """
    if not lines:
        return
    width = _TILE_PX * max(len(line) for line in lines)
    sheet = Image.new("RGB", (width, (_TILE_PX + _TITLE_PX) * len(lines)), (255, 255, 255))
    draw = ImageDraw.Draw(sheet)
    for row, line in enumerate(lines):
        for column, (title, tile) in enumerate(line):
            u, v = column * _TILE_PX, row * (_TILE_PX + _TITLE_PX)
            draw.text((u + 4, v + 3), title, fill=TEXT)
            sheet.paste(tile, (u, v + _TITLE_PX))
    partial = file.with_name(file.name + ".partial")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        sheet.save(partial, "png")
        partial.replace(file)
    except OSError as error:
        raise report.BadInputError(f"{file}: cannot be written: {error.strerror}") from error
