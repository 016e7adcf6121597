#!/usr/bin/env python3
"""What each choice of the descriptor is worth: variants of its options, trained and measured side by side.

Renders fresh scenes from the seed: --scenes of one object of each class, as many in which another object
nearly touches it, and --train-scenes of the split train. Trains the shape contexts of each variant on the
latter, and measures on the former in the left view. Choices are made on the split validation, which is the
default here. Prints Markdown tables.
"""

from __future__ import annotations

import argparse
import collections
import functools
import sys
from dataclasses import dataclass
from pathlib import Path

import graspctx as gc
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import report
from grasp_point_methods import (
    Method,
    add_training_options,
    print_head,
    rendered,
    scored_view,
    write_rows,
)
from grasp_point_score import ScoredView, estimates
from grasp_point_views import labelled_views
from graspctx.sim.stored import read_scene, scene_folders
from patch_classifiers import train_rbf
from stability import CLASSES, answers, scene_sets, scenes_to_measure
from stability_masks import degraded_mask, mask_seed

PROGRAM = "recipe.py"
DEGRADED = ("dilate8", "dilate16", "wedge", "cut20")
MASKS = ("true", *DEGRADED, "second")
MEASURES = ("ap", "ap_border_ignored", "auc", "top1")

# By name: options of describe_view, where they differ from the defaults.
VARIANTS = {
    "default": {},
    "4x5": {"angular_bins": 4},
    "12x5": {"angular_bins": 12},
    "windows 1/5/11": {"windows_patches": (1, 5, 11)},
    "relative to gradient": {"relative_to_gradient": True},
    "1000 samples": {"samples": 1000},
    "canny 60/180": {"canny_low": 60, "canny_high": 180},
    "outline": {"outline_px": 3},
    "refined": {"refine_mask": True},
    "robust": gc.robust_descriptor(),
    "outline, 12x5": {"outline_px": 3, "angular_bins": 12},
}

DEFINITIONS = f"""what is measured, for each class and variant:
  ap, ap_border_ignored, auc, top1, prior, chance
                 at the true mask, as in grasp_points.py
  best_on_label  share of the objects whose best grasping point is a patch that overlaps the label, at each of
                 the masks {", ".join(MASKS)}, as in stability.py

variants: {", ".join(VARIANTS)}.
"""


# ---- Training and measuring --------------------------------------------------------------------------------


def train(folder: Path, family: str, variant: str, workers: int) -> Method:
    """A model of one variant, trained on a data set's objects of a family with true and with worse masks."""
    options = VARIANTS[variant]
    scenes = list(enumerate(scene_folders(folder)))
    describe = functools.partial(_scene_rows, family=family, options=options)
    progress = report.Progress(f"describe {family}, {variant}", len(scenes))
    parts = [rows for rows in report.spread(describe, scenes, workers, progress) if rows is not None]
    if not parts:
        raise report.BadInputError(f"{folder}: no {family} in it; expected some to train on")
    features, labels, groups = (np.concatenate(columns) for columns in zip(*parts))
    model = train_rbf(features, labels, groups, options)
    return Method("shape_context", "rbf", "run", model, options)


def _scene_rows(numbered, family, options):
    group, folder = numbered
    views = labelled_views(folder, family, group, ("left", "right"))
    if not views:
        return None
    rows = gc.build_training_set(views, seed=group + 1, **options)
    return rows.features, rows.labels, rows.groups


@dataclass(frozen=True)
class Measured:
    """What a variant makes of one object.

    Attributes:
        scored: its patches at the true mask; None of an object that stands beside another.
        on_label: by mask, whether the best grasping point is on the label.
    """

    scored: ScoredView | None
    on_label: dict[str, bool]


def measure_scene(folder: Path, family: str, methods: dict[str, Method]) -> list[tuple[str, Measured]]:
    """(variant, measured) of a scene's objects of a family."""
    scene = read_scene(folder)
    alone = len(scene["objects"]) == 1
    found = []
    for view in labelled_views(folder, family):
        if alone:
            seed = mask_seed(scene)
            masks = {name: degraded_mask(view.mask > 0, name, seed) for name in DEGRADED}
        else:
            masks = {"second": gc.read_image(folder / "left_mask.png") > 0}
        for variant, method in methods.items():
            answered = answers(view, masks, method)
            on_label = {mask: answer.on_label for mask, answer in answered.items() if alone or mask != "true"}
            found.append((variant, Measured(scored_view(method, view) if alone else None, on_label)))
    return found


def rows_of(family: str, variant: str, measured: list[Measured]) -> list[dict]:
    """The benchmark's rows of one variant on one class."""
    keys = {"class": family, "variant": variant}
    figures = estimates([one.scored for one in measured if one.scored is not None])
    rows = [report.row(measure, figure, **keys, mask="true") for measure, figure in figures.items()]
    for mask in MASKS:
        hits = [one.on_label[mask] for one in measured if mask in one.on_label]
        if hits:
            rows.append(report.row("best_on_label", report.share(sum(hits), len(hits)), **keys, mask=mask))
    return rows


def print_rows(rows: list[dict]) -> None:
    """For each class a table, a line for each variant."""
    figures = {(row["class"], row["variant"], row["measure"], row["mask"]): row for row in rows}
    columns = ("variant", "AP", "AP border ignored", "ROC AUC", "top-1", *MASKS)
    for family in dict.fromkeys(row["class"] for row in rows):
        lines = []
        for variant in dict.fromkeys(row["variant"] for row in rows if row["class"] == family):
            cells = [figures.get((family, variant, measure, "true")) for measure in MEASURES]
            cells += [figures.get((family, variant, "best_on_label", mask)) for mask in MASKS]
            lines.append([variant, *map(report.figure, cells)])
        first = next(row for row in rows if row["class"] == family and row["measure"] == "prior")
        title = (
            f"{family}: {first['n']} objects, prior {report.number(first['value'])}; best on label by mask"
        )
        print(f"\n{title}\n\n" + report.table(columns, lines))


# ---- The command -------------------------------------------------------------------------------------------


def variant_names(text: str) -> tuple[str, ...]:
    """A type for argparse: names of variants, separated by semicolons."""
    names = tuple(text.split(";"))
    unknown = [name for name in names if name not in VARIANTS]
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown variant '{unknown[0]}'; known: {'; '.join(VARIANTS)}")
    return names


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=50, scenes_help="scenes of each class to measure on")
    add_training_options(parser, train_scenes=60, classes=CLASSES)
    parser.add_argument(
        "--variants",
        metavar="A;B",
        type=variant_names,
        default=tuple(VARIANTS),
        help="variants to compare (default: all)",
    )
    parser.set_defaults(split="validation")
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    with rendered(options, scene_sets(options.classes, options.scenes)) as (test, training):
        rows = []
        for family in options.classes:
            methods = {
                variant: train(training[family], family, variant, options.workers)
                for variant in options.variants
            }
            scenes = scenes_to_measure(test[family], test[f"{family}_pairs"], family)
            measure = functools.partial(measure_scene, family=family, methods=methods)
            progress = report.Progress(f"measure {family}", len(scenes))
            measured = collections.defaultdict(list)
            for of_scene in report.spread(measure, scenes, options.workers, progress):
                for variant, one in of_scene:
                    measured[variant].append(one)
            rows += [row for variant in methods for row in rows_of(family, variant, measured[variant])]
    print_head("recipe", options)
    print_rows(rows)
    write_rows("recipe", options, rows)


if __name__ == "__main__":
    sys.exit(main())
