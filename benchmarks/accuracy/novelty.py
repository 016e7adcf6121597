#!/usr/bin/env python3
"""Familiar and unfamiliar shapes: does the familiarity drop, and which of several models answers.

Renders fresh scenes of one object from the seed: --scenes of each class and of each unfamiliar family, and
--train-scenes of each class, of the split train. Trains one model for each class and one for all of them, and
measures on the former at true masks in the left view. Choices are made on the split validation. Prints
Markdown tables.
"""

from __future__ import annotations

import argparse
import functools
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import graspctx as gc
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import report
from fresh_scenes import SceneSet
from grasp_point_methods import (
    add_training_options,
    class_names,
    print_head,
    refuse_leaks,
    rendered,
    write_rows,
)
from grasp_point_score import Ranking, ScoredView, over_views
from grasp_point_views import labelled_views
from graspctx.sim.stored import read_scene, scene_folders

PROGRAM = "novelty.py"
CLASSES = ("mug", "wineglass", "pencil", "bowl")
UNFAMILIAR = ("can", "bottle", "teapot", "hammer", "spoon", "fryingpan")
DESCRIPTOR = {"outline_px": 3}
TRAINING = {"max_rows": 4000, "max_search_rows": 1500}  # minutes, not an hour: all models alike
ANSWERS = ("vote", "own", "joint")

DEFINITIONS = f"""what is measured:
  auc             area under the ROC curve of the familiarity to a class's model: the class's own objects
                  against those of another class or family, and against all others together
  refused         share of the objects of a family that a class's model is not familiar with, at the default
                  threshold; of its own class those are mistakes
  refused_by_all  of each family: no model is familiar with the object, and the vote refuses it
  answered_right  of each class: share of the objects that the vote gives to the model of their class
  top1            share of the objects with a labelled patch whose most probable patch is labelled, by the
                  model that the vote chooses (vote; a refusal is a miss), by that of the class (own), and by
                  one that is trained on the images of all classes (joint); by chance: the mean share of
                  labelled patches

unfamiliar families by default: {", ".join(UNFAMILIAR)}. Descriptor: shape contexts, outline_px 3. Trained on
at most {TRAINING["max_rows"]} patches each, views for the familiarity aside.
"""


def scenes_with(folders: Iterable[Path], family: str) -> list[Path]:
    """The scenes of some data sets that hold an object of a family."""
    return [
        scene
        for folder in folders
        for scene in scene_folders(folder)
        if any(entry["family"] == family for entry in read_scene(scene)["objects"])
    ]


# ---- Training ----------------------------------------------------------------------------------------------


def describe_training(folder: Path, family: str, first_scene: int, workers: int) -> list[np.ndarray]:
    """Features, labels, groups and views of a data set's objects of a family, with true and worse masks.

    Args:
        first_scene: what its scenes are numbered from, so that no two classes share a number.
    """
    scenes = list(enumerate(scenes_with([folder], family), first_scene))
    describe = functools.partial(_scene_rows, family=family)
    progress = report.Progress(f"describe {family}", len(scenes))
    parts = [rows for rows in report.spread(describe, scenes, workers, progress) if rows is not None]
    if len(parts) < 2:
        raise report.BadInputError(f"{folder}: {len(parts)} scenes show a {family}; expected two or more")
    columns = [list(column) for column in zip(*parts)]
    first_view = np.cumsum([0] + [of_scene.max() + 1 for of_scene in columns[3]])
    columns[3] = [of_scene + first for of_scene, first in zip(columns[3], first_view)]
    return [np.concatenate(column) for column in columns]


def _scene_rows(numbered, family):
    group, folder = numbered
    views = labelled_views(folder, family, group, ("left", "right"))
    if not views:
        return None
    rows = gc.build_training_set(views, seed=group + 1, **DESCRIPTOR)
    return (rows.features, rows.labels, rows.groups, rows.views) if len(rows.labels) else None


def train(name: str, classes: Sequence[str], rows: Sequence[np.ndarray]) -> gc.GraspModel:
    """A model that knows what is familiar, from features, labels, groups and views."""
    features, labels, groups, views = rows
    return gc.train_model(
        features, labels, groups, name=name, classes=classes, descriptor=DESCRIPTOR, views=views, **TRAINING
    )


