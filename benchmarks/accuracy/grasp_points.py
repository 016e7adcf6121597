#!/usr/bin/env python3
"""Grasp points on unseen instances: shape contexts beside local appearance, trained on the same images.

Renders fresh scenes of one object from the seed: --scenes of each class, of the split test, and
--train-scenes, of the split train. Trains each descriptor with each classifier on the latter, and measures
on the former in the left view, at the true mask and at the segment that graspctx finds. Prints Markdown
tables.
"""

from __future__ import annotations

import argparse
import collections
import dataclasses
import functools
import itertools
import sys
from dataclasses import dataclass
from pathlib import Path

import graspctx as gc
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import report
from fresh_scenes import SceneSet
from grasp_point_methods import (
    Method,
    add_training_options,
    print_head,
    rendered,
    scored_view,
    shipped_methods,
    train_all,
    write_rows,
)
from grasp_point_pictures import response_tile, write_sheet
from grasp_point_score import LARGE_LABEL_SHARE, ScoredView, estimates
from grasp_point_views import best_segment, labelled_views, with_mask
from graspctx.sim.stored import scene_folders

PROGRAM = "grasp_points.py"
MASKS = ("true", "segmented")

DEFINITIONS = f"""what is measured, for each class, descriptor, classifier and mask, over the patches:
  ap                average precision over all patches of all views; a patch is positive if it overlaps the
                    labelled region. Its chance level is the prior.
  ap_border_ignored the same without the patches that are labelled by less than half
  auc               area under the ROC curve; 0.5 by chance
  prior, prior_border_ignored
                    share of the patches that are positive
  top1              share of the views whose most probable patch is positive, of those with a positive patch
  top1_large_label  of those of them where the label is over {LARGE_LABEL_SHARE:.0%} of the object
  chance, chance_large_label
                    of top1 and top1_large_label: the mean share of positive patches
  found             at the segmented mask: share of the objects that a segment fits with IoU > 0.5. The others
                    are failures of top1; they have no patches to count for ap and auc.
  label_covered     share of the label's pixels that the segments of found objects hold; mean over those. What
                    a segment has lost is lost for every method, and not counted against ap.

trained_on: run, the images of this run; shipped, the model that is installed under the class's name.
"""


# ---- One scene ---------------------------------------------------------------------------------------------


def score_view(view: gc.LabelledView, method: Method, mask: str, segments) -> ScoredView:
    """A method's patches of an object at its true mask, or at the segment that fits it best.

    Args:
        mask: one of MASKS.
        segments: (H, W) ids that graspctx found.
    """
    truth = scored_view(method, view)
    if mask == "true":
        return truth
    segment = best_segment(view, segments)
    if segment is None:
        nothing = slice(0)
        scores, labels, label_share = (
            values[nothing] for values in (truth.scores, truth.labels, truth.label_share)
        )
        return dataclasses.replace(truth, scores=scores, labels=labels, label_share=label_share)
    found = scored_view(method, with_mask(view, segment))
    return dataclasses.replace(
        found, visible_label_share=truth.visible_label_share, has_label=truth.has_label
    )


@dataclass(frozen=True)
class ScoredObject:
    """An object of a scene.

    Attributes:
        views: by number of the method and mask.
        label_covered: share of the label's pixels in the segment; None if it has no label or no segment.
    """

    views: dict[tuple[int, str], ScoredView]
    label_covered: float | None


def label_covered(view: gc.LabelledView, segments) -> float | None:
    """Share of an object's labelled pixels in the segment that fits it best; None without either."""
    segment, label = best_segment(view, segments), view.label > 0
    return None if segment is None or not label.any() else float(segment[label].mean())


def score_scene(folder: Path, family: str, methods: list[Method]) -> list[ScoredObject]:
    """The objects of a family in a scene."""
    left, right = (gc.read_image(folder / f"{side}.png") for side in ("left", "right"))
    segments = gc.segment_objects(left, right, gc.StereoCamera.load(folder / "calib.txt"))
    return [
        ScoredObject(
            {
                (number, mask): score_view(view, method, mask, segments)
                for number, method in enumerate(methods)
                for mask in MASKS
            },
            label_covered(view, segments),
        )
        for view in labelled_views(folder, family)
    ]


# ---- Rows --------------------------------------------------------------------------------------------------


