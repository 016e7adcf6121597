#!/usr/bin/env python3
"""Grasp points on shapes that no model is trained on, such as a teapot by models of mugs and pencils.

Renders fresh scenes of one object from the seed: --scenes of each new shape, of the split test, and
--train-scenes of each class that is trained on, of the split train. Prints a Markdown table.
"""

from __future__ import annotations

import argparse
import collections
import dataclasses
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
from grasp_point_pictures import response_tile, write_sheet
from grasp_point_score import ScoredView, estimates
from grasp_point_views import TrainingRows, has_labelled_patch, labelled_views, training_rows
from graspctx.sim.stored import scene_folders

PROGRAM = "new_shapes.py"
TRAINED_ON = {
    "teapot": ("mug", "pencil"),
    "can": ("mug", "cup"),
    "cup": ("mug", "can"),
    "bottle": ("wineglass", "can"),
    "fryingpan": ("mug", "pencil"),
    "hammer": ("pencil", "wineglass"),
    "screwdriver": ("pencil", "eraser"),
    "spoon": ("pencil", "wineglass"),
}
DESCRIPTORS = ("shape_context", "local_appearance")

DEFINITIONS = """what is measured, for each shape, at its true mask in the left view:
  top1    share of the views whose most probable patch is labelled, of those with a labelled patch
  chance  of top1: the mean share of labelled patches
  ap      average precision over all patches; prior, their labelled share, is its chance level

trained_on: the classes, as in mug+pencil. models: joint, one that is trained on the images of all; best, one
of each, and a patch is as probable as the one that likes it best says. All with an RBF.
"""


def with_best_scores(of_models: Sequence[Sequence[ScoredView]]) -> list[ScoredView]:
    """Views as the model that likes a patch best scores it.

    Args:
        of_models: for each model the same views, with the same patches.
    """
    return [
        dataclasses.replace(views[0], scores=np.max([view.scores for view in views], axis=0))
        for views in zip(*of_models)
    ]


def score_shape(
    dataset: Path, shape: str, methods: dict[str, list[Method]], workers: int
) -> dict[tuple[str, str], list[ScoredView]]:
    """By (descriptor, models) the views of a shape.

    Args:
        methods: by descriptor the joint model, then that of each class.
    """
    flat = [method for of_descriptor in methods.values() for method in of_descriptor]
    scored = iter(scored_dataset(dataset, shape, flat, workers))
    found = {}
    for descriptor, of_descriptor in methods.items():
        joint, *single = [next(scored) for _ in of_descriptor]
        found[descriptor, "joint"] = joint
        found[descriptor, "best"] = with_best_scores(single)
    return found


def train_shape(
    classes: Sequence[str], rows: dict[str, TrainingRows], trained: dict[tuple, Method]
) -> dict[str, list[Method]]:
    """By descriptor the joint model of some classes, then that of each.

    Args:
        rows: by class.
        trained: what is trained already, by descriptor and classes; what is trained here is added.
    """
    methods = collections.defaultdict(list)
    for descriptor in DESCRIPTORS:
        for names in (tuple(classes), *((name,) for name in classes)):
            if (descriptor, names) not in trained:
                together = functools.reduce(TrainingRows.and_also, [rows[name] for name in names])
                trained[descriptor, names] = train_method(descriptor, "rbf", together)
            methods[descriptor].append(trained[descriptor, names])
    return dict(methods)


def rows_of(shape: str, scored: dict[tuple[str, str], list[ScoredView]]) -> list[dict]:
    """The rows of a shape, from its views by (descriptor, models)."""
    rows = []
    for (descriptor, models), views in scored.items():
        keys = {"trained_on": "+".join(TRAINED_ON[shape]), "tested_on": shape}
        keys.update(descriptor=descriptor, models=models)
        figures = estimates(views)
        measures = [measure for measure in ("top1", "chance", "ap", "prior") if measure in figures]
        rows += [report.row(measure, figures[measure], **keys) for measure in measures]
    return rows


def sheet_of(dataset: Path, shape: str, methods: dict[str, list[Method]], objects: int = 6) -> list[list]:
    """The first labelled objects of a shape, a column each; a line for the joint model of each descriptor."""
    views = [view for scene in scene_folders(dataset) for view in labelled_views(scene, shape)]
    shown = [view for view in views if has_labelled_patch(view)][:objects]
    names = "+".join(TRAINED_ON[shape])
    return [
        [(f"{names}: {descriptor}", response_tile(view, of_descriptor[0])) for view in shown]
        for descriptor, of_descriptor in reversed(methods.items())
    ]


def print_rows(rows: list[dict]) -> None:
    """A line for each shape, descriptor and kind of model."""
    lines = collections.defaultdict(dict)
    for row in rows:
        keys = tuple(row[key] for key in ("tested_on", "trained_on", "descriptor", "models"))
        lines[keys][row["measure"]] = row
    names = ("shape", "trained on", "descriptor", "models", "views", "top-1", "chance", "AP", "prior")
    cells = []
    for keys, figures in lines.items():
        shown = [
            report.figure(figures.get("top1")),
            report.figure(figures.get("chance")),
            report.figure(figures.get("ap"), 3),
            report.number(figures["prior"]["value"]) if "prior" in figures else "-",
        ]
        cells.append([*keys, figures.get("top1", {"n": 0})["n"], *shown])
    print("\n" + report.table(names, cells, left=4))


# ---- The command -------------------------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of each new shape to measure on")
    add_training_options(parser, classes=tuple(TRAINED_ON))
    parser.add_argument(
        "--pictures",
        metavar="FOLDER",
        type=Path,
        help="also draw SHAPE.png: responses of the joint models, local appearance above ours (Fig. 6)",
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    unknown = [shape for shape in options.classes if shape not in TRAINED_ON]
    if unknown:
        raise report.BadInputError(f"{unknown[0]}: no new shape; expected some of {', '.join(TRAINED_ON)}")
    shapes = options.classes
    options.classes = tuple(dict.fromkeys(name for shape in shapes for name in TRAINED_ON[shape]))
    rows = []
    sets = [SceneSet(shape, options.scenes, (shape,)) for shape in shapes]
    with rendered(options, sets) as (test, training):
        of_class = {name: training_rows(training[name], name, workers=options.workers) for name in training}
        trained = {}
        for shape in shapes:
            methods = train_shape(TRAINED_ON[shape], of_class, trained)
            if options.pictures:
                write_sheet(options.pictures / f"{shape}.png", sheet_of(test[shape], shape, methods))
            rows += rows_of(shape, score_shape(test[shape], shape, methods, options.workers))
    print_head("new_shapes", options, "shape")
    print_rows(rows)
    write_rows("new_shapes", options, rows, "shape")


if __name__ == "__main__":
    sys.exit(main())
