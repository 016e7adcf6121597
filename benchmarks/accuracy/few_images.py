#!/usr/bin/env python3
"""How many labelled images a model of grasp points needs.

Renders fresh scenes of one object from the seed: --scenes of each class, of the split test, and
--train-scenes, of the split train. Trains shape contexts with an RBF on few left views of the latter, drawn
several times, and on both views of all; and measures each model on the former in the left view, at the true
mask. Prints a Markdown table.
"""

from __future__ import annotations

import argparse
import functools
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import report
from fresh_scenes import SceneSet
from grasp_point_methods import (
    Method,
    add_training_options,
    print_head,
    rendered,
    scored_dataset,
    train_method,
    write_rows,
)
from grasp_point_score import Ranking, ScoredView, resampled
from grasp_point_views import TrainingRows, training_rows

PROGRAM = "few_images.py"
CLASSES = ("mug", "pencil", "wineglass")
IMAGES = (5, 10, 20, 50, 100)

DEFINITIONS = """what is measured, for each class and number of images, over the patches:
  ap             average precision on the test set, mean over the draws of images; by chance the prior
  share_of_full  of the ap of the model that is trained on both views of all training scenes, images = "full"
  prior          share of the patches that are labelled
"""


def draw_scenes(scenes: np.ndarray, images: int, draws: int, seed: int) -> list[np.ndarray]:
    """Numbers of the scenes to train on, `images` of them in each draw; one draw if that is all there are."""
    if images >= len(scenes):
        return [scenes]
    rng = np.random.default_rng([seed, images])
    return [np.sort(rng.choice(scenes, images, replace=False)) for _ in range(draws)]


def train_few(rows: TrainingRows, images: Sequence[int], draws: int, seed: int) -> dict[int, list[Method]]:
    """Models by the number of images that each is trained on, as far as there are as many."""
    scenes = np.unique(rows.groups)
    progress = report.Progress("train on few images", len(images))
    models = {}
    for done, count in enumerate(images, 1):
        if count <= len(scenes):
            models[count] = [
                train_method("shape_context", "rbf", rows.of_scenes(chosen))
                for chosen in draw_scenes(scenes, count, draws, seed)
            ]
        progress.show(done)
    return models


def rows_of(family: str, scored: dict[int | str, list[list[ScoredView]]]) -> list[dict]:
    """The rows of a class.

    Args:
        scored: by number of images, or "full", the views as each draw's model scores them.
    """
    rankings = {images: [Ranking(views) for views in draws] for images, draws in scored.items()}
    count = len(scored["full"][0])

    def precision(images, weights):
        return float(np.mean([ranking.average_precision(weights) for ranking in rankings[images]]))

    def share_of_full(images, weights):
        return precision(images, weights) / precision("full", weights)

    rows = []
    for images in scored:
        keys = {"class": family, "images": images}
        rows.append(report.row("ap", resampled(count, functools.partial(precision, images)), **keys))
        if images != "full":
            share = resampled(count, functools.partial(share_of_full, images))
            rows.append(report.row("share_of_full", share, **keys))
    prior = resampled(count, rankings["full"][0].prior)
    return [*rows, report.row("prior", prior, **{"class": family, "images": "full"})]


def print_rows(rows: list[dict]) -> None:
    """A line for each class and number of images."""
    figures = {(row["measure"], row["class"], row["images"]): row for row in rows}
    lines = []
    for measure, family, images in figures:
        if measure == "ap":
            lines.append(
                [
                    family,
                    images,
                    figures[measure, family, images]["n"],
                    report.figure(figures[measure, family, images], 3),
                    report.number(figures["prior", family, "full"]["value"]),
                    report.figure(figures.get(("share_of_full", family, images))),
                ]
            )
    print("\n" + report.table(("class", "images", "test views", "AP", "prior", "share of full"), lines))


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of each class to measure on")
    add_training_options(parser, train_scenes=200, classes=CLASSES)
    parser.add_argument(
        "--draws",
        metavar="N",
        type=report.at_least(1),
        default=3,
        help="draws of few images (default: %(default)s)",
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    rows = []
    sets = [SceneSet(family, options.scenes, (family,)) for family in options.classes]
    with rendered(options, sets) as (test, training):
        for family in options.classes:
            rows += rows_of(family, _class_scores(options, family, training[family], test[family]))
    print_head("few_images", options)
    print_rows(rows)
    write_rows("few_images", options, rows)


def _class_scores(options, family, training, test):
    """By number of images, or "full", the test views as each draw's model scores them."""
    arguments = {"descriptors": ("shape_context",), "workers": options.workers}
    left = training_rows(training, family, sides=("left",), **arguments)
    models = train_few(left, IMAGES, options.draws, options.seed)
    full = training_rows(training, family, **arguments)
    models["full"] = [train_method("shape_context", "rbf", full)]
    flat = [method for of_count in models.values() for method in of_count]
    by_method = iter(scored_dataset(test, family, flat, options.workers))
    return {images: [next(by_method) for _ in of_count] for images, of_count in models.items()}


if __name__ == "__main__":
    sys.exit(main())
