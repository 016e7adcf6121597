"""The segmentation benchmark: figures on masks with known answers, pairs without objects, a small run."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "scipy", "PIL")):
    pytest.skip("the benchmark needs the extra 'sim' (mujoco, scipy, pillow)", allow_module_level=True)

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import no_objects
import segmentation
from segmentation_axes import informative, object_axes, scene_axes
from segmentation_score import ObjectScore, SceneScore, score_scene
from segmentation_table import unmet_goals

PROGRAM = Path(segmentation.__file__)
TABLES = ("textured", "faint", "plain")
SIZE = (120, 160)


def entry(number=1, px=2000, share=1.0, **more):
    """An object of scene.json, standing 0.5 m before the camera of `scene`."""
    return {
        "id": number,
        "family": "mug",
        "visible_px": {"left": px, "right": px},
        "visible_share": {"left": share, "right": share},
        "cam_from_object": [[1, 0, 0, 0], [0, 1, 0, 0.2], [0, 0, 1, 0.5], [0, 0, 0, 1]],
        "low": False,
        **more,
    }


def scene(*objects, table="textured", **axes):
    """The scene.json of a camera 0.2 m above a table, looking along it."""
    return {
        "objects": list(objects),
        "table_texture": table,
        "table_plane": {"normal": [0.0, -1.0, 0.0], "offset_m": 0.2},
        "axes": axes,
    }


def box(left, top, right, bottom, number=1):
    ids = np.zeros(SIZE, np.uint8)
    ids[top:bottom, left:right] = number
    return ids


# ---- One scene ---------------------------------------------------------------------------------------------


def test_the_truth_itself_is_perfect():
    truth = box(10, 10, 60, 50) + box(80, 10, 120, 60, number=2)
    score = score_scene(truth, truth * 3, scene(entry(1), entry(2)))
    assert [found.iou for found in score.objects] == [1, 1]
    assert (score.false, score.false_on_nothing, score.plane_found) == (0, 0, False)
    assert score.objects[0].hole_filled is None and score.objects[0].plane_angle_deg is None


def test_the_iou_is_that_of_the_best_segment_and_zero_for_a_miss():
    truth = box(0, 0, 40, 40) + box(80, 0, 120, 40, number=2)
    found = box(0, 0, 40, 30, number=7) + box(0, 30, 40, 40, number=4)  # 3/4 and 1/4 of the first
    score = score_scene(truth, found, scene(entry(1), entry(2)))
    assert [result.iou for result in score.objects] == [0.75, 0]
    assert [result.found for result in score.objects] == [True, False]
    assert (score.false, score.false_on_nothing) == (1, 0)  # the quarter is false, but on an object


def test_half_an_object_is_not_found():
    score = score_scene(box(0, 0, 40, 40), box(0, 0, 40, 20, number=1), scene(entry()))
    assert score.objects[0].iou == 0.5 and not score.objects[0].found and score.false == 1


def test_false_segments_and_those_on_nothing():
    truth = box(0, 0, 40, 40) + box(40, 0, 80, 40, number=2)
    merged = np.minimum(truth, 1)
    score = score_scene(truth, merged, scene(entry(1), entry(2)))
    assert [result.iou for result in score.objects] == [0.5, 0.5]
    assert (score.false, score.false_on_nothing) == (1, 0)
    table = merged + box(100, 60, 120, 100, number=9)
    assert score_scene(truth, table, scene(entry(1), entry(2))).false_on_nothing == 1
    mostly_table = box(70, 0, 110, 40, number=5)  # a quarter of it lies on an object
    assert score_scene(truth, mostly_table, scene(entry(1), entry(2))).false_on_nothing == 1


def test_what_is_hardly_seen_is_neither_found_nor_missed():
    truth = box(0, 0, 40, 40) + box(80, 0, 90, 10, number=2) + box(100, 0, 140, 40, number=3)
    objects = entry(1), entry(2, px=100), entry(3, share=0.2)
    score = score_scene(truth, truth, scene(*objects))
    assert [result.id for result in score.objects] == [1] and score.false == 0  # to fit them is no error
    assert [result.id for result in score_scene(truth, 0 * truth, scene(*objects)).objects] == [1]


def test_the_share_of_a_hole_that_is_filled():
    truth = box(10, 10, 70, 70)
    truth[30:50, 30:50] = 0
    score = score_scene(truth, truth, scene(entry()))
    assert score.objects[0].hole_filled == 0
    assert score_scene(truth, box(10, 10, 70, 70), scene(entry())).objects[0].hole_filled == 1
    half = truth.copy()
    half[30:50, 30:40] = 1
    assert score_scene(truth, half, scene(entry())).objects[0].hole_filled == 0.5
    assert score_scene(truth, 0 * truth, scene(entry())).objects[0].hole_filled is None  # not found

    another_in_it = truth.copy()
    another_in_it[30:50, 30:48] = 2  # what is left of the hole is larger than 30 px
    score = score_scene(another_in_it, box(10, 10, 70, 70), scene(entry(1), entry(2)))
    assert score.objects[0].hole_filled == 1
    small = box(10, 10, 70, 70)
    small[30:35, 30:35] = 0
    assert score_scene(small, small, scene(entry())).objects[0].hole_filled is None


@pytest.mark.parametrize("degrees", [0.001, 1.0, 30.0])
def test_the_plane_is_compared_in_direction_and_at_the_foot(degrees):
    truth, turn = box(0, 0, 40, 40), np.radians(degrees)
    normal = np.array([0, -np.cos(turn), np.sin(turn)])
    foot = np.array([0, 0.2, 0.5])  # cam_from_object's place, which lies on the table
    through_foot = score_scene(truth, truth, scene(entry()), plane=(normal, -normal @ foot)).objects[0]
    assert through_foot.plane_angle_deg == pytest.approx(degrees, rel=1e-6)
    assert through_foot.plane_height_mm == pytest.approx(0, abs=1e-9)
    lower = score_scene(truth, truth, scene(entry()), plane=([0, -1, 0], 0.197))
    assert lower.objects[0].plane_height_mm == pytest.approx(3)
    assert lower.objects[0].plane_angle_deg == 0 and lower.plane_found


def test_depth_is_compared_where_the_segment_lies_on_the_object():
    truth, found = box(0, 0, 40, 40), box(0, 0, 40, 30)
    true_depth = np.full(SIZE, 0.6)
    depth = true_depth + 0.005
    depth[:, :10] = np.nan
    depth[30:] += 1  # outside the segment
    result = score_scene(truth, found, scene(entry()), depth_m=depth, true_depth_m=true_depth).objects[0]
    assert result.depth_errors_mm == pytest.approx([5] * 19) and result.depth_known == 0.75
    unknown = score_scene(truth, found, scene(entry()), depth_m=depth * np.nan, true_depth_m=true_depth)
    assert (unknown.objects[0].depth_errors_mm, unknown.objects[0].depth_known) == (None, 0)


# ---- Axes and rows -----------------------------------------------------------------------------------------


def test_scenes_and_objects_count_for_their_axes():
    low = entry(2, low=True, height_m=0.008, pose="lying")
    single, clutter = scene(low, table="uniform"), scene(entry(1), low, noise=1.5, shadow="cast")
    assert scene_axes(single, low_set=False) == ("all", "plain", "single", "single plain", "low", "low plain")
    assert scene_axes(single, low_set=True) == ("low", "low plain")
    assert scene_axes(clutter, low_set=False) == (
        *("all", "textured", "clutter", "clutter textured"),
        *("shadow=cast", "noise 1 to 2"),
    )
    assert object_axes(single, low, low_set=True) == ("low", "low plain")
    of_low, of_high = (object_axes(clutter, which, low_set=False) for which in (low, entry(1)))
    assert {"low", "low textured", "clutter", "height_m < 0.02", "pose=lying"} <= set(of_low)
    assert not any(axis.startswith("low") for axis in of_high) and "visible_px 1000 to 4000" in of_high


def test_axes_that_all_agree_on_say_nothing():
    names = ["all", "single", "noise < 1", "noise >= 4", "shadow=cast", "noise 1 to 2"]
    assert informative(names, names[:1]) == ["all", "single", "noise 1 to 2", "noise < 1", "noise >= 4"]


def measured(ious, false, kind="single", plane_mm=(), left_out=0):
    objects = tuple(
        ObjectScore(number, iou, plane_angle_deg=0.1, plane_height_mm=plane)
        for number, (iou, plane) in enumerate(zip(ious, plane_mm or [1.0] * len(ious)), 1)
    )
    return segmentation.Measured(
        scene=segmentation.Scene(Path("scene"), False),
        scores={"colour": SceneScore(objects, false, 0, True)},
        axes=("all", kind),
        object_axes={result.id: ("all", kind) for result in objects},
        cut_by_border=(),
        objects=len(ious) + left_out,
        stereo_ms=30.0,
        segmentation_ms={"colour": 100.0},
    )


def test_the_rows_of_scenes():
    scenes = [measured([0.9], 0), measured([0.0], 1), measured([0.8, 0.7], 0, "clutter", left_out=1)]
    rows = segmentation.scene_rows(scenes, ("colour",))
    values = {(row["measure"], row["axis"], row.get("stage")): (row["value"], row["n"]) for row in rows}
    assert values["recall", "all", None] == (0.75, 4) and values["recall", "single", None] == (0.5, 2)
    assert values["iou_median", "all", None] == (0.75, 4)  # the miss counts, as 0
    assert values["false_per_scene", "all", None] == (pytest.approx(1 / 3), 3)
    assert values["false_per_scene", "clutter", None] == (0, 1)
    assert values["plane_height_p90_mm", "all", None] == (1, 4)
    assert values["time_ms", "all", "segmentation"] == (100, 3)
    assert values["objects_left_out", "all", None] == (0.2, 5)
    assert not any(row["measure"] == "holes_filled" for row in rows)  # there was no hole


def test_the_rows_of_saying_no():
    pairs = [segmentation.NoObjectPair("wall", index, 1) for index in range(4)]
    answers = [(pair, {"plane": 1, "colour": int(pair.index == 2)}) for pair in pairs]
    rows = segmentation.saying_no_rows(answers, ("plane", "colour"))
    assert [(row["cues"], row["case"], row["value"], row["n"]) for row in rows] == [
        ("plane", "wall", 0, 4),
        ("colour", "wall", 0.75, 4),
    ]


def test_goals_are_judged_at_the_last_level_and_between_levels():
    def row(measure, cues, value, **keys):
        return {"measure": measure, "cues": cues, "value": value, "n": 100, **keys}

    rows = [
        row("recall", "plane", 0.9, axis="all"),
        row("recall", "colour", 0.96, axis="all"),
        row("recall", "plane", 0.95, axis="faint"),
        row("recall", "colour", 0.94, axis="faint"),
        row("saying_no", "plane", 0.5, case="wall"),
        row("saying_no", "colour", 0.95, case="wall"),
        row("false_per_scene", "colour", 0.05, axis="all"),
    ]
    judged, unmet = unmet_goals(rows, ("plane", "colour"))
    assert judged == 6
    assert [(measure, axis) for measure, _, axis, _, _ in unmet] == [
        ("recall", "faint"),  # below the goal
        ("saying_no", "wall"),
        ("recall", "faint"),  # falls from plane to colour
    ]


# ---- Pairs that hold no object -----------------------------------------------------------------------------


@pytest.mark.parametrize("case", no_objects.MADE_UP)
def test_made_up_pairs_follow_from_their_seed(case):
    first, again, next_one, other_seed = (
        no_objects.made_up_pair(case, seed, index, (160, 120))
        for seed, index in ((1, 6), (1, 6), (1, 7), (2, 6))
    )
    for view, view_again in zip(first[:2], again[:2]):
        assert view.shape == (120, 160, 3) and view.dtype == np.uint8
        assert np.array_equal(view, view_again)
    assert any((first[side] != next_one[side]).any() for side in (0, 1))
    assert (first[2].baseline_m, first[2].focal_px) != (other_seed[2].baseline_m, other_seed[2].focal_px)


def test_a_wall_is_a_plane_that_both_views_see():
    for index in (0, 3, 6):  # the textured ones
        left, right, _ = no_objects.made_up_pair("wall", 5, index, (320, 240))
        disparity = gc.compute_disparity(left, right, reliable=True)
        v, u = np.nonzero(np.isfinite(disparity))
        assert len(v) > 0.2 * disparity.size  # where it is textured
        columns = np.stack([u, v, np.ones(len(u))], 1)
        plane = np.linalg.lstsq(columns, disparity[v, u], rcond=None)[0]
        assert np.median(np.abs(columns @ plane - disparity[v, u])) < 0.3
        assert plane @ [160, 120, 1] > 5  # at 2 m and less


def test_dots_are_ten_and_in_both_views_every_other_time():
    from scipy import ndimage

    def rows_of_dots(view):
        labels, count = ndimage.label(view.max(axis=2) > int(np.median(view)) + 25)
        return sorted(round(v) for v, _ in ndimage.center_of_mass(labels > 0, labels, range(1, count + 1)))

    left, right, _ = no_objects.made_up_pair("ten_dots", 4, 1)
    assert rows_of_dots(left) == rows_of_dots(right) and 8 <= len(rows_of_dots(left)) <= 10
    left, right, _ = no_objects.made_up_pair("ten_dots", 4, 2)
    assert rows_of_dots(left) != rows_of_dots(right)


def test_scenes_are_taken_from_all_sets_in_turn():
    a, b, c = Path("a"), Path("b"), Path("c")
    assert no_objects.scenes_in_turn([[a, b], [], [c]]) == [(a, b), (c, c), (b, a)]


# ---- The scenes and the command ----------------------------------------------------------------------------


def test_fresh_sets_hold_every_table_and_family_as_often():
    sets = segmentation.fresh_sets(60)
    assert [(fresh.name, fresh.scenes) for fresh in sets] == [
        *((f"{kind}_{table}", 20) for kind in ("single", "clutter", "low") for table in TABLES),
        *((f"empty_{table}", 20) for table in TABLES),
    ]
    singles = [
        fresh.families[index % len(fresh.families)] for fresh in sets[:3] for index in range(fresh.scenes)
    ]
    assert {singles.count(family) for family in singles} == {4} and len(set(singles)) == 15
    assert sum(fresh.scenes for fresh in segmentation.fresh_sets(10)[:3]) == 10
    assert [segmentation.no_pairs(scenes) for scenes in (3, 20, 60, 90)] == [3, 20, 20, 30]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A small run: what it printed, its JSON, and the folder of its scenes and pictures."""
    folder = tmp_path_factory.mktemp("segmentation")
    arguments = ["--seed", "11", "--scenes", "2", "--resolution", "320x240", "--workers", "1"]
    arguments += ["--cues", "plane,colour", "--json", folder / "result.json"]
    arguments += ["--keep", folder / "scenes", "--pictures", folder / "pictures"]
    result = subprocess.run(
        [sys.executable, PROGRAM, *arguments],
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert result.returncode == 0, result.stderr
    return result, json.loads((folder / "result.json").read_text()), folder


def test_a_small_run_prints_tables_and_writes_rows(run):
    result, content, folder = run
    assert (content["benchmark"], content["seed"]) == ("segmentation", 11)
    for row in content["rows"]:
        keys = set(row) - {"measure", "value", "low", "high", "n"}
        assert keys in ({"cues", "axis"}, {"cues", "case"}, {"cues", "axis", "stage"}, {"axis"}), row
        assert row["n"] >= 1 and (row["low"] is None or row["low"] <= row["high"])
    measures = {(row["measure"], row.get("cues"), row.get("axis")) for row in content["rows"]}
    for measure in ("recall", "iou_median", "false_per_scene"):
        for axis in ("all", "faint", "plain", "single", "clutter", "low"):
            assert (measure, "colour", axis) in measures
    cases = {row["case"]: row for row in content["rows"] if row["measure"] == "saying_no"}
    assert set(cases) == set(no_objects.CASES) - {"unrelated"}  # its scenes are alone in their sets
    assert all(row["n"] == 2 for row in cases.values())
    for case in ("noise", "swapped", "identical", "constant"):
        assert cases[case]["value"] == 1
    assert "| axis" in result.stdout and "Saying no" in result.stdout and "Goals reached" in result.stdout
    assert "render sets: 9 of 9" in result.stderr and "segment scenes: 6 of 6" in result.stderr
    assert all(file.suffix == ".png" for file in (folder / "pictures").iterdir())


def test_sets_that_stand_are_measured_alike_by_any_number_of_processes(run, tmp_path, capsys):
    folders = [str(run[2] / "scenes" / name) for name in ("clutter_plain", "low_faint", "empty_faint")]
    contents = []
    for workers in ("1", "2"):
        file = tmp_path / f"{workers}.json"
        arguments = ["--seed", "3", "--scenes", "1", "--cues", "colour", "--workers", workers]
        assert segmentation.main([*arguments, "--json", str(file), "--data", *folders]) == 0
        content = json.loads(file.read_text())
        contents.append([row for row in content["rows"] if row["measure"] != "time_ms"])
    assert contents[0] == contents[1]
    of_run = {(row["measure"], row.get("axis")): row for row in run[1]["rows"] if row.get("cues") == "colour"}
    for row in contents[0]:  # the same scenes, alone on their axis in both runs
        if row.get("axis") == "clutter plain":
            assert row == of_run[row["measure"], "clutter plain"]
    assert {row["case"] for row in contents[0] if row["measure"] == "saying_no"} >= {"empty_faint", "wall"}


@pytest.mark.parametrize(
    "arguments",
    [
        ["--scenes", "3"],
        ["--seed", "-1"],
        ["--seed", "one"],
        ["--seed", "1", "--cues", "hue"],
        ["--seed", "1", "--scenes", "0"],
        ["--seed", "1", "--resolution", "20x20"],
    ],
)
def test_wrong_usage_exits_with_2(arguments):
    with pytest.raises(SystemExit) as stopped:
        segmentation.main(arguments)
    assert stopped.value.code == 2


def test_what_cannot_be_used_exits_with_3_and_one_line(tmp_path, capsys):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "file.txt").write_text("")
    drawn = tmp_path / "drawn"
    (drawn / "scene_000000").mkdir(parents=True)
    (drawn / "dataset.json").write_text('{"format": "graspctx-dataset", "version": 1, "families": ["mug"]}')
    (drawn / "scene_000000" / "scene.json").write_text('{"objects": [{"id": 1, "family": "mug"}]}')
    for arguments, said in [
        (
            ["--json", str(tmp_path / "absent" / "result.json")],
            "expected a file name in a folder that exists",
        ),
        (["--data", str(tmp_path / "absent")], "dataset.json: missing"),
        (["--data", str(drawn)], "no table_texture; expected a rendered scene"),
        (["--keep", str(tmp_path / "other" / "file.txt")], "file.txt"),
        (["--pictures", str(tmp_path / "other" / "file.txt")], "file.txt"),
    ]:
        assert segmentation.main(["--seed", "1", "--scenes", "1", "--workers", "1", *arguments]) == 3
        printed = capsys.readouterr()
        assert said in printed.err and printed.err.count("\n") == 1 and not printed.out
