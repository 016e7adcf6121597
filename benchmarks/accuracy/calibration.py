#!/usr/bin/env python3
"""Is the probability of a grasping point one? Its calibration on unseen instances and on new shapes.

Renders fresh scenes of one object from the seed: --scenes of each class and of each new shape, of the split
test, and --train-scenes, of the split train. Trains shape contexts with an RBF on the latter, and compares
P(g = 1 | D) with how often patches of the former are labelled. Prints Markdown tables, one of them the
reliability diagram.
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
    shipped_methods,
    train_method,
    write_rows,
)
from grasp_point_score import ScoredView, resampled
from grasp_point_views import training_rows

PROGRAM = "calibration.py"
BINS = 10
NEW_SHAPES = {"teapot": "mug", "cup": "bowl", "spoon": "pencil", "bottle": "wineglass"}

DEFINITIONS = f"""what is measured, for each class, over patches that hold contour:
  ece    expected calibration error: over {BINS} bins of P of equal width, how far the mean P of a bin is from
         the share of its patches that are labelled, weighted by patches
  prior  share of the patches that are labelled
  brier, brier_of_prior
         mean of (P - label)², and that of a classifier that always answers with the prior: an ece of 0 alone
         says little, that classifier has one, too

model: the class whose model was asked: the class itself, or for a new shape one that it resembles
({", ".join(f"{shape} by {model}" for shape, model in NEW_SHAPES.items())}).
trained_on: run, the images of this run; shipped, the model that is installed.
"""


class Reliability:
    """The patches of views by bins of P, to be counted with a weight for each view."""

    def __init__(self, views: Sequence[ScoredView]) -> None:
        self._bins = np.zeros((len(views), BINS, 3))  # patches, Σ P, labelled patches
        self._squares = np.zeros(len(views))
        for number, view in enumerate(views):
            which = np.minimum((view.scores * BINS).astype(int), BINS - 1)  # 1 belongs to the last bin
            for column, values in enumerate((np.ones(len(which)), view.scores, view.labels)):
                self._bins[number, :, column] = np.bincount(which, values, minlength=BINS)
            self._squares[number] = ((view.scores - view.labels) ** 2).sum()

    def bins(self, weights: np.ndarray) -> np.ndarray:
        """(10, 3): patches, sum of P and labelled patches of each bin, for weights (V,) of the views."""
        return np.tensordot(weights, self._bins, 1)

    def calibration_error(self, weights: np.ndarray) -> float:
        """As gc.expected_calibration_error."""
        patches, predicted, labelled = self.bins(weights).T
        return float(np.abs(predicted - labelled).sum() / patches.sum())

    def prior(self, weights: np.ndarray) -> float:
        """Share of the patches that are labelled."""
        patches, _, labelled = self.bins(weights).T
        return float(labelled.sum() / patches.sum())

    def brier(self, weights: np.ndarray) -> float:
        """Mean of (P - label)²."""
        return float(weights @ self._squares / self.bins(weights)[:, 0].sum())

    def brier_of_prior(self, weights: np.ndarray) -> float:
        """The same of a classifier that always answers with the prior."""
        prior = self.prior(weights)
        return prior * (1 - prior)


def rows_of(reliability: Reliability, views: int, **keys: str) -> list[dict]:
    """The rows of one model on one class."""
    measures = {
        "ece": reliability.calibration_error,
        "prior": reliability.prior,
        "brier": reliability.brier,
        "brier_of_prior": reliability.brier_of_prior,
    }
    return [report.row(name, resampled(views, statistic), **keys) for name, statistic in measures.items()]


def print_rows(rows: list[dict], diagrams: dict[tuple, np.ndarray]) -> None:
    """A table of the figures, and for each model a line of the reliability diagram.

    Args:
        diagrams: by (class, model, trained_on), (10, 3) patches, sum of P and labelled patches of each bin.
    """
    names = ("ece", "prior", "brier", "brier_of_prior")
    figures = {(row["class"], row["model"], row["trained_on"], row["measure"]): row for row in rows}
    lines = [
        [*keys, figures[(*keys, "ece")]["n"], *(report.figure(figures[(*keys, name)], 3) for name in names)]
        for keys in diagrams
    ]
    print(
        "\n"
        + report.table(("class", "model", "trained on", "views", "ECE", *names[1:3], "of prior"), lines, 3)
    )
    columns = [f"{low / BINS:.1f}" for low in range(BINS)]
    lines = [
        [
            *keys,
            *(
                f"{labelled / patches:.2f} ({patches:.0f})" if patches else "-"
                for patches, _, labelled in bins
            ),
        ]
        for keys, bins in diagrams.items()
    ]
    title = "Share of patches that are labelled, and number of patches, by P from"
    print(f"\n{title}\n\n" + report.table(("class", "model", "trained on", *columns), lines, 3))


# ---- The command -------------------------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of each class to measure on")
    add_training_options(parser)
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    asked = [(family, family) for family in options.classes]
    asked += [(shape, model) for shape, model in NEW_SHAPES.items() if model in options.classes]
    rows, diagrams = [], {}
    shapes = dict.fromkeys(shape for shape, _ in asked)
    sets = [SceneSet(shape, options.scenes, (shape,)) for shape in shapes]
    with rendered(options, sets) as (test, training):
        methods = {family: _methods(options, family, training[family]) for family in options.classes}
        for shape, model in asked:
            scored = scored_dataset(test[shape], shape, methods[model], options.workers)
            for method, views in zip(methods[model], scored):
                keys = {"class": shape, "model": model, "trained_on": method.trained_on}
                reliability = Reliability(views)
                rows += rows_of(reliability, len(views), **keys)
                diagrams[tuple(keys.values())] = reliability.bins(np.ones(len(views)))
    print_head("calibration", options)
    print_rows(rows, diagrams)
    write_rows("calibration", options, rows)


def _methods(options, family, training) -> list[Method]:
    rows = training_rows(training, family, descriptors=("shape_context",), workers=options.workers)
    return [*shipped_methods(family), train_method("shape_context", "rbf", rows)]


if __name__ == "__main__":
    sys.exit(main())
