"""Write rendered scenes as a data set; the layout is defined in docs/dataset-format.md."""

from __future__ import annotations

import contextlib
import functools
import importlib.metadata
import os
import re
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from .difficulty import DIFFICULTIES, with_axis
from .families import FAMILIES, ObjectShape
from .scene_files import LOOKS, encode_json
from .splits import split_number
from .stored import DatasetError, read_json
from .workers import scene_renderer


def scene_folder(index: int) -> str:
    """Name of a scene's folder."""
    return f"scene_{index:06d}"


def make_dataset(
    out: str | os.PathLike,
    scenes: int,
    seed: int,
    *,
    families: list[str | ObjectShape] | None = None,
    objects: tuple[int, int] = (1, 1),
    image_size: tuple[int, int] = (640, 480),
    split: str = "train",
    difficulty: str = "default",
    axes: Sequence[str] = (),
    workers: int = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Render scenes into a folder. The same arguments give the same bytes, wherever the scenes are rendered.

    Scenes that stand in `out` already are kept: an interrupted run can be taken up again, a set made larger.
    Only whole scenes ever stand there, also after the process was killed.

    Args:
        out: folder to write; made if missing.
        scenes: number of scenes.
        seed: scene i depends on (seed, i) and on the options down to `axes` alone.
        families: names of object families, or objects (users' meshes); None for all families.
        objects: (fewest, most) objects in a scene; 0 is an empty table.
        image_size: (width, height) px.
        split: "train", "validation" or "test"; two splits share no shape and no texture.
        difficulty: name in DIFFICULTIES: what the scenes are drawn from.
        axes: changes of it, such as "table=faint"; see with_axis.
        workers: processes; 1 renders in this one.
        scheduler: address of a Dask scheduler, such as "tcp://10.0.0.1:8786": its workers render instead.
        progress: called at the start and after each scene with the number of scenes that stand in `out`, and
            how many of them stood there before.

    Raises:
        ValueError: an axis or its value is not known.
        NoViewError: objects do not fit into the views that the axes ask for.
        DatasetError: `out` holds something else, or another process is writing to it.
        WorkerError: the cluster cannot be used, or a worker died.
    """
    out = Path(out)
    split_number(split)
    families = list(families or FAMILIES)
    drawn_from = {
        "seed": seed,
        "families": families,
        "objects": list(objects),
        "image_size": list(image_size),
        "split": split,
    }
    header = {
        "format": "graspctx-dataset",
        "version": 1,
        "scenes": scenes,
        **drawn_from,
        "families": [name if isinstance(name, str) else name.content_name() for name in families],
        "difficulty": difficulty,
        "axes": list(axes),
        "looks": LOOKS,
        "mujoco": importlib.metadata.version("mujoco"),
    }
    drawn_from["difficulty"] = functools.reduce(with_axis, axes, DIFFICULTIES[difficulty])
    _check_output(out, header)
    # Workers first: nothing is written when there are none.
    needed = len(_scenes_done(out)) < scenes
    with scene_renderer(min(workers, scenes), scheduler) if needed else contextlib.nullcontext() as render:
        out.mkdir(parents=True, exist_ok=True)
        with _alone(out):
            kept = _take_up(out, header)
            if progress:
                progress(len(kept), len(kept))
            missing = [index for index in range(scenes) if index not in kept]
            rendered = render(drawn_from, missing) if missing else iter(())
            for finished, (index, files) in enumerate(rendered, len(kept) + 1):
                _write_scene(out, index, files)
                if progress:
                    progress(finished, len(kept))


def _take_up(out: Path, header: dict) -> set[int]:
    """Write the header, remove what an earlier run left unfinished; the scenes that it finished."""
    for partial in out.glob("scene_*.partial"):
        shutil.rmtree(partial)
    partial = out / "dataset.json.partial"
    partial.write_bytes(encode_json(header))
    partial.replace(out / "dataset.json")
    return _scenes_done(out)


def _check_output(out: Path, header: dict) -> None:
    """DatasetError if what stands in `out` is not a part of what is asked for."""
    if not out.exists():
        return
    if not out.is_dir():
        raise DatasetError(f"{out}: is a file; expected a folder to write the data set to")
    file = out / "dataset.json"
    if not file.exists():
        if any(out.iterdir()):
            raise DatasetError(
                f"{out}: holds files but no dataset.json; expected a new or empty folder, or a data set"
            )
        return
    before = read_json(file)
    other = [key for key in header if key != "scenes" and before.get(key) != header[key]]
    if other:
        key = other[0]
        raise DatasetError(
            f"{file}: made with other options: {key} {before.get(key)}; expected {header[key]}"
        )
    last = max(_scenes_done(out), default=-1)
    if last >= header["scenes"]:
        raise DatasetError(f"{out}: holds scene {last} already; expected at most {header['scenes']} scenes")


def _scenes_done(out: Path) -> set[int]:
    """Indices of the scenes that stand in `out`."""
    names = (file.parent.name for file in out.glob("scene_*/scene.json"))
    return {int(name.removeprefix("scene_")) for name in names if re.fullmatch(r"scene_\d{6,}", name)}


@contextlib.contextmanager
def _alone(out: Path):
    """Hold the folder: two processes that write to it would delete each other's unfinished scenes."""
    try:
        import fcntl
    except ImportError:  # not on Windows
        yield
        return
    handle = os.open(out, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise DatasetError(f"{out}: another process is writing to it; expected it alone") from error
        except OSError:
            pass  # a file system without locks
        yield
    finally:
        os.close(handle)


def _write_scene(out: Path, index: int, files: dict[str, bytes]) -> None:
    folder = out / scene_folder(index)
    partial = folder.with_name(folder.name + ".partial")
    partial.mkdir()
    try:
        for name, content in files.items():
            (partial / name).write_bytes(content)
    except OSError:  # the disk is full
        shutil.rmtree(partial, ignore_errors=True)
        raise
    partial.rename(folder)