def train_models(folders: dict[str, Path], workers: int) -> dict[str, gc.GraspModel]:
    """A model of each class, and "joint" of all."""
    described = {}
    for number, (family, folder) in enumerate(folders.items()):
        described[family] = describe_training(folder, family, 1_000_000 * number, workers)
    work = [(family, (family,), rows) for family, rows in described.items()]
    together = [np.concatenate(column) for column in zip(*described.values())]
    first_view, views = 0, []
    for rows in described.values():
        views.append(rows[3] + first_view)
        first_view += int(rows[3].max()) + 1
    together[3] = np.concatenate(views)
    work.append(("joint", tuple(folders), together))
    progress = report.Progress("train", len(work))
    return dict(zip((*folders, "joint"), report.spread(_train_one, work, workers, progress)))


def _train_one(work):
    return train(*work)


# ---- Measuring ---------------------------------------------------------------------------------------------


class Answer(NamedTuple):
    """What one model says of an object."""

    familiarity: float
    familiar: bool


@dataclass(frozen=True)
class SeenObject:
    """What the models make of one object.

    Attributes:
        alone: by class, what its model alone says.
        chosen: the class whose model the vote chooses, None if it refuses the object.
        hit: by ANSWERS, whether the most probable patch is labelled; None of an object without a label, or
            of a family that no model is of.
        chance: share of labelled patches.
    """

    alone: dict[str, Answer]
    chosen: str | None
    hit: dict[str, bool] | None
    chance: float


def see_scene(folder: Path, family: str, models: dict[str, gc.GraspModel]) -> list[SeenObject]:
    """A scene's objects of a family."""
    classes = [name for name in models if name != "joint"]
    seen = []
    for view in labelled_views(folder, family):
        described = gc.describe_labelled_view(view, **DESCRIPTOR)
        features = described.patches.features
        if not len(features):
            continue
        choice = gc.choose_model([models[name] for name in classes], [features] * len(classes))
        chosen = classes[choice.model] if choice.familiar else None
        hit = None
        if family in classes and described.labels.any():
            answers = dict(zip(ANSWERS, (chosen, family, "joint")))
            hit = {answer: _best_is_labelled(models.get(name), described) for answer, name in answers.items()}
        alone = {name: _answer(gc.choose_model(models[name], [features])) for name in classes}
        seen.append(SeenObject(alone, chosen, hit, float(np.mean(described.labels))))
    return seen


def _answer(choice):
    return Answer(choice.familiarity, choice.familiar)


def _best_is_labelled(model, described):
    if model is None:
        return False
    return bool(described.labels[np.argmax(model.predict_probability(described.patches.features))])


def familiarity_auc(familiar: Sequence[float], unfamiliar: Sequence[float]) -> report.Estimate:
    """Area under the ROC curve, and its interval over resampled objects."""
    labelled = [(value, 1) for value in familiar] + [(value, 0) for value in unfamiliar]
    views = [
        ScoredView(np.array([value]), np.array([label]), np.array([float(label)]), 1.0, bool(label))
        for value, label in labelled
    ]
    return over_views(views, Ranking.roc_area)


