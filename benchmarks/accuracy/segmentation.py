#!/usr/bin/env python3
"""Segmentation against truth: what is found at each level of cues, what is false, and when to say no.

Renders fresh scenes from the seed: --scenes of one object, as many of three to six and as many of one lower
than 2 cm, each on textured, faint and plain tables in equal parts; and for each case in which the only right
answer is "no object" a third of --scenes pairs, but 20 if --scenes are as many. Prints Markdown tables.
"""

from __future__ import annotations

import argparse
import collections
import functools
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import graspctx as gc
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import no_objects
import report
import segmentation_pictures
from datasets import LOW, TRAINED, UNTRAINED
from fresh_scenes import SceneSet, render_sets
from graspctx.sim.splits import SPLITS
from graspctx.sim.stored import DatasetError, read_header, read_scene, scene_folders
from segmentation_axes import MAIN_AXES, TABLES, informative, object_axes, scene_axes
from segmentation_score import (
    FOUND_IOU,
    LEAST_HOLE_PX,
    LEAST_VISIBLE_PX,
    LEAST_VISIBLE_SHARE,
    NOTHING_SHARE,
    SceneScore,
    counts,
    score_scene,
)
from segmentation_table import print_tables

PROGRAM = "segmentation.py"
CUES = ("disparity", "plane", "colour")

DEFINITIONS = f"""what is measured, for each level of cues and each axis:
  recall            share of the objects that a segment fits with IoU > {FOUND_IOU}
  iou_median        median over the objects of the best segment's IoU; 0 where no segment touches one
  false_per_scene   segments a scene that found no object; false_on_nothing_per_scene: those of them less
                    than {NOTHING_SHARE:.0%} of which lies on any object
  holes_filled      share of the background seen through a found object (holes of {LEAST_HOLE_PX} px and more,
                    such as a handle's) that its segment covers; mean over the objects with such a hole
  plane_found       share of the scenes in which there is a table plane
  plane_angle_p90_deg, plane_height_p90_mm
                    90th percentile over the objects, where a plane was found, of its error in direction
                    and, at the object's foot, in height
  depth_error_median_mm, depth_error_p90_mm
                    of the dense disparity's depth over the found part of each found object, every object
                    counting the same; depth_known: the share of that part that has depth
  time_ms           median a scene, one thread, by stage: stereo (compute_disparity) and segmentation
                    (segment_scene less the stereo). Other processes run beside it: --workers 1 on a quiet
                    machine for times to quote
  saying_no         share of the pairs of a case that are answered with no object
  objects_left_out, cut_by_border
                    shares of the true objects that do not count, or touch the picture's border

  An object counts if the left view shows {LEAST_VISIBLE_PX} px and {LEAST_VISIBLE_SHARE:.0%} of it, or
  more; the others are neither found nor missed, and a segment that fits one is not false.

axes: all, the table (textured, faint, plain), single and clutter (one object a scene, or several) and both
  together count the scenes that may hold any object; low counts objects lower than 2 cm of every set, and,
  of what is counted by scene, the scenes that hold nothing else. Then the scenes' axes of difficulty, and
  the objects' family, pose, size and occlusion. A set all of whose families are low
  ({LOW}) counts for low alone, so that there can be many of them.

cases of saying_no:
"""


