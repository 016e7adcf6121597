"""The methods that benchmarks of grasp points compare, trained in the same run on the same images.

Fresh scenes of the split train, of the benchmark's seed, one object each. Nothing is tested on their shapes
and textures, and that is checked.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import functools
import itertools
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import graspctx as gc
import numpy as np
import report
from datasets import TRAINED
from fresh_scenes import SceneSet, render_sets
from grasp_point_score import ScoredView
from grasp_point_views import (
    DESCRIPTORS,
    TrainingRows,
    ViewPatches,
    describe,
    has_labelled_patch,
    labelled_views,
    training_rows,
)
from graspctx.sim.families import FAMILIES
from graspctx.sim.splits import shared_seeds
from graspctx.sim.stored import DatasetError, read_scene, scene_folders
from patch_classifiers import Logistic, Rbf, train_logistic, train_rbf

CLASSES = tuple(TRAINED.split(","))
CLASSIFIERS = ("rbf", "logistic")
_TRAINING_SEED = 1  # beside the benchmark's seed, so that no training scene has the seed of a test scene


@dataclass(frozen=True)
class Method:
    """A trained scorer of patches.

    Attributes:
        descriptor, classifier: of DESCRIPTORS and CLASSIFIERS.
        trained_on: "run", the images of this run, or "shipped", a model as it is installed.
        model: what predicts.
        options: of describe_view, where they differ from its defaults. Without: robust_descriptor, for each
            descriptor: all methods see the same views.
    """

    descriptor: str
    classifier: str
    trained_on: str
    model: gc.GraspModel | Rbf | Logistic
    options: dict = field(default_factory=gc.robust_descriptor)

    @property
    def keys(self) -> dict[str, str]:
        """What a row of a benchmark says of it."""
        return {
            "descriptor": self.descriptor,
            "classifier": self.classifier,
            "trained_on": self.trained_on,
        }

    def score(self, view: gc.LabelledView) -> tuple[ViewPatches, np.ndarray]:
        """The patches of a view and P(g = 1 | D) of each, (M,) float64."""
        patches = describe(view, self.descriptor, self.options)
        return patches, self.model.predict_probability(patches.features)


def train_method(descriptor: str, classifier: str, rows: TrainingRows) -> Method:
    """Train a classifier on a descriptor's rows."""
    features = rows.features[descriptor]
    if classifier == "logistic":
        return Method(descriptor, classifier, "run", train_logistic(features, rows.labels, rows.groups))
    options = gc.robust_descriptor() if descriptor == "shape_context" else None
    model = train_rbf(features, rows.labels, rows.groups, options)
    if descriptor != "shape_context":
        model = Rbf.of(
            model
        )  # a GraspModel of another width than its descriptor's cannot be sent to a process
    return Method(descriptor, classifier, "run", model)


def shipped_methods(family: str) -> list[Method]:
    """The shipped model of a class, if there is one."""
    if family not in gc.shipped_models():
        return []
    model = gc.load_model(family)
    return [Method("shape_context", "rbf", "shipped", model, model.descriptor)]


# ---- What they make of a test set --------------------------------------------------------------------------


def scored_view(method: Method, view: gc.LabelledView) -> ScoredView:
    """A method's scores of an object at its own mask."""
    patches, scores = method.score(view)
    truth = patches.described
    return ScoredView(
        scores, truth.labels, truth.label_share, truth.visible_label_share, has_labelled_patch(view)
    )


def scored_dataset(
    dataset: Path, family: str, methods: Sequence[Method], workers: int = 1
) -> list[list[ScoredView]]:
    """For each method, in their order, its scores of a data set's objects of a family at their true masks."""
    scenes = scene_folders(dataset)
    score = functools.partial(_scored_scene, family=family, methods=list(methods))
    progress = report.Progress(f"measure {family}", len(scenes))
    views = [view for found in report.spread(score, scenes, workers, progress) for view in found]
    return [[of_view[number] for of_view in views] for number in range(len(methods))]


def _scored_scene(folder, family, methods):
    return [[scored_view(method, view) for method in methods] for view in labelled_views(folder, family)]


# ---- Options, scenes, training -----------------------------------------------------------------------------


def class_names(text: str) -> tuple[str, ...]:
    """A type for argparse: names of object families, as in mug,pencil."""
    names = tuple(text.split(","))
    unknown = [name for name in names if name not in FAMILIES]
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown class '{unknown[0]}'; known: {', '.join(FAMILIES)}")
    return names