def class_rows(
    dataset: Path, family: str, methods: list[Method], workers: int, progress: report.Progress | None = None
) -> list[dict]:
    """The rows of all methods on a class's test set."""
    score = functools.partial(score_scene, family=family, methods=methods)
    scenes = report.spread(score, scene_folders(dataset), workers, progress)
    objects = [scored for of_scene in scenes for scored in of_scene]
    covered = [scored.label_covered for scored in objects if scored.label_covered is not None]
    rows = []
    for number, mask in itertools.product(range(len(methods)), MASKS):
        views = [scored.views[number, mask] for scored in objects]
        figures = estimates(views)
        if mask == "segmented" and views:
            figures["found"] = report.share(sum(len(view.scores) > 0 for view in views), len(views))
            if covered:
                figures["label_covered"] = report.bootstrap(covered, np.mean)
        keys = {"class": family, **methods[number].keys, "mask": mask}
        rows += [report.row(measure, figure, **keys) for measure, figure in figures.items()]
    return rows


def worst_views(dataset: Path, family: str, method: Method, count: int = 20) -> list[list]:
    """The views that a method ranks worst at the true mask, by average precision, five a line."""
    found = []
    for scene in scene_folders(dataset):
        for view in labelled_views(scene, family):
            scored = scored_view(method, view)
            if scored.labels.any():
                precision = gc.average_precision(scored.scores, scored.labels)
                found.append((precision, scene.name, view))
    found = sorted(found, key=lambda item: item[:2])[:count]
    tiles = [(f"{name}: AP {precision:.2f}", response_tile(view, method)) for precision, name, view in found]
    return [tiles[first : first + 5] for first in range(0, len(tiles), 5)]


def print_rows(rows: list[dict]) -> None:
    """For each mask a table: a line for each class and method, chance and prior beside the figures."""
    lines = collections.defaultdict(dict)
    for line in rows:
        keys = (line["mask"], line["class"], line["descriptor"], line["classifier"], line["trained_on"])
        lines[keys][line["measure"]] = line
    names = ("class", "descriptor", "classifier", "trained on", "views", "AP", "prior")
    names += ("AP border ignored", "prior", "ROC AUC", "top-1", "chance", "top-1 label > 2 %", "chance")
    names += ("found", "label covered")
    measures = ("ap", "prior", "ap_border_ignored", "prior_border_ignored", "auc", "top1", "chance")
    measures += ("top1_large_label", "chance_large_label", "found", "label_covered")
    for mask in MASKS:
        cells = [
            [*keys[1:], figures.get("top1", {"n": 0})["n"], *(_cell(figures, name) for name in measures)]
            for keys, figures in lines.items()
            if keys[0] == mask
        ]
        if mask == "true":
            cells = [line[:-2] for line in cells]
        title = "At the true mask" if mask == "true" else "At the segment that graspctx finds"
        print(f"\n{title}\n\n" + report.table(names[: len(cells[0])] if cells else names, cells, left=4))


def _cell(figures, measure):
    found = figures.get(measure)
    if found is not None and measure.startswith(("prior", "chance")):
        return report.number(found["value"])  # what the figure beside it is to be compared with
    return report.figure(found, 3 if measure in ("ap", "ap_border_ignored", "auc") else 2)


# ---- The command -------------------------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of each class to measure on")
    add_training_options(parser)
    parser.add_argument(
        "--pictures",
        metavar="FOLDER",
        type=Path,
        help="also draw worst_CLASS.png: the 20 worst views of the shipped model, or of the one of this run",
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    sets = [SceneSet(family, options.scenes, (family,)) for family in options.classes]
    with rendered(options, sets) as (test, training):
        methods = train_all(training, workers=options.workers)
        rows = []
        for family, of_class in methods.items():
            of_class = shipped_methods(family) + of_class
            if options.pictures:
                sheet = worst_views(test[family], family, of_class[0])
                write_sheet(options.pictures / f"worst_{family}.png", sheet)
            progress = report.Progress(f"measure {family}", options.scenes)
            rows += class_rows(test[family], family, of_class, options.workers, progress)
    print_head("grasp_points", options)
    print_rows(rows)
    write_rows("grasp_points", options, rows)


if __name__ == "__main__":
    sys.exit(main())
