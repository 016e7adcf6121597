"""Read what stands in a data set: its header and the scene.json of every scene."""

from __future__ import annotations

import json
import os
from pathlib import Path


class DatasetError(Exception):
    """A folder is no data set, or cannot take one; the message names it and says why."""


def scene_folders(dataset: str | os.PathLike) -> list[Path]:
    """The folders of a data set's scenes, sorted by name; DatasetError if there are none."""
    dataset = Path(dataset)
    if not dataset.is_dir():
        raise DatasetError(f"{dataset}: no such folder; expected a data set")
    folders = [file.parent for file in dataset.glob("*/scene.json") if file.parent.suffix != ".partial"]
    if not folders:
        raise DatasetError(f"{dataset}: no scenes in it; expected folders that hold a scene.json")
    return sorted(folders, key=lambda folder: os.fsencode(folder.name))


def read_json(file: Path) -> dict:
    """A JSON object from a file; DatasetError if it holds none."""
    try:
        content = json.loads(file.read_bytes())
    except FileNotFoundError as error:
        raise DatasetError(f"{file}: missing") from error
    except (ValueError, RecursionError) as error:
        raise DatasetError(f"{file}: not readable as JSON ({error})") from error
    if not isinstance(content, dict):
        raise DatasetError(f"{file}: holds a {type(content).__name__}; expected a JSON object")
    return content


def read_header(dataset: str | os.PathLike) -> dict:
    """The content of dataset.json."""
    file = Path(dataset) / "dataset.json"
    header = read_json(file)
    if (header.get("format"), header.get("version")) != ("graspctx-dataset", 1):
        raise DatasetError(
            f"{file}: format {header.get('format')!r}, version {header.get('version')!r}; "
            "expected 'graspctx-dataset', 1"
        )
    return header


def read_scene(folder: Path) -> dict:
    """The content of a scene's scene.json; it has a list of objects, each with an id and a family."""
    file = folder / "scene.json"
    scene = read_json(file)
    objects = scene.get("objects")
    if not isinstance(objects, list) or not all(
        isinstance(entry, dict) and isinstance(entry.get("family"), str) and isinstance(entry.get("id"), int)
        for entry in objects
    ):
        raise DatasetError(f"{file}: expected a list of objects, each with an id and a family")
    return scene


def read_scenes(dataset: str | os.PathLike) -> list[dict]:
    """The scene.json of every scene, in the order of their folders."""
    return [read_scene(folder) for folder in scene_folders(dataset)]
