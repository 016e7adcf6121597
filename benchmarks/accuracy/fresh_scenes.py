"""Test scenes of a benchmark, rendered from its seed: sets in a folder, by several processes."""

from __future__ import annotations

import functools
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import report


@dataclass(frozen=True)
class SceneSet:
    """A set to render: its name is its folder's, the rest are arguments of graspctx.sim's make_dataset."""

    name: str
    scenes: int
    families: tuple[str, ...]
    objects: tuple[int, int] = (1, 1)
    axes: tuple[str, ...] = ()


def render_sets(
    folder: Path,
    sets: list[SceneSet],
    seed: int,
    *,
    split: str = "test",
    image_size: tuple[int, int] = (640, 480),
    workers: int = 1,
) -> list[Path]:
    """Render sets into folders of `folder`; sets that stand there already are kept.

    Each has a seed of its own, drawn from `seed` and its place in the list.

    Returns:
        The sets' folders.
    """
    work = [
        (folder / scenes.name, scenes, int(np.random.SeedSequence([seed, number]).generate_state(1)[0]))
        for number, scenes in enumerate(sets)
        if scenes.scenes > 0
    ]
    folder.mkdir(parents=True, exist_ok=True)
    render = functools.partial(_render, split=split, image_size=image_size)
    return list(report.spread(render, work, workers, report.Progress("render sets", len(work))))


def _render(work: tuple[Path, SceneSet, int], split: str, image_size: tuple[int, int]) -> Path:
    from graspctx.sim.dataset import make_dataset
    from graspctx.sim.stored import DatasetError

    folder, scenes, seed = work
    try:
        make_dataset(
            folder,
            scenes.scenes,
            seed,
            families=list(scenes.families),
            objects=scenes.objects,
            image_size=image_size,
            split=split,
            axes=scenes.axes,
        )
    except DatasetError as error:
        raise report.BadInputError(str(error)) from error
    return folder
