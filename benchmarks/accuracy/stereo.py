#!/usr/bin/env python3
"""Stereo against truth: how much disparity is known, how much of it is wrong, how deep objects are.

On Middlebury's pairs, in the folder that --middlebury or $GRASPCTX_SHARED_DATA/stereo names, and on fresh
scenes, rendered from the seed on textured, faint and plain tables in equal parts. Prints Markdown tables.
"""

from __future__ import annotations

import argparse
import collections
import functools
import importlib.util
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import graspctx as gc
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import report
from datasets import TRAINED, UNTRAINED
from fresh_scenes import SceneSet, render_sets
from graspctx.sim.splits import SPLITS
from graspctx.sim.stored import DatasetError, read_scene, scene_folders
from PIL import Image

PROGRAM = "stereo.py"
TRUTH_FILES = {"disparity_left_x3.png": 3, "disparity_left_x256.png": 256}
TABLES = {"textured": "textured", "faint": "faint", "uniform": "plain"}
METHODS = ("opencv", "half", "half+objects", "full")
BAD_PX = 2
FOUND_IOU = 0.5
DEPTH_UNIT_M = 1e-4

DEFINITIONS = f"""methods:
  opencv        OpenCV's SGBM at full size with the settings of its own example, without padding: what one
                would take otherwise. Needs the package cv2 (pip install opencv-python-headless).
  half          graspctx at half size, the default for a scene
  half+objects  the same, and full size on the segments of graspctx: what detect_grasps has
  full          graspctx at full size

what is measured, of the dense and of the reliable map, over the pixels of known truth that lie in both views:
  known         share of them that the method gives a disparity
  bad_of_known  share of those that are over {BAD_PX} px wrong
  bad_of_all    share of all that are over {BAD_PX} px wrong or not given
  time_ms       median a pair, one thread; half+objects: of the second pass alone
and of the dense map where a segment (IoU > {FOUND_IOU}) lies on its object, every object counting the same:
  depth_error_median_mm, depth_error_p90_mm
                median over the objects of the median, and of the 90th percentile, of an object's pixels
"""


@dataclass(frozen=True)
class Pair:
    """A pair with truth: a scene's folder, and which of the sets it counts for."""

    folder: Path
    of_set: str


@dataclass(frozen=True)
class Truth:
    """Disparity (H, W) px, NaN where unknown; of rendered scenes also instance ids and f·B (px·m)."""

    disparity_px: np.ndarray
    instance_ids: np.ndarray | None = None
    focal_baseline: float = 0.0


# ---- One pair ----------------------------------------------------------------------------------------------


def read_grey(file: Path) -> np.ndarray:
    """(H, W) of a PNG, float64."""
    return np.asarray(Image.open(file), float)


def read_truth(folder: Path) -> Truth:
    """The truth in a scene's folder or in one of Middlebury's."""
    for name, scale in TRUTH_FILES.items():
        if (folder / name).exists():
            grey = read_grey(folder / name)
            return Truth(np.where(grey > 0, grey / scale, np.nan))
    camera = read_scene(folder)["camera"]
    depth_m = read_grey(folder / "left_depth.png") * DEPTH_UNIT_M
    focal_baseline = camera["focal_px"] * camera["baseline_m"]
    with np.errstate(divide="ignore"):
        disparity_px = np.where(depth_m > 0, focal_baseline / depth_m, np.nan)
    return Truth(disparity_px, np.asarray(Image.open(folder / "left_mask.png")), focal_baseline)


