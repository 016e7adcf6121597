#!/usr/bin/env python3
"""Fig. 6 in numbers: does the best grasping point stay on the object's part when the segment gets worse?

Renders fresh scenes from the seed: --scenes of one object of each class, as many in which another object
nearly touches it, and --train-scenes of the split train. Trains shape contexts and local appearance on the
latter, and shows each the test objects at their true masks and at worse ones, in the left view. Prints
Markdown tables.
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
from fresh_scenes import SceneSet
from grasp_point_methods import (
    Method,
    add_training_options,
    print_head,
    rendered,
    shipped_methods,
    train_all,
    write_rows,
)
from grasp_point_pictures import response_tile, write_sheet
from grasp_point_views import ViewPatches, has_labelled_patch, labelled_views, patch_side_px, with_mask
from graspctx.sim.stored import read_scene, scene_folders
from stability_masks import DEGRADED, degraded_mask, mask_seed

PROGRAM = "stability.py"
CLASSES = ("mug", "pencil", "wineglass")
MASKS = ("true", *DEGRADED, "second")
NEIGHBOURS = ("can", "bottle", "box", "eraser")
LEAST_LABEL_LEFT = 0.5

DEFINITIONS = (
    f"""what is measured, for each method, mask and class, and over all classes:
  best_on_label  share of the objects whose best grasping point is a patch that overlaps the label
  peaks_return   of the grasping points (up to ten) at the true mask, the share that has one within a patch at
                 this mask; mean over the objects
  chance         of best_on_label: the mean share of patches that overlap the label

An object counts if a patch of its true mask is labelled, and at a mask if {LEAST_LABEL_LEFT:.0%} of the label
are in it.

masks:
  true      the object's own
"""
    + "".join(f"  {name:9} {text}\n" for name, text in DEGRADED.items())
    + """  second    that of the object and of another that nearly touches it, in other scenes

methods: shape_context, local_appearance_rbf and local_appearance_logistic, trained on the same images in this
run; shape_context_shipped, the installed model.
"""
)


# ---- One object --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Answer:
    """What a method makes of an object at a mask.

    Attributes:
        on_label: the best grasping point lies on a labelled patch.
        returned: share of the true mask's grasping points that are there again; None if there are none.
        chance: share of the patches that are labelled.
    """

    on_label: bool
    returned: float | None
    chance: float


def method_name(method: Method) -> str:
    """What a row of the benchmark calls a method."""
    if method.descriptor == "shape_context":
        return "shape_context" if method.trained_on == "run" else "shape_context_shipped"
    return f"{method.descriptor}_{method.classifier}"


def grasp_points(view: gc.LabelledView, method: Method) -> tuple[ViewPatches, list[gc.GraspPoint]]:
    """The patches of a view and its grasping points, the best first."""
    patches, probabilities = method.score(view)
    return patches, gc.find_grasp_points(patches.described.patches, probabilities)


def points_in_image(patches: ViewPatches, points: list[gc.GraspPoint]) -> np.ndarray:
    """Where grasping points lie in the full image: (P, 2) px."""
    centres = np.array([point.centre_px for point in points]).reshape(-1, 2)
    return patches.fovea.image_from_view(centres)


def returned_share(reference: np.ndarray, found: np.ndarray, reach_px: float) -> float | None:
    """Share of reference points, (P, 2), with a found one, (Q, 2), at most reach_px off in u and in v."""
    if not len(reference):
        return None
    if not len(found):
        return 0.0
    offsets = np.abs(reference[:, None] - found[None]).max(axis=2)
    return float((offsets.min(axis=1) <= reach_px).mean())


def answers(view: gc.LabelledView, masks: dict[str, np.ndarray], method: Method) -> dict[str, Answer]:
    """A method's answer at each mask; the true one is the view's own. Empty if no patch of that is labelled.

    Args:
        masks: (H, W) bool by name, without "true".
    """
    if not has_labelled_patch(view):
        return {}
    patches, points = grasp_points(view, method)
    reference = points_in_image(patches, points)
    reach_px = patch_side_px(patches.described.patches) / patches.fovea.scale
    found = {"true": _answer(patches, points, reference, reach_px)}
    for name, mask in masks.items():
        label = view.label > 0
        if (label & mask).sum() >= LEAST_LABEL_LEFT * label.sum():
            found[name] = _answer(*grasp_points(with_mask(view, mask), method), reference, reach_px)
    return found


def _answer(patches, points, reference, reach_px):
    labels = patches.described.labels
    return Answer(
        on_label=bool(points) and bool(labels[points[0].patch]),
        returned=returned_share(reference, points_in_image(patches, points), reach_px),
        chance=float(labels.mean()) if len(labels) else 0.0,
    )


def measure_scene(folder: Path, family: str, methods: list[Method]) -> list[tuple[str, str, Answer]]:
    """(method, mask, answer) of the scene's object of a family, alone or with another one in its segment."""
    found = []
    scene = read_scene(folder)
    for view in labelled_views(folder, family):
        if len(scene["objects"]) == 1:
            seed = mask_seed(scene)
            masks = {name: degraded_mask(view.mask > 0, name, seed) for name in DEGRADED}
        else:
            masks = {"second": gc.read_image(folder / "left_mask.png") > 0}
        for method in methods:
            for mask, answer in answers(view, masks, method).items():
                if mask != "true" or len(scene["objects"]) == 1:
                    found.append((method_name(method), mask, answer))
    return found


