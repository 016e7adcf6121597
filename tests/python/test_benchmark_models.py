"""The benchmarks of calibration, few images and new shapes: known answers, and a small run of each."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "scipy", "PIL", "sklearn")):
    pytest.skip(
        "the benchmarks need the extras 'sim' and 'benchmark' (mujoco, scipy, pillow, scikit-learn)",
        allow_module_level=True,
    )

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import calibration
import few_images
import new_shapes
from grasp_point_score import ScoredView

ACCURACY = Path(calibration.__file__).parent


def views_of(scores, labels, patches=50):
    """Views of some patches each."""
    cuts = range(0, len(scores), patches)
    return [
        ScoredView(scores[i : i + patches], labels[i : i + patches], labels[i : i + patches] * 1.0, 0.1, True)
        for i in cuts
    ]


def small_run(program, tmp_path, *arguments):
    """The rows of a run, checked for what all benchmarks promise, and what it printed."""
    file = tmp_path / "result.json"
    given = ["--seed", "8", "--scenes", "3", "--train-scenes", "10", "--workers", "1", "--json", file]
    command = [sys.executable, ACCURACY / f"{program}.py", *given, *arguments]
    run = subprocess.run(command, capture_output=True, text=True, timeout=900)
    assert run.returncode == 0, run.stderr
    content = json.loads(file.read_text())
    assert (content["benchmark"], content["seed"]) == (program, 8)
    assert all(row["n"] >= 1 and row["value"] >= 0 for row in content["rows"])
    return content["rows"], run.stdout


# ---- Calibration -------------------------------------------------------------------------------------------


def test_what_is_calibrated_has_no_error_and_what_is_sure_of_itself_has():
    rng = np.random.default_rng(0)
    probabilities = rng.random(20_000)
    labels = (rng.random(20_000) < probabilities).astype(int)
    once = np.ones(400)
    honest = calibration.Reliability(views_of(probabilities, labels))
    assert honest.calibration_error(once) < 0.02
    assert honest.brier(once) == pytest.approx(1 / 6, abs=0.01)  # the mean of P (1 - P)
    assert honest.brier_of_prior(once) == pytest.approx(1 / 4, abs=0.01)
    sure = calibration.Reliability(views_of(np.round(probabilities), labels))
    assert sure.calibration_error(once) == pytest.approx(0.25, abs=0.02)
    assert honest.bins(once)[:, 0].sum() == 20_000


def test_the_error_is_that_of_graspctx_for_any_weights():
    rng = np.random.default_rng(1)
    probabilities, labels = rng.random(500) ** 2, rng.integers(0, 2, 500)
    probabilities[:3] = 0, 1, 0.5
    views = views_of(probabilities, labels)
    reliability = calibration.Reliability(views)
    weights = np.arange(10) % 3 * 1.0
    chosen = np.repeat(weights, 50).astype(int)
    expected = gc.expected_calibration_error(np.repeat(probabilities, chosen), np.repeat(labels, chosen))
    assert reliability.calibration_error(weights) == pytest.approx(expected)
    assert reliability.prior(weights) == pytest.approx(np.repeat(labels, chosen).mean())


def test_a_small_run_of_calibration(tmp_path):
    rows, printed = small_run("calibration", tmp_path, "--classes", "mug")
    found = {(row["measure"], row["class"], row["model"], row["trained_on"]): row["value"] for row in rows}
    for shape in ("mug", "teapot"):
        for trained_on in ("run", "shipped"):
            assert 0 <= found["ece", shape, "mug", trained_on] <= 1
        assert found["prior", shape, "mug", "run"] == found["prior", shape, "mug", "shipped"]
    assert "| teapot | mug " in printed


# ---- Few images --------------------------------------------------------------------------------------------


def test_draws_are_of_different_scenes_and_the_same_for_the_same_seed():
    scenes = np.arange(3, 40)
    draws = few_images.draw_scenes(scenes, 10, 3, seed=1)
    assert all(len(set(draw)) == 10 and set(draw) <= set(scenes) for draw in draws)
    assert len({tuple(draw) for draw in draws}) == 3
    np.testing.assert_array_equal(draws, few_images.draw_scenes(scenes, 10, 3, seed=1))
    assert len(few_images.draw_scenes(scenes, 37, 3, seed=1)) == 1


def test_the_share_of_a_model_that_is_as_good_is_one_and_of_a_random_one_the_prior():
    rng = np.random.default_rng(2)
    labels = (rng.random(10_000) < 0.2).astype(int)
    perfect, random = views_of(labels + 0.0, labels), views_of(rng.random(10_000), labels)
    rows = few_images.rows_of("mug", {5: [random, random], 10: [perfect], "full": [perfect]})
    found = {(row["measure"], row["images"]): row for row in rows}
    assert (
        found["ap", "full"]["value"] == found["ap", 10]["value"] == found["share_of_full", 10]["value"] == 1
    )
    assert found["share_of_full", 5]["value"] == pytest.approx(found["prior", "full"]["value"], abs=0.02)
    assert found["share_of_full", 5]["low"] < 0.2 < found["share_of_full", 5]["high"]


def test_a_small_run_of_few_images(tmp_path):
    rows, printed = small_run("few_images", tmp_path, "--classes", "mug", "--draws", "2")
    found = {(row["measure"], row["images"]) for row in rows}
    assert {("ap", 5), ("ap", 10), ("ap", "full"), ("share_of_full", 5), ("prior", "full")} <= found
    assert ("ap", 20) not in found  # there are ten
    assert "| mug   |   full | " in printed


# ---- New shapes --------------------------------------------------------------------------------------------


def test_the_best_of_two_models_is_the_one_that_likes_a_patch_best():
    labels = np.array([0, 1, 0])
    first, second = (
        ScoredView(np.array(scores), labels, labels * 1.0, 0.1, True)
        for scores in ([0.3, 0.2, 0.1], [0.1, 0.9, 0.2])
    )
    (best,) = new_shapes.with_best_scores([[first], [second]])
    np.testing.assert_array_equal(best.scores, [0.3, 0.9, 0.2])
    assert best.hit and not first.hit


def test_no_model_is_tested_on_a_class_that_it_is_trained_on():
    assert len(new_shapes.TRAINED_ON) == 8
    assert all(shape not in classes for shape, classes in new_shapes.TRAINED_ON.items())


def test_a_small_run_of_new_shapes(tmp_path):
    pictures = tmp_path / "pictures"
    rows, printed = small_run("new_shapes", tmp_path, "--classes", "spoon", "--pictures", str(pictures))
    assert (pictures / "spoon.png").stat().st_size > 10000
    keys = {(row["trained_on"], row["tested_on"]) for row in rows}
    assert keys == {("pencil+wineglass", "spoon")}
    found = {(row["measure"], row["descriptor"], row["models"]): row["value"] for row in rows}
    for descriptor in new_shapes.DESCRIPTORS:
        for models in ("joint", "best"):
            assert 0 <= found["top1", descriptor, models] <= 1
    assert len({value for (measure, *_), value in found.items() if measure == "chance"}) == 1
    assert "| spoon | pencil+wineglass " in printed
    assert new_shapes.main(["--seed", "1", "--classes", "book"]) == 3