def opencv_disparity(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(H, W) px by OpenCV's SGBM, NaN where unknown; searched as far as graspctx searches."""
    import cv2

    cv2.setNumThreads(1)
    block, channels = 3, left.shape[2]
    matcher = cv2.StereoSGBM_create(
        minDisparity=0,
        numDisparities=16 * -(-left.shape[1] // 64),
        blockSize=block,
        P1=8 * channels * block * block,
        P2=32 * channels * block * block,
        disp12MaxDiff=1,
        preFilterCap=63,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=32,
    )
    fixed_point = matcher.compute(left[..., ::-1].copy(), right[..., ::-1].copy())
    return np.where(fixed_point >= 0, fixed_point / 16.0, np.nan)


def compute(
    method: str, left: np.ndarray, right: np.ndarray, segments: np.ndarray, *, reliable: bool
) -> np.ndarray:
    """The dense or the reliable map of a method: (H, W) px, NaN where unknown. OpenCV has but one."""
    if method == "opencv":
        return opencv_disparity(left, right)
    return gc.compute_disparity(
        left,
        right,
        reliable=reliable,
        half_resolution=method != "full",
        instance_ids=segments if method == "half+objects" else None,
    )


def map_shares(disparity_px: np.ndarray, truth_px: np.ndarray) -> dict[str, float]:
    """known, bad_of_known and bad_of_all of a map; (H, W) px each, NaN where unknown."""
    columns = np.arange(truth_px.shape[1])
    both = np.isfinite(truth_px) & (columns - np.nan_to_num(truth_px) >= 0)
    known = both & np.isfinite(disparity_px)
    bad = int((np.abs(disparity_px[known] - truth_px[known]) > BAD_PX).sum())
    missing = int(both.sum() - known.sum())
    return {
        "known": known.sum() / max(both.sum(), 1),
        "bad_of_known": bad / max(known.sum(), 1),
        "bad_of_all": (bad + missing) / max(both.sum(), 1),
    }


def object_errors_mm(
    disparity_px: np.ndarray, truth: Truth, segments: np.ndarray
) -> list[tuple[float, float]]:
    """Of every object that was found the median and the 90th percentile of its pixels' errors in depth."""
    errors = []
    for number in np.unique(truth.instance_ids[truth.instance_ids > 0]):
        mask = truth.instance_ids == number
        for found in np.unique(segments[mask & (segments > 0)]):
            segment = segments == found
            if (mask & segment).sum() <= FOUND_IOU * (mask | segment).sum():
                continue
            at = mask & segment & (disparity_px > 0)
            if at.any():
                off = truth.focal_baseline * (1 / disparity_px[at] - 1 / truth.disparity_px[at])
                errors.append(tuple(1000 * np.percentile(np.abs(off), [50, 90])))
    return errors


def measure_pair(pair: Pair, methods: tuple[str, ...]) -> list[tuple[str, dict, object]]:
    """(measure, keys, value) of everything that one pair shows."""
    left, right = (
        np.asarray(Image.open(pair.folder / f"{side}.png").convert("RGB")) for side in ("left", "right")
    )
    truth = read_truth(pair.folder)
    camera = gc.StereoCamera.load(pair.folder / "calib.txt")
    segments = gc.segment_objects(left, right, camera)
    values = []
    times_ms = {}
    for method in methods:
        start = time.perf_counter()
        maps = {"dense": compute(method, left, right, segments, reliable=False)}
        times_ms[method] = 1000 * (time.perf_counter() - start)
        if method != "opencv":
            maps["reliable"] = compute(method, left, right, segments, reliable=True)
        for name, disparity_px in maps.items():
            keys = {"set": pair.of_set, "method": method, "map": name}
            shares = map_shares(disparity_px, truth.disparity_px)
            values += [(measure, keys, share) for measure, share in shares.items()]
        if truth.instance_ids is not None:
            keys = {"set": pair.of_set, "method": method, "map": "dense"}
            errors = object_errors_mm(maps["dense"], truth, segments)
            values += [("objects", keys, error) for error in errors]
    for method, time_ms in times_ms.items():
        alone = time_ms - times_ms["half"] if method == "half+objects" else time_ms
        values.append(("time_ms", {"set": pair.of_set, "method": method, "map": "dense"}, alone))
    return values


# ---- All pairs ---------------------------------------------------------------------------------------------


def middlebury_pairs(folder: Path) -> list[Pair]:
    """The pairs with truth among a folder's; BadInputError if there are none."""
    found = [
        Pair(file.parent, "middlebury") for name in TRUTH_FILES for file in sorted(folder.glob(f"*/{name}"))
    ]
    if not found:
        raise report.BadInputError(f"{folder}: no pair in it has {' or '.join(TRUTH_FILES)}; expected some")
    return found


def rows_of(values: list[tuple[str, dict, object]]) -> list[dict]:
    """The benchmark's rows: means over pairs of shares, medians over objects and of times."""
    groups = collections.defaultdict(list)
    for measure, keys, value in values:
        groups[measure, tuple(keys.items())].append(value)
    rows = []
    for (measure, keys), found in groups.items():
        if measure == "objects":
            for name, numbers in zip(("depth_error_median_mm", "depth_error_p90_mm"), zip(*found)):
                rows.append(report.row(name, report.bootstrap(numbers), **dict(keys)))
        else:
            statistic = np.median if measure == "time_ms" else np.mean
            rows.append(report.row(measure, report.bootstrap(found, statistic), **dict(keys)))
    return rows


def print_rows(rows: list[dict]) -> None:
    """A table for each set: a line for each method and map."""
    names = ("known", "bad_of_known", "bad_of_all", "depth_error_median_mm", "depth_error_p90_mm", "time_ms")
    digits = dict(zip(names, (3, 3, 3, 1, 1, 0)))
    by_line = collections.defaultdict(dict)
    for line in rows:
        by_line[line["set"], line["method"], line["map"]][line["measure"]] = line
    for of_set in dict.fromkeys(key[0] for key in by_line):
        lines = [
            [method, name, *(report.figure(figures.get(measure), digits[measure]) for measure in names)]
            for (line_set, method, name), figures in by_line.items()
            if line_set == of_set
        ]
        count = max(line["n"] for line in rows if line["set"] == of_set and line["measure"] == "known")
        print(f"\n{of_set}, {count} pairs\n\n" + report.table(("method", "map", *names), lines, left=2))


def build_parser() -> argparse.ArgumentParser:
    """The parser of the command line."""
    parser = report.parser(PROGRAM, __doc__, DEFINITIONS)
    report.add_options(parser, scenes=60, scenes_help="scenes of one to four objects")
    parser.add_argument("--middlebury", metavar="FOLDER", type=Path, help="folder of Middlebury's pairs")
    parser.add_argument(
        "--data", metavar="FOLDER", type=Path, help="measure on this data set instead of fresh scenes"
    )
    parser.add_argument(
        "--split",
        choices=SPLITS,
        default="test",
        help="of fresh scenes (default: test; for choices: validation)",
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = build_parser().parse_args(arguments)
    return report.run(PROGRAM, functools.partial(_run, options))


def _run(options) -> None:
    report.check_place(options.json)
    methods, pairs = METHODS, []
    if importlib.util.find_spec("cv2") is None:
        methods = METHODS[1:]
        print(f"{PROGRAM}: cv2 is not installed: no rows for opencv", file=sys.stderr)
    folder = options.middlebury
    if folder is None and "GRASPCTX_SHARED_DATA" in os.environ:
        folder = Path(os.environ["GRASPCTX_SHARED_DATA"]) / "stereo"
    if folder is None:
        print(f"{PROGRAM}: no --middlebury, no $GRASPCTX_SHARED_DATA: no real pairs", file=sys.stderr)
    else:
        pairs = middlebury_pairs(folder)
    with tempfile.TemporaryDirectory(prefix="graspctx_") as temporary:
        folders = [options.data] if options.data else _render(options, Path(temporary))
        try:
            for dataset in folders:
                for scene in scene_folders(dataset):
                    pairs.append(Pair(scene, TABLES.get(read_scene(scene).get("table_texture"), "other")))
        except DatasetError as error:
            raise report.BadInputError(str(error)) from error
        measure = functools.partial(measure_pair, methods=methods)
        progress = report.Progress("match pairs", len(pairs))
        values = [
            value for found in report.spread(measure, pairs, options.workers, progress) for value in found
        ]
    rows = rows_of(values)
    what = str(options.data) if options.data else f"{options.scenes} scenes, split {options.split}"
    print(f"stereo: seed {options.seed}, {what}\n{report.ran_on()}, {options.workers} processes")
    print_rows(rows)
    if options.json:
        report.write_json(options.json, "stereo", options.seed, rows, measured_on=what)


def _render(options, folder: Path) -> list[Path]:
    families = tuple(f"{TRAINED},{UNTRAINED}".split(","))
    sets = [
        SceneSet(name, (options.scenes + number) // len(TABLES), families, (1, 4), (f"table={table}",))
        for number, (table, name) in enumerate(TABLES.items())
    ]
    return render_sets(folder, sets, options.seed, split=options.split, workers=options.workers)


if __name__ == "__main__":
    sys.exit(main())
