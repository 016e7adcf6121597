"""A contact sheet of a data set: each left image beside its mask outlines and labels."""

from pathlib import Path

import numpy as np
from PIL import Image

OUTLINE = np.array([255, 255, 0], np.uint8)
LABEL = np.array([255, 0, 60], np.uint8)


def overlay(colour: np.ndarray, instances: np.ndarray, label: np.ndarray) -> np.ndarray:
    """(H, W, 3) uint8 picture with the instances outlined in yellow and the grasp region tinted red.

    Args:
        colour: (H, W, 3) uint8.
        instances: (H, W) uint8 ids.
        label: (H, W) uint8, 255 on the grasp region.
    """
    picture = colour.copy()
    picture[label > 0] = picture[label > 0] // 3 + LABEL // 3 * 2
    outline = np.zeros(instances.shape, bool)
    outline[:-1] |= instances[:-1] != instances[1:]
    outline[:, :-1] |= instances[:, :-1] != instances[:, 1:]
    picture[outline] = OUTLINE
    return picture


def write_sheet(
    dataset: Path, file: Path, *, most: int = 24, columns: int = 3, tile_width: int = 320
) -> None:
    """Write a picture of the first `most` scenes of a data set."""
    folders = sorted(path.parent for path in Path(dataset).glob("*/scene.json"))[:most]
    tiles = []
    for folder in folders:
        colour, instances, label = (
            np.asarray(Image.open(folder / f"left{name}.png")) for name in ("", "_mask", "_label")
        )
        pair = Image.fromarray(np.hstack([colour, overlay(colour, instances, label)]))
        size = (2 * tile_width, round(tile_width * colour.shape[0] / colour.shape[1]))
        tiles.append(np.asarray(pair.resize(size, Image.Resampling.BOX)))
    while len(tiles) % columns:
        tiles.append(np.zeros_like(tiles[0]))
    rows = [np.hstack(tiles[start : start + columns]) for start in range(0, len(tiles), columns)]
    Image.fromarray(np.vstack(rows)).save(file)
