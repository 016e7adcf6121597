"""The labelled objects of rendered scenes, and their patches as each descriptor sees them."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import graspctx as gc
import local_appearance
import numpy as np
import report
from graspctx.sim.stored import read_scene, scene_folders
from segmentation_score import counts

DESCRIPTORS = ("shape_context", "local_appearance")
FOVEA_OPTIONS = ("object_px", "margin_px", "refine_mask")


# ---- Objects -----------------------------------------------------------------------------------------------


def labelled_views(
    folder: Path, family: str, group: int = 0, sides: Sequence[str] = ("left",)
) -> list[gc.LabelledView]:
    """Each object of a family that a scene shows well enough to count, in each of its views."""
    entries = [
        entry for entry in read_scene(folder)["objects"] if entry["family"] == family and counts(entry)
    ]
    views = []
    for side in sides:
        image, ids, label = (gc.read_image(folder / f"{side}{name}.png") for name in ("", "_mask", "_label"))
        for entry in entries:
            mask = ids == entry["id"]
            if mask.any():
                view = gc.LabelledView(
                    image,
                    mask,
                    mask & (label > 0),
                    class_name=family,
                    group=group,
                    source=f"{folder}, {side}, object {entry['id']}",
                )
                views.append(view)
    return views


def with_mask(view: gc.LabelledView, mask: np.ndarray) -> gc.LabelledView:
    """The same object with another mask, (H, W), > 0 = object; its label stays."""
    return gc.LabelledView(
        view.image, mask, view.label, class_name=view.class_name, group=view.group, source=view.source
    )


def best_segment(view: gc.LabelledView, segments: np.ndarray) -> np.ndarray | None:
    """The segment that fits the object best, (H, W) bool; None if none has an IoU over 0.5.

    Args:
        segments: (H, W) ids, 0 = background.
    """
    truth = view.mask > 0
    for number in np.unique(segments[truth & (segments > 0)]):
        segment = segments == number
        if 2 * (segment & truth).sum() > (segment | truth).sum():
            return segment
    return None


# ---- Patches -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ViewPatches:
    """The patches of one view of one object, as one descriptor sees them.

    Attributes:
        described: the patches with their labels, and their shape contexts.
        features: (M, D) float32 of the descriptor.
        fovea: the foveal view that the patches lie in.
    """

    described: gc.LabelledPatches
    features: np.ndarray
    fovea: gc.FovealView


def describe(view: gc.LabelledView, descriptor: str, options: dict | None = None) -> ViewPatches:
    """A descriptor at the patches that hold contour.

    Args:
        descriptor: one of DESCRIPTORS.
        options: of describe_view, where they differ from its defaults: a model's own are model.descriptor.
            None: those that models are trained with by default, robust_descriptor.
    """
    options = gc.robust_descriptor() if options is None else options
    described = gc.describe_labelled_view(view, **options)
    fovea = gc.foveal_view(
        view.image, view.mask, **{name: options[name] for name in FOVEA_OPTIONS if name in options}
    )
    if descriptor == "shape_context":
        return ViewPatches(described, described.patches.features, fovea)
    patches = described.patches
    features = local_appearance.local_appearance(
        fovea.image, fovea.mask, patches.cells, patch_side_px(patches)
    )
    return ViewPatches(described, features, fovea)


def has_labelled_patch(view: gc.LabelledView) -> bool:
    """A patch of the mask as it is given is labelled: whatever a method makes of the mask, it counts."""
    return bool(gc.describe_labelled_view(view).labels.any())


def patch_side_px(patches: gc.PatchDescriptors) -> int:
    """Side of a patch in the foveal view; 1 where there is none."""
    if not len(patches):
        return 1
    return round(float((patches.centres[0, 0] + 0.5) / (patches.cells[0, 0] + 0.5)))


# ---- Training rows -----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class TrainingRows:
    """Rows to train on.

    Attributes:
        features: by descriptor, (R, D) float32.
        labels, groups: (R,) int32, 0 or 1, and the number of the scene.
    """

    features: dict[str, np.ndarray]
    labels: np.ndarray
    groups: np.ndarray

    def of_scenes(self, scenes: Sequence[int]) -> TrainingRows:
        """The rows of some scenes, by their numbers."""
        chosen = np.isin(self.groups, scenes)
        features = {name: rows[chosen] for name, rows in self.features.items()}
        return TrainingRows(features, self.labels[chosen], self.groups[chosen])

    def and_also(self, other: TrainingRows) -> TrainingRows:
        """These rows and other ones, whose scenes are other scenes."""
        features = {
            name: np.concatenate([rows, other.features[name]]) for name, rows in self.features.items()
        }
        groups = np.concatenate([self.groups, other.groups + self.groups.max() + 1])
        return TrainingRows(features, np.concatenate([self.labels, other.labels]), groups)


def training_rows(
    dataset: Path,
    family: str,
    *,
    descriptors: Sequence[str] = DESCRIPTORS,
    sides: Sequence[str] = ("left", "right"),
    workers: int = 1,
) -> TrainingRows:
    """The rows of a data set's objects of a family, with true and with degraded masks."""
    folders = list(enumerate(scene_folders(dataset)))
    describe_one = functools.partial(
        _scene_rows, family=family, descriptors=tuple(descriptors), sides=tuple(sides)
    )
    progress = report.Progress(f"describe {family}", len(folders))
    parts = [rows for rows in report.spread(describe_one, folders, workers, progress) if rows is not None]
    if not parts:
        raise report.BadInputError(f"{dataset}: no {family} in it; expected some to train on")
    return TrainingRows(
        {name: np.concatenate([part.features[name] for part in parts]) for name in descriptors},
        np.concatenate([part.labels for part in parts]),
        np.concatenate([part.groups for part in parts]),
    )


def _scene_rows(
    numbered: tuple[int, Path], family: str, descriptors: tuple[str, ...], sides: tuple[str, ...]
) -> TrainingRows | None:
    group, folder = numbered
    views = labelled_views(folder, family, group, sides)
    if not views:
        return None
    views = gc.augment_views(views, seed=group + 1)
    by_descriptor = {name: [describe(view, name) for view in views] for name in descriptors}
    labels = np.concatenate([part.described.labels for part in by_descriptor[descriptors[0]]])
    return TrainingRows(
        {name: np.concatenate([part.features for part in parts]) for name, parts in by_descriptor.items()},
        labels,
        np.full(len(labels), group, np.int32),
    )
