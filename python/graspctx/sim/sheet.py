"""A contact sheet of a data set: whole pictures beside labelled close-ups, family by family."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from .stored import DatasetError, read_scene, scene_folders

OUTLINE = np.array([255, 255, 0], np.uint8)
LABEL = np.array([255, 0, 60], np.uint8)
_PAPER, _INK = (250, 250, 250), (20, 20, 20)
_COLUMNS = 3
_TILES = 24
"""About as many scenes are shown, and at least a row of every family."""
_PICTURE_WIDTH, _GAP = 320, 6
_CAPTION_HEIGHT = 26


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


def write_sheet(dataset: str | os.PathLike, file: str | os.PathLike) -> None:
    """Write a picture in which scenes stand for every family of a data set.

    Raises:
        DatasetError: there is no data set, or a picture of it cannot be read.
    """
    scenes = [(folder, read_scene(folder)) for folder in scene_folders(dataset)]
    tiles = [
        _tile(folder, info, family)
        for family, chosen in choose_scenes(scenes).items()
        for folder, info in chosen
    ]
    step_u, step_v = tiles[0].width + _GAP, max(tile.height for tile in tiles) + _GAP
    rows = -(-len(tiles) // _COLUMNS)
    sheet = Image.new("RGB", (min(len(tiles), _COLUMNS) * step_u + _GAP, rows * step_v + _GAP), _PAPER)
    for number, tile in enumerate(tiles):
        row, column = divmod(number, _COLUMNS)
        sheet.paste(tile, (_GAP + column * step_u, _GAP + row * step_v))
    file = Path(file)
    partial = file.with_name(file.name + ".partial")
    sheet.save(partial, "png")
    partial.replace(file)


def choose_scenes(scenes: Sequence[tuple[Path, dict]]) -> dict[str, list[tuple[Path, dict]]]:
    """The scenes that stand for each family, by name: whole rows, as many for each, spread over the set.

    A scene of several families stands for the one that has fewest scenes.
    """
    holding = {}
    for scene in scenes:
        for family in _families(scene[1]):
            holding.setdefault(family, []).append(scene)
    rows = max(1, _TILES // _COLUMNS // len(holding))
    chosen, used = {}, set()
    for family in sorted(holding, key=lambda name: (len(holding[name]), name)):
        wanted = min(len(holding[family]), rows * _COLUMNS)
        fresh = [scene for scene in holding[family] if scene[0] not in used]
        picks = np.linspace(0, len(fresh) - 1, min(len(fresh), wanted)).astype(int)
        again = [scene for scene in holding[family] if scene[0] in used]
        chosen[family] = [fresh[pick] for pick in picks] + again[: wanted - len(picks)]
        used.update(folder for folder, _ in chosen[family])
    return dict(sorted(chosen.items()))


def _families(info):
    """Families in a scene; one that holds no object stands for itself."""
    return list(dict.fromkeys(entry["family"] for entry in info["objects"])) or ["(no object)"]


def _tile(folder, info, family):
    """The left picture, beside it a labelled close-up of the objects of `family`, over them a caption."""
    colour, instances, label = (_read(folder / f"left{name}.png") for name in ("", "_mask", "_label"))
    if colour.ndim != 3 or not colour.shape[:2] == instances.shape == label.shape:
        raise DatasetError(f"{folder}: left.png, left_mask.png and left_label.png do not belong together")
    height = round(_PICTURE_WIDTH * colour.shape[0] / colour.shape[1])
    ids = [entry["id"] for entry in info["objects"] if entry["family"] == family]
    box = _close_up(np.isin(instances, ids))
    whole = Image.fromarray(colour).resize((_PICTURE_WIDTH, height), Image.Resampling.BOX)
    labelled = Image.fromarray(overlay(colour, instances, label))
    labelled = labelled.resize((_PICTURE_WIDTH, height), Image.Resampling.LANCZOS, box)
    tile = Image.new("RGB", (2 * _PICTURE_WIDTH, _CAPTION_HEIGHT + height), _PAPER)
    draw, font = ImageDraw.Draw(tile), ImageFont.load_default(18)
    draw.text((0, 2), family, _INK, font)
    draw.text(
        (font.getlength(family) + 12, 6), _caption(folder, info, family), _INK, ImageFont.load_default(13)
    )
    tile.paste(whole, (0, _CAPTION_HEIGHT))
    tile.paste(labelled, (_PICTURE_WIDTH, _CAPTION_HEIGHT))
    return tile


def _caption(folder, info, family):
    """The scene's name, and where it stands on the axes that one sees in a picture."""
    axes = info.get("axes", {})
    poses = [str(entry["pose"]) for entry in info["objects"] if entry["family"] == family and "pose" in entry]
    words = [
        folder.name.removeprefix("scene_"),
        f"{axes.get('table') or info.get('table_texture')} table",
        *dict.fromkeys(poses),
    ]
    if "background" in axes:
        words.append(f"{axes['background']} behind")
    if axes.get("spacing") == "touching":
        words.append("touching")
    if axes.get("occlusion", 0) > 0.05:
        words.append(f"{100 * axes['occlusion']:.0f} % hidden")
    if "distance_m" in axes:
        words.append(f"{axes['distance_m']:.2f} m")
    if "elevation_deg" in axes:
        words.append(f"{axes['elevation_deg']:.0f}°")
    return "  ·  ".join(words)


def _close_up(mask):
    """(left, top, right, bottom) of the image's shape around the mask; the whole image if it is empty."""
    height, width = mask.shape
    v, u = np.nonzero(mask)
    if len(v) == 0:
        return 0, 0, width, height
    # 15 % around it, and at least a sixth of the picture, so that a far pencil is not blown up to squares.
    scale = max(1.3 * (np.ptp(u) + 1) / width, 1.3 * (np.ptp(v) + 1) / height, 1 / 6)
    scale = min(scale, 1.0)
    left = np.clip((u.min() + u.max() + 1 - scale * width) / 2, 0, (1 - scale) * width)
    top = np.clip((v.min() + v.max() + 1 - scale * height) / 2, 0, (1 - scale) * height)
    return left, top, left + scale * width, top + scale * height


def _read(file):
    try:
        return np.asarray(Image.open(file))
    except FileNotFoundError as error:
        raise DatasetError(f"{file}: missing") from error
    except (OSError, SyntaxError, Image.DecompressionBombError) as error:
        raise DatasetError(f"{file}: not readable as PNG ({error})") from error