def rows_of(seen: dict[str, list[SeenObject]], classes: Sequence[str]) -> list[dict]:
    """The benchmark's rows, from the objects of each family."""
    rows = []
    for model in classes:
        alone = {name: [item.alone[model] for item in items] for name, items in seen.items() if items}
        values = {name: [answer.familiarity for answer in answers] for name, answers in alone.items()}
        others = [name for name in values if name != model]
        pairs = {name: values[name] for name in others}
        pairs["all others"] = [value for name in others for value in values[name]]
        for name, unfamiliar in pairs.items():
            if unfamiliar and model in values:
                auc = familiarity_auc(values[model], unfamiliar)
                rows.append(report.row("auc", auc, model=model, **{"class": name}))
        for name, answers in alone.items():
            refused = report.share(sum(not answer.familiar for answer in answers), len(answers))
            rows.append(report.row("refused", refused, model=model, **{"class": name}))
    for name, items in seen.items():
        if items:
            refused = report.share(sum(item.chosen is None for item in items), len(items))
            rows.append(report.row("refused_by_all", refused, **{"class": name}))
    each = {name: seen[name] for name in classes}
    each["all"] = [item for name in classes for item in seen[name]]
    right = {name: [item.chosen == name for item in seen[name]] for name in classes}
    right["all"] = [answered for name in classes for answered in right[name]]
    for name, items in each.items():
        if items:
            answered = report.share(sum(right[name]), len(items))
            rows.append(report.row("answered_right", answered, **{"class": name}))
        labelled = [item for item in items if item.hit is not None]
        if labelled:
            for answer in ANSWERS:
                hits = report.share(sum(item.hit[answer] for item in labelled), len(labelled))
                rows.append(report.row("top1", hits, answer=answer, **{"class": name}))
            chance = report.Estimate(
                float(np.mean([item.chance for item in labelled])), None, None, len(labelled)
            )
            rows.append(report.row("chance", chance, **{"class": name}))
    return rows


# ---- The tables --------------------------------------------------------------------------------------------


def print_rows(rows: list[dict], classes: Sequence[str]) -> None:
    """Familiarity by model and family, and the vote by class."""
    found = {(row["measure"], row["class"], row.get("model") or row.get("answer")): row for row in rows}
    families = [*dict.fromkeys(row["class"] for row in rows if row["measure"] == "refused")]
    families += ["all others", "all"]
    for measure, title in (
        ("auc", "ROC AUC of the familiarity: the model's own class against"),
        ("refused", "Share refused by one model at the default threshold"),
    ):
        names = ["family", *(f"model {model}" for model in classes)]
        lines = [
            [family, *(report.figure(found.get((measure, family, model))) for model in classes)]
            for family in families
            if any((measure, family, model) in found for model in classes)
        ]
        if measure == "refused":
            names.append("refused by all")
            lines = [[*line, report.figure(found.get(("refused_by_all", line[0], None)))] for line in lines]
        print(f"\n{title}\n\n" + report.table(names, lines))
    names = ["class", "answered by its model", *(f"top-1 {answer}" for answer in ANSWERS), "chance"]
    lines = [
        [
            family,
            report.figure(found["answered_right", family, None]),
            *(report.figure(found.get(("top1", family, answer))) for answer in ANSWERS),
            report.figure(found.get(("chance", family, None))),
        ]
        for family in families
        if ("answered_right", family, None) in found
    ]
    print("\nThe vote\n\n" + report.table(names, lines))


# ---- The command -------------------------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of each class and family to measure on")
    add_training_options(parser, classes=CLASSES)
    parser.add_argument(
        "--unfamiliar",
        metavar="A,B",
        type=class_names,
        default=UNFAMILIAR,
        help=f"families that no model is of (default: {','.join(UNFAMILIAR)})",
    )
    parser.add_argument(
        "--data",
        metavar="FOLDER",
        type=Path,
        nargs="+",
        help="measure on these data sets of graspctx.sim, instead of fresh scenes",
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    families = tuple(dict.fromkeys((*options.classes, *options.unfamiliar)))
    sets = [] if options.data else [SceneSet(family, options.scenes, (family,)) for family in families]
    with rendered(options, sets) as (test, training):
        folders = options.data or list(test.values())
        if options.data:
            refuse_leaks(list(training.values()), folders)
        models = train_models(training, options.workers)
        seen = {}
        for family in families:
            see = functools.partial(see_scene, family=family, models=models)
            scenes = scenes_with(folders, family)
            progress = report.Progress(f"measure {family}", len(scenes))
            found = report.spread(see, scenes, options.workers, progress)
            seen[family] = [item for of_scene in found for item in of_scene]
    rows = rows_of(seen, options.classes)
    print_head("novelty", options)
    if options.data:
        print(f"measured instead on {', '.join(map(str, options.data))}")
    print_rows(rows, options.classes)
    write_rows("novelty", options, rows)


if __name__ == "__main__":
    sys.exit(main())