def add_training_options(
    parser: argparse.ArgumentParser, *, train_scenes: int = 100, classes: Sequence[str] = CLASSES
) -> None:
    """Add --train-scenes, --train-data, --classes, --split and --keep."""
    parser.add_argument(
        "--train-scenes",
        metavar="N",
        type=report.at_least(10),
        default=train_scenes,
        help="scenes of each class to train on, of two views each (default: %(default)s)",
    )
    parser.add_argument(
        "--train-data",
        metavar="FOLDER",
        type=Path,
        help="train on this data set instead; it may share no shape and no texture with the test",
    )
    parser.add_argument(
        "--classes",
        metavar="A,B",
        type=class_names,
        default=tuple(classes),
        help=f"classes to measure (default: {','.join(classes)})",
    )
    parser.add_argument(
        "--split",
        choices=("validation", "test"),
        default="test",
        help="of the scenes that are measured on (default: %(default)s; for choices: validation)",
    )
    parser.add_argument(
        "--keep", metavar="FOLDER", type=Path, help="render into this folder, and leave it there"
    )


def render_test_sets(options: argparse.Namespace, folder: Path, sets: Sequence[SceneSet]) -> dict[str, Path]:
    """Render sets that are measured on, of the seed and split that the options say: folders by name."""
    folders = render_sets(
        folder / "test", list(sets), options.seed, split=options.split, workers=options.workers
    )
    return {scenes.name: place for scenes, place in zip(sets, folders)}


def training_folders(options: argparse.Namespace, folder: Path) -> dict[str, Path]:
    """The data set to train each class on: the folder that --train-data names, or a fresh one."""
    if options.train_data is not None:
        return dict.fromkeys(options.classes, options.train_data)
    sets = [SceneSet(family, options.train_scenes, (family,)) for family in options.classes]
    seed = int(np.random.SeedSequence([options.seed, _TRAINING_SEED]).generate_state(1)[0])
    folders = render_sets(folder / "train", sets, seed, split="train", workers=options.workers)
    return dict(zip(options.classes, folders))


def refuse_leaks(training: Sequence[Path], test: Sequence[Path]) -> None:
    """BadInputError if sets that are trained on share a shape or a texture with sets that are measured on."""
    try:
        scenes = [
            [read_scene(scene) for folder in dict.fromkeys(folders) for scene in scene_folders(folder)]
            for folders in (training, test)
        ]
    except DatasetError as error:
        raise report.BadInputError(str(error)) from error
    shared = {name: len(seeds) for name, seeds in shared_seeds(*scenes).items() if seeds}
    if shared:
        what = " and ".join(f"{count} {name}" for name, count in shared.items())
        raise report.BadInputError(f"{training[0]}: shares {what} with the test; expected none")


def train_all(
    folders: dict[str, Path],
    compared: Sequence[tuple[str, str]] = tuple(itertools.product(DESCRIPTORS, CLASSIFIERS)),
    *,
    workers: int = 1,
) -> dict[str, list[Method]]:
    """Train pairs of descriptor and classifier on each class's data set: methods by class."""
    methods = {}
    descriptors = list(dict.fromkeys(descriptor for descriptor, _ in compared))
    for family, folder in folders.items():
        rows = training_rows(folder, family, descriptors=descriptors, workers=workers)
        work = [
            (
                descriptor,
                classifier,
                dataclasses.replace(rows, features={descriptor: rows.features[descriptor]}),
            )
            for descriptor, classifier in compared
        ]
        progress = report.Progress(f"train on {family}", len(work))
        methods[family] = list(report.spread(_train_one, work, workers, progress))
    return methods


def _train_one(work):
    return train_method(*work)


@contextlib.contextmanager
def rendered(
    options: argparse.Namespace, sets: Sequence[SceneSet]
) -> Iterator[tuple[dict[str, Path], dict[str, Path]]]:
    """Sets to measure on and sets to train on, which share no shape and no texture, while they are needed.

    Yields:
        The folders of `sets` by name, and of the data set to train on by class.
    """
    report.check_place(options.json)
    with tempfile.TemporaryDirectory(prefix="graspctx_") as temporary:
        folder = options.keep or Path(temporary)
        test, training = render_test_sets(options, folder, sets), training_folders(options, folder)
        refuse_leaks(list(training.values()), list(test.values()))
        yield test, training


# ---- What all of them print and write ----------------------------------------------------------------------


def measured_on(options: argparse.Namespace, each: str = "class") -> str:
    """What was measured on, for the head of the tables; `each` is what --scenes counts by."""
    return f"{options.scenes} scenes of each {each}, split {options.split}"


def trained_on(options: argparse.Namespace) -> str:
    """What was trained on, for the head of the tables."""
    if options.train_data is not None:
        return f"trained on {options.train_data}"
    return f"trained on {options.train_scenes} scenes of each class, split train"


def print_head(name: str, options: argparse.Namespace, each: str = "class") -> None:
    """The lines over a benchmark's tables."""
    print(f"{name}: seed {options.seed}, {measured_on(options, each)}; {trained_on(options)}")
    print(report.ran_on())


def write_rows(name: str, options: argparse.Namespace, rows: list[dict], each: str = "class") -> None:
    """Write a benchmark's rows if --json asks for it."""
    if options.json:
        about = {"measured_on": measured_on(options, each), "trained": trained_on(options)}
        report.write_json(options.json, name, options.seed, rows, **about)
