"""Checksums that prove that two data sets are the same.

`files` covers every byte that training and evaluation read. `scenes` covers what was drawn, not what was
rendered: it stays the same where another CPU or another version of Mesa gives other pixels.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from .stored import read_json, scene_folders

_MEASURED = {
    "visible_px", "label_px", "visible_share", "visible_label_share", "occlusion", "brightness",
}  # fmt: skip
"""Keys of scene.json that are measured in the pictures."""
_DECIMALS = 6  # numpy's last digits depend on the CPU


def files_checksum(dataset: str | os.PathLike) -> str:
    """SHA-256 of the listing that `sha256sum` prints for dataset.json and all files of the scenes.

    The shell's way to the same: (cd DATASET && find dataset.json scene_* -type f | LC_ALL=C sort |
    xargs sha256sum | sha256sum).
    """
    dataset = Path(dataset)
    files = [file for folder in scene_folders(dataset) for file in folder.rglob("*") if file.is_file()]
    names = [os.fsencode(file.relative_to(dataset)) for file in [dataset / "dataset.json", *files]]
    listing = hashlib.sha256()
    for name in sorted(names):
        content = (dataset / os.fsdecode(name)).read_bytes()
        listing.update(hashlib.sha256(content).hexdigest().encode() + b"  " + name + b"\n")
    return listing.hexdigest()


def scenes_checksum(dataset: str | os.PathLike) -> str:
    """SHA-256 of what the scene.json files say, without the counts of pixels, numbers to 6 decimals."""
    digest = hashlib.sha256()
    for folder in scene_folders(dataset):
        drawn = _drawn(read_json(folder / "scene.json"))
        digest.update(json.dumps(drawn, sort_keys=True).encode() + b"\n")
    return digest.hexdigest()


def _drawn(value):
    if isinstance(value, dict):
        return {key: _drawn(inner) for key, inner in value.items() if key not in _MEASURED}
    if isinstance(value, list):
        return [_drawn(inner) for inner in value]
    if isinstance(value, float):
        return round(value, _DECIMALS) + 0.0
    return value
