"""Write rendered scenes as a data set; the layout is defined in docs/dataset-format.md."""

from __future__ import annotations

import json
import multiprocessing
import os
import shutil
from collections.abc import Callable
from pathlib import Path

from .families import FAMILIES
from .render import Renderer, choose_gl
from .scene import draw_scene
from .scene_files import encode_json, encode_scene

LOOKS = 3
"""Counts the changes after which the same seed gives other pictures."""


class DatasetError(Exception):
    """The output folder cannot take the data set; the message names it and says why."""


def scene_folder(index: int) -> str:
    """Name of a scene's folder."""
    return f"scene_{index:06d}"


def make_dataset(
    out: str | os.PathLike,
    scenes: int,
    seed: int,
    *,
    families: list[str] | None = None,
    objects: tuple[int, int] = (1, 1),
    image_size: tuple[int, int] = (640, 480),
    split: str = "train",
    workers: int = 1,
    progress: Callable[[], None] | None = None,
) -> None:
    """Render scenes into a folder. The same arguments give the same bytes, with any number of workers.

    Scenes that stand in `out` already are kept: an interrupted run can be taken up again, a set made larger.

    Args:
        out: folder to write; made if missing.
        scenes: number of scenes.
        seed: scene i depends on (seed, i) alone.
        families: names of object families; None for all.
        objects: (fewest, most) objects in a scene.
        image_size: (width, height) px.
        split: "train", "validation" or "test"; two splits share no shape and no texture.
        workers: processes.
        progress: called after each scene.

    Raises:
        DatasetError: `out` holds something else.
    """
    out = Path(out)
    families = list(families or FAMILIES)
    header = {
        "format": "graspctx-dataset",
        "version": 1,
        "seed": seed,
        "families": families,
        "scenes": scenes,
        "objects": list(objects),
        "image_size": list(image_size),
        "split": split,
        "looks": LOOKS,
    }
    done = _scenes_done(out, header)
    out.mkdir(parents=True, exist_ok=True)
    (out / "dataset.json").write_bytes(encode_json(header))
    jobs = []
    for index in range(scenes):
        if index in done:
            if progress:
                progress()
        else:
            jobs.append((str(out), seed, index, families, objects, image_size, split))
    if workers <= 1 or len(jobs) <= 1:
        with Renderer() as renderer:
            for job in jobs:
                _make_scene(renderer, *job)
                if progress:
                    progress()
        return
    choose_gl()
    os.environ.setdefault("LP_NUM_THREADS", "1")  # Mesa would start threads for every core in every worker
    with multiprocessing.get_context("spawn").Pool(min(workers, len(jobs)), _start_worker) as pool:
        for _ in pool.imap_unordered(_work, jobs, chunksize=max(1, min(8, len(jobs) // (4 * workers)))):
            if progress:
                progress()


_worker_renderer: Renderer | None = None


def _start_worker():
    global _worker_renderer
    _worker_renderer = Renderer()


def _work(job):
    _make_scene(_worker_renderer, *job)


def _scenes_done(out: Path, header: dict) -> set[int]:
    """Indices of the scenes that stand in `out`; DatasetError if they are not a part of what is asked for."""
    if not out.exists():
        return set()
    if not out.is_dir():
        raise DatasetError(f"{out}: is a file; expected a folder to write the data set to")
    file = out / "dataset.json"
    if not file.exists():
        if any(out.iterdir()):
            raise DatasetError(
                f"{out}: holds files but no dataset.json; expected a new or empty folder, or a data set"
            )
        return set()
    try:
        before = json.loads(file.read_text())
        other = [key for key in header if key != "scenes" and before.get(key) != header[key]]
    except (ValueError, AttributeError) as error:
        raise DatasetError(f"{file}: not a data set header ({error}); expected JSON") from error
    if other:
        key = other[0]
        raise DatasetError(
            f"{file}: made with other options: {key} {before.get(key)}; expected {header[key]}"
        )
    done = set()
    for folder in out.glob("scene_" + 6 * "[0-9]" + "*"):
        if folder.name.endswith(".partial"):
            shutil.rmtree(folder)
        elif (folder / "scene.json").exists():
            done.add(int(folder.name.removeprefix("scene_")))
    if done and max(done) >= header["scenes"]:
        raise DatasetError(
            f"{out}: holds scene {max(done)} already; expected at most {header['scenes']} scenes"
        )
    return done


def _make_scene(renderer: Renderer, out, seed, index, families, objects, image_size, split):
    scene = draw_scene(seed, index, families=families, objects=objects, image_size=image_size, split=split)
    left, right = renderer.render(scene)
    folder = Path(out) / scene_folder(index)
    partial = folder.with_name(folder.name + ".partial")
    if partial.exists():
        shutil.rmtree(partial)
    partial.mkdir()
    for name, content in encode_scene(scene, left, right).items():
        (partial / name).write_bytes(content)
    partial.rename(folder)