# ---- Pictures ----------------------------------------------------------------------------------------------


def figure_6(scenes: list[Path], family: str, methods: list[Method], objects: int = 3) -> list[list]:
    """The first labelled objects of a family: worse and worse masks downwards, the methods side by side."""
    shown = [
        (mask_seed(scene), view)
        for folder, scene in ((folder, read_scene(folder)) for folder in scenes)
        if len(scene["objects"]) == 1
        for view in labelled_views(folder, family)
        if has_labelled_patch(view)
    ][:objects]
    lines = []
    for name in ("true", "dilate8", "dilate16", "wedge", "cut20"):
        line = []
        for seed, view in shown:
            mask = view.mask > 0 if name == "true" else degraded_mask(view.mask > 0, name, seed)
            for method in methods:
                tile = response_tile(with_mask(view, mask), method, view.mask > 0)
                line.append((f"{name}, {method_name(method)}", tile))
        lines.append(line)
    return lines


# ---- Scenes and rows ---------------------------------------------------------------------------------------


def scene_sets(classes: tuple[str, ...], scenes: int) -> list[SceneSet]:
    """For each class a set of one object, and one of pairs, half of which hold the class exactly once."""
    sets = []
    for family in classes:
        others = [name for name in NEIGHBOURS if name != family]
        pairs = tuple(name for other in others for name in (family, other))
        sets.append(SceneSet(family, scenes, (family,)))
        sets.append(SceneSet(f"{family}_pairs", 2 * scenes, pairs, (2, 2), ("spacing=touching",)))
    return sets


def scenes_to_measure(alone: Path, pairs: Path, family: str) -> list[Path]:
    """All scenes of one object, and at most as many in which it stands beside one of another class."""
    singles = scene_folders(alone)
    mixed = [
        folder
        for folder in scene_folders(pairs)
        if [entry["family"] for entry in read_scene(folder)["objects"]].count(family) == 1
    ]
    return singles + mixed[: len(singles)]


def rows_of(found: dict[tuple[str, str, str], list[Answer]]) -> list[dict]:
    """The benchmark's rows from all answers by (class, method, mask); the class "all" holds every class's."""
    rows = []
    for (family, method, mask), of_all in found.items():
        keys = {"method": method, "mask": mask, "class": family}
        hits = sum(answer.on_label for answer in of_all)
        rows.append(report.row("best_on_label", report.share(hits, len(of_all)), **keys))
        returned = [answer.returned for answer in of_all if answer.returned is not None]
        if returned and mask != "true":
            rows.append(report.row("peaks_return", report.bootstrap(returned, np.mean), **keys))
        chance = float(np.mean([answer.chance for answer in of_all]))
        rows.append(report.row("chance", report.Estimate(chance, None, None, len(of_all)), **keys))
    return rows


def print_rows(rows: list[dict]) -> None:
    """For each class two tables, a line for each mask and a column for each method."""
    figures = {(row["measure"], row["class"], row["mask"], row["method"]): row for row in rows}
    methods = list(dict.fromkeys(row["method"] for row in rows))
    for family in dict.fromkeys(row["class"] for row in rows):
        for measure, title in (
            ("best_on_label", "best grasping point on the label"),
            ("peaks_return", "grasping points that return"),
        ):
            lines = []
            for mask in MASKS:
                of_mask = [figures.get((measure, family, mask, method)) for method in methods]
                counted = [figure["n"] for figure in of_mask if figure]
                if counted:
                    chance = figures["chance", family, mask, methods[0]]["value"]
                    shown = [report.number(chance)] if measure == "best_on_label" else []
                    lines.append([mask, max(counted), *shown, *map(report.figure, of_mask)])
            columns = ("mask", "objects", *(("chance",) if measure == "best_on_label" else ()), *methods)
            print(f"\n{family}: {title}\n\n" + report.table(columns, lines))


# ---- The command -------------------------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of each class to measure on")
    add_training_options(parser, classes=CLASSES)
    parser.add_argument(
        "--pictures",
        metavar="FOLDER",
        type=Path,
        help="also draw Fig. 6, CLASS.png: responses at worse and worse masks, local appearance beside ours",
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    with rendered(options, scene_sets(options.classes, options.scenes)) as (test, training):
        compared = [("shape_context", "rbf"), ("local_appearance", "rbf"), ("local_appearance", "logistic")]
        methods = train_all(training, compared, workers=options.workers)
        found = collections.defaultdict(list)
        for family, of_class in methods.items():
            scenes = scenes_to_measure(test[family], test[f"{family}_pairs"], family)
            measure = functools.partial(
                measure_scene, family=family, methods=of_class + shipped_methods(family)
            )
            if options.pictures:
                sheet = figure_6(scenes, family, [of_class[1], of_class[0]])
                write_sheet(options.pictures / f"{family}.png", sheet)
            progress = report.Progress(f"measure {family}", len(scenes))
            for of_scene in report.spread(measure, scenes, options.workers, progress):
                for method, mask, answer in of_scene:
                    found["all", method, mask].append(answer)
                    found[family, method, mask].append(answer)
    rows = rows_of(found)
    print_head("stability", options)
    print_rows(rows)
    write_rows("stability", options, rows)


if __name__ == "__main__":
    sys.exit(main())