# ---- One scene, one pair -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    """A scene that is measured.

    Attributes:
        folder: where it lies.
        low_set: whether its set is one of low objects only.
    """

    folder: Path
    low_set: bool


@dataclass(frozen=True)
class Measured:
    """What a scene gave.

    Attributes:
        scores, segmentation_ms: by the level of cues.
        axes: that the scene counts for.
        object_axes: by the ids of the objects that count, the axes that each counts for.
        cut_by_border: ids of objects that touch the border, whether they count or not.
        objects: number of true objects.
    """

    scene: Scene
    scores: dict[str, SceneScore]
    axes: tuple[str, ...]
    object_axes: dict[int, tuple[str, ...]]
    cut_by_border: tuple[int, ...]
    objects: int
    stereo_ms: float
    segmentation_ms: dict[str, float]


def measure_scene(scene: Scene, cues: tuple[str, ...]) -> Measured:
    """Segment a scene of a data set at each level of cues and compare with its truth."""
    info = read_scene(scene.folder)
    left, right = (gc.read_image(scene.folder / f"{side}.png") for side in ("left", "right"))
    truth = gc.read_image(scene.folder / "left_mask.png")
    camera = gc.StereoCamera.load(scene.folder / "calib.txt")
    start = time.perf_counter()
    disparity = gc.compute_disparity(*gc.rectify(left, right, camera))
    stereo_ms = 1000 * (time.perf_counter() - start)
    scores, segmentation_ms = {}, {}
    for level in cues:
        start = time.perf_counter()
        found = gc.segment_scene(left, right, camera, cues=level)
        # It computes the disparity, too, which the program does once.
        segmentation_ms[level] = max(1000 * (time.perf_counter() - start) - stereo_ms, 0.0)
        scores[level] = score_scene(
            truth,
            found.instance_ids,
            info,
            plane=None if found.table is None else (found.table.normal, found.table.offset_m),
            depth_m=camera.depth_m(disparity),
            true_depth_m=segmentation_pictures.read_depth_m(scene.folder / "left_depth.png"),
        )
    border = np.unique(np.concatenate([truth[0], truth[-1], truth[:, 0], truth[:, -1]]))
    return Measured(
        scene,
        scores,
        scene_axes(info, scene.low_set),
        {entry["id"]: object_axes(info, entry, scene.low_set) for entry in info["objects"] if counts(entry)},
        tuple(entry["id"] for entry in info["objects"] if entry["id"] in border),
        len(info["objects"]),
        stereo_ms,
        segmentation_ms,
    )


@dataclass(frozen=True)
class NoObjectPair:
    """A pair that holds no object: number `index` of its case, of scenes in these folders if it needs any."""

    case: str
    index: int
    seed: int
    folders: tuple[Path, ...] = ()


def no_object_images(pair: NoObjectPair, image_size: tuple[int, int]) -> no_objects.Pair:
    """Left and right view and camera of a pair that holds no object."""
    if pair.case in no_objects.MADE_UP:
        return no_objects.made_up_pair(pair.case, pair.seed, pair.index, image_size)
    if pair.case in no_objects.FROM_SCENES:
        return no_objects.pair_from_scenes(pair.case, *pair.folders)
    (folder,) = pair.folders
    left, right = (gc.read_image(folder / f"{side}.png") for side in ("left", "right"))
    return left, right, gc.StereoCamera.load(folder / "calib.txt")


def count_segments(
    pair: NoObjectPair, cues: tuple[str, ...], image_size: tuple[int, int]
) -> tuple[NoObjectPair, dict[str, int]]:
    """How many objects each level of cues finds where there is none."""
    left, right, camera = no_object_images(pair, image_size)
    return pair, {level: len(gc.segment_scene(left, right, camera, cues=level).objects) for level in cues}


# ---- The scenes --------------------------------------------------------------------------------------------


def fresh_sets(scenes: int) -> list[SceneSet]:
    """The sets that are rendered, `scenes` of each kind over the three tables, and empty tables."""
    families = f"{TRAINED},{UNTRAINED}".split(",")
    kinds = {
        "single": (families, (1, 1)),
        "clutter": (families, (3, 6)),
        "low": (LOW.split(","), (1, 1)),
    }
    sets = []
    for kind, (names, objects) in kinds.items():
        before = 0
        for number, table in enumerate(TABLES):
            part = (scenes + number) // len(TABLES)
            # Each table goes on with the families where the one before stopped, so that all come as often.
            turned = names[before % len(names) :] + names[: before % len(names)]
            sets.append(
                SceneSet(f"{kind}_{TABLES[table]}", part, tuple(turned), objects, (f"table={table}",))
            )
            before += part
    for table, name in TABLES.items():
        sets.append(SceneSet(f"empty_{name}", no_pairs(scenes), tuple(families), (0, 0), (f"table={table}",)))
    return sets


def no_pairs(scenes: int) -> int:
    """How many pairs there are of each case that holds no object."""
    return min(scenes, max(20, scenes // 3))


def split_scenes(folders: list[Path]) -> tuple[list[list[Scene]], list[NoObjectPair]]:
    """The scenes of each data set that hold objects, and those that hold none."""
    sets, empty = [], []
    for folder in folders:
        try:
            families = {name.partition("@")[0] for name in read_header(folder)["families"]}
            low_set = families <= set(LOW.split(","))
            infos = {scene: read_scene(scene) for scene in scene_folders(folder)}
        except (DatasetError, KeyError, TypeError) as error:
            raise report.BadInputError(
                str(error) if isinstance(error, DatasetError) else f"{folder}: dataset.json has no families"
            ) from error
        for scene, info in infos.items():
            missing = [key for key in ("table_texture", "table_plane") if key not in info]
            if missing:
                raise report.BadInputError(
                    f"{scene / 'scene.json'}: no {missing[0]}; expected a rendered scene"
                )
        sets.append([Scene(scene, low_set) for scene, info in infos.items() if info["objects"]])
        empty += [
            (f"empty_{TABLES[info['table_texture']]}", scene)
            for scene, info in infos.items()
            if not info["objects"]
        ]
    numbers = collections.Counter()
    pairs = []
    for case, scene in empty:
        pairs.append(NoObjectPair(case, numbers[case], 0, (scene,)))
        numbers[case] += 1
    return sets, pairs


def made_pairs(sets: list[list[Scene]], count: int, seed: int) -> list[NoObjectPair]:
    """`count` pairs of every case that needs no rendered empty table."""
    turns = no_objects.scenes_in_turn([[scene.folder for scene in scenes] for scenes in sets])[:count]
    pairs = [
        NoObjectPair(case, index, seed, folders)
        for case in no_objects.FROM_SCENES
        for index, folders in enumerate(turns)
        if case != "unrelated" or folders[0] != folders[1]
    ]
    return pairs + [NoObjectPair(case, index, seed) for case in no_objects.MADE_UP for index in range(count)]


# ---- Rows -------------------------------------------------------------------------------------------------


def scene_rows(measured: list[Measured], cues: tuple[str, ...]) -> list[dict]:
    """The rows of all measures of scenes."""
    rows = []
    for level in cues:
        objects, scenes = collections.defaultdict(list), collections.defaultdict(list)
        for scene in measured:
            score = scene.scores[level]
            for axis in scene.axes:
                scenes[axis].append(scene)
            for entry in score.objects:
                for axis in scene.object_axes[entry.id]:
                    objects[axis].append(entry)
        for axis in informative(objects, scenes):
            rows += _object_rows(objects[axis], level, axis)
            rows += _scene_rows([scene.scores[level] for scene in scenes[axis]], level, axis)
            if axis in MAIN_AXES and scenes[axis]:
                stages = {
                    "stereo": [scene.stereo_ms for scene in scenes[axis]],
                    "segmentation": [scene.segmentation_ms[level] for scene in scenes[axis]],
                }
                for stage, times in stages.items():
                    rows.append(
                        report.row("time_ms", report.bootstrap(times), cues=level, axis=axis, stage=stage)
                    )
    total = sum(scene.objects for scene in measured)
    if total:
        counted = sum(len(scene.object_axes) for scene in measured)
        cut = sum(len(scene.cut_by_border) for scene in measured)
        rows.append(report.row("objects_left_out", report.share(total - counted, total), axis="all"))
        rows.append(report.row("cut_by_border", report.share(cut, total), axis="all"))
    return rows


def _object_rows(objects, level, axis):
    rows = []

    def add(measure, estimate):
        rows.append(report.row(measure, estimate, cues=level, axis=axis))

    if objects:
        add("recall", report.share(sum(entry.found for entry in objects), len(objects)))
        add("iou_median", report.bootstrap([entry.iou for entry in objects]))
    for measure, field, statistic in (
        ("holes_filled", "hole_filled", np.mean),
        ("plane_angle_p90_deg", "plane_angle_deg", report.percentile_90),
        ("plane_height_p90_mm", "plane_height_mm", report.percentile_90),
        ("depth_error_median_mm", "depth_errors_mm", np.median),
        ("depth_error_p90_mm", "depth_errors_mm", report.percentile_90),
        ("depth_known", "depth_known", np.mean),
    ):
        if field.startswith("depth") and axis not in MAIN_AXES:
            continue
        values = [getattr(entry, field) for entry in objects if getattr(entry, field) is not None]
        if values:
            add(measure, report.bootstrap(values, statistic))
    return rows


def _scene_rows(scores, level, axis):
    if not scores:
        return []
    estimates = {
        "false_per_scene": report.rate([score.false for score in scores]),
        "false_on_nothing_per_scene": report.rate([score.false_on_nothing for score in scores]),
    }
    if level != "disparity":
        estimates["plane_found"] = report.share(sum(score.plane_found for score in scores), len(scores))
    return [report.row(measure, estimate, cues=level, axis=axis) for measure, estimate in estimates.items()]


def saying_no_rows(answers: list[tuple[NoObjectPair, dict[str, int]]], cues: tuple[str, ...]) -> list[dict]:
    """The rows of saying_no."""
    rows = []
    for level in cues:
        for case in no_objects.CASES:
            found = [segments[level] for pair, segments in answers if pair.case == case]
            if found:
                estimate = report.share(sum(count == 0 for count in found), len(found))
                rows.append(report.row("saying_no", estimate, cues=level, case=case))
    return rows


# ---- The command -------------------------------------------------------------------------------------------


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    cases = "".join(f"  {case:15} {text}\n" for case, text in no_objects.CASES.items())
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS + cases)
    report.add_options(parser, scenes=60, scenes_help="scenes of each kind")
    parser.add_argument(
        "--cues",
        metavar="A,B",
        type=_levels,
        default=CUES,
        help=f"levels to measure, of {', '.join(CUES)} (default: all)",
    )
    parser.add_argument(
        "--data",
        metavar="FOLDER",
        type=Path,
        nargs="+",
        help="measure on these data sets of python -m graspctx.sim instead of rendering fresh ones",
    )
    parser.add_argument(
        "--split",
        choices=SPLITS,
        default="test",
        help="of fresh scenes (default: test; for choices: validation)",
    )
    parser.add_argument(
        "--resolution",
        metavar="WxH",
        type=_resolution,
        default=(640, 480),
        help="of fresh pictures (default: 640x480)",
    )
    parser.add_argument(
        "--keep", metavar="FOLDER", type=Path, help="render into this folder, and leave it there"
    )
    parser.add_argument(
        "--pictures",
        metavar="FOLDER",
        type=Path,
        help="write the worst scenes, with truth and segments outlined, and what was found where nothing is",
    )
    return parser


def _levels(text):
    names = text.split(",")
    unknown = [name for name in names if name not in CUES]
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown level '{unknown[0]}'; known: {', '.join(CUES)}")
    return tuple(level for level in CUES if level in names)


def _resolution(text):
    width, _, height = text.partition("x")
    try:
        size = int(width), int(height)
    except ValueError:
        size = (0, 0)
    if not (160 <= size[0] <= 4096 and 120 <= size[1] <= 4096):
        raise argparse.ArgumentTypeError(f"'{text}' is not WIDTHxHEIGHT between 160x120 and 4096x4096")
    return size


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    report.check_place(options.json)
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="graspctx_") as temporary:
        if options.data:
            folders = options.data
        else:
            folders = render_sets(
                options.keep or Path(temporary),
                fresh_sets(options.scenes),
                options.seed,
                split=options.split,
                image_size=options.resolution,
                workers=options.workers,
            )
        _measure(options, folders)


def _measure(options, folders) -> None:
    sets, pairs = split_scenes(folders)
    scenes = [scene for of_set in sets for scene in of_set]
    pairs += made_pairs(sets, no_pairs(options.scenes), options.seed)
    measure = functools.partial(measure_scene, cues=options.cues)
    progress = report.Progress("segment scenes", len(scenes))
    measured = list(report.spread(measure, scenes, options.workers, progress))
    count = functools.partial(count_segments, cues=options.cues, image_size=options.resolution)
    progress = report.Progress("say no", len(pairs))
    answers = list(report.spread(count, pairs, options.workers, progress))

    rows = scene_rows(measured, options.cues) + saying_no_rows(answers, options.cues)
    if options.data:
        what = ", ".join(map(str, options.data))
    else:
        size = "x".join(map(str, options.resolution))
        what = f"{options.scenes} scenes of each kind, split {options.split}, {size}"
    print(f"segmentation: seed {options.seed}, {what}\n{report.ran_on()}, {options.workers} processes")
    print_tables(rows, options.cues)
    if options.json:
        report.write_json(options.json, "segmentation", options.seed, rows, measured_on=what)
    if options.pictures:
        _write_pictures(options, measured, answers)


def _write_pictures(options, measured, answers) -> None:
    for level in options.cues:
        worst = sorted(measured, key=lambda scene: -_badness(scene.scores[level]))
        worst = [scene.scene.folder for scene in worst if _badness(scene.scores[level]) > 0.5][:20]
        if worst:
            file = options.pictures / f"worst_{level}.png"
            segmentation_pictures.write_scenes(file, worst, level)
            print(f"{PROGRAM}: wrote {file}", file=sys.stderr)
        wrong = [pair for pair, segments in answers if segments[level]][:20]
        if wrong:
            file = options.pictures / f"not_no_{level}.png"
            images = [
                (f"{pair.case} {pair.index}", *no_object_images(pair, options.resolution)) for pair in wrong
            ]
            segmentation_pictures.write_pairs(file, images, level)
            print(f"{PROGRAM}: wrote {file}", file=sys.stderr)


def _badness(score):
    return sum(1 - entry.iou for entry in score.objects) + score.false


if __name__ == "__main__":
    sys.exit(main())
