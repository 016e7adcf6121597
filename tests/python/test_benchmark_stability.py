"""The benchmark of stability: masks with known changes, scorers with known answers, a small run."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest
import scenes

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "scipy", "PIL", "sklearn")):
    pytest.skip(
        "the benchmark needs the extras 'sim' and 'benchmark' (mujoco, scipy, pillow, scikit-learn)",
        allow_module_level=True,
    )

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import stability
import stability_masks
from grasp_point_methods import Method
from PIL import Image

PROGRAM = Path(stability.__file__)


@pytest.fixture
def disc():
    v, u = np.mgrid[:200, :240]
    return (u - 120) ** 2 + (v - 100) ** 2 <= 40**2


# ---- Masks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", stability_masks.DILATIONS_PX)
def test_a_dilation_adds_its_radius_on_every_side(disc, radius):
    worse = stability_masks.degraded_mask(disc, f"dilate{radius}", seed=3)
    rows, columns = np.nonzero(worse)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (
        60 - radius,
        140 + radius,
        80 - radius,
        160 + radius,
    )
    assert worse.sum() == pytest.approx(np.pi * (40 + radius) ** 2, rel=0.03)


def test_a_wedge_lies_below_and_a_cut_takes_a_fifth(disc):
    v, u = np.mgrid[: disc.shape[0], : disc.shape[1]]
    for seed in range(20):
        wedge = stability_masks.degraded_mask(disc, "wedge", seed)
        added = wedge & ~disc
        assert (wedge & disc).sum() == disc.sum() and v[added].mean() > 100
        reach = np.hypot(u[added] - 120, v[added] - 100).max() - 40
        assert reach == pytest.approx(stability_masks.WEDGE_REACH * 81, abs=1.5)
        cut = stability_masks.degraded_mask(disc, "cut20", seed)
        assert cut.sum() == pytest.approx(0.8 * disc.sum(), abs=1) and not (cut & ~disc).any()
    below = stability_masks.with_wedge(disc, np.pi / 2) & ~disc
    assert abs(u[below].mean() - 120) < 0.5
    away = stability_masks.cut_off(disc, 0.0)  # towards +u
    assert not away[:, 150:].any() and away[:, :120].sum() == disc[:, :120].sum()


def test_masks_are_the_same_for_the_same_seed(disc):
    for name in stability_masks.DEGRADED:
        first, second = (stability_masks.degraded_mask(disc, name, 7) for _ in range(2))
        np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(stability_masks.degraded_mask(disc, "again", 7), disc)
    cuts = {stability_masks.degraded_mask(disc, "cut20", seed).tobytes() for seed in range(5)}
    assert len(cuts) == 5


# ---- Answers -----------------------------------------------------------------------------------------------


def test_points_return_if_one_is_found_within_reach():
    reference = np.array([[10.0, 10], [50, 50]])
    assert stability.returned_share(reference, np.array([[13.0, 6], [70, 50]]), 4) == 0.5
    assert stability.returned_share(reference, reference[::-1], 0) == 1
    assert stability.returned_share(reference, reference[:0], 4) == 0
    assert stability.returned_share(reference[:0], reference, 4) is None


class Oracle(Method):
    """Scores a patch by its label, smoothed so that neighbours support the best; or by its opposite."""

    def score(self, view):
        patches, _ = super().score(view)
        u, v = patches.described.patches.centres.T
        labels = patches.described.labels
        if self.classifier == "opposite":
            labels = 1 - labels
        distance = np.hypot(u - u[:, None], v - v[:, None]) + 1000 * (labels == 0)
        return patches, 1 / (1 + distance.min(axis=1) / 10)


class Nothing:
    """A model that knows nothing."""

    def predict_probability(self, features):
        return np.full(len(features), 0.5)


@pytest.mark.parametrize("classifier, on_label", [("truth", True), ("opposite", False)])
def test_an_oracle_stays_on_the_label_at_every_mask(classifier, on_label):
    image, _, mask = scenes.disc_scene()
    label = mask.copy()
    label[100:] = 0
    view = gc.LabelledView(image, mask, label)
    masks = {name: stability_masks.degraded_mask(mask > 0, name, 1) for name in stability_masks.DEGRADED}
    method = Oracle("shape_context", classifier, "run", Nothing())
    found = stability.answers(view, masks, method)
    assert set(found) == {"true", *masks}
    assert all(answer.on_label is on_label for answer in found.values())
    assert found["again"] == found["true"] and found["true"].returned == 1
    assert 0 < found["true"].chance < 1


def test_an_object_without_label_or_most_of_it_does_not_count():
    image, _, mask = scenes.disc_scene()
    method = Oracle("shape_context", "truth", "run", Nothing())
    assert stability.answers(gc.LabelledView(image, mask, np.zeros_like(mask)), {}, method) == {}
    left_half, right_half = mask.copy(), mask.copy()
    left_half[:, scenes.DISC_CENTRE_PX[0] :], right_half[:, : scenes.DISC_CENTRE_PX[0]] = 0, 0
    view = gc.LabelledView(image, mask, left_half)
    assert set(stability.answers(view, {"cut20": right_half > 0}, method)) == {"true"}


# ---- The command -------------------------------------------------------------------------------------------


def test_a_small_run(tmp_path):
    file = tmp_path / "stability.json"
    arguments = ["--seed", "6", "--scenes", "3", "--train-scenes", "10", "--classes", "mug", "--workers", "1"]
    arguments += ["--json", file, "--pictures", tmp_path / "pictures"]
    run = subprocess.run([sys.executable, PROGRAM, *arguments], capture_output=True, text=True, timeout=900)
    assert run.returncode == 0, run.stderr
    with Image.open(tmp_path / "pictures" / "mug.png") as sheet:
        assert sheet.size[0] > 2 * 200 and sheet.size[1] > 5 * 200  # two methods, five masks
    content = json.loads(file.read_text())
    assert (content["benchmark"], content["seed"]) == ("stability", 6)
    found = {}
    for row in content["rows"]:
        assert set(row) == {"measure", "method", "mask", "class", "value", "low", "high", "n"}
        assert 0 <= row["value"] <= 1 and row["class"] in ("all", "mug")
        found[row["measure"], row["method"], row["mask"], row["class"]] = row
    for method in (
        "shape_context",
        "shape_context_shipped",
        "local_appearance_rbf",
        "local_appearance_logistic",
    ):
        for mask in ("true", "again", "dilate4", "dilate8", "dilate16", "wedge"):
            assert ("best_on_label", method, mask, "mug") in found
        again = found["peaks_return", method, "again", "all"]
        assert again["value"] == 1  # the same view gives the same points
        assert found["best_on_label", method, "again", "mug"] == {
            **found["best_on_label", method, "true", "mug"],
            "mask": "again",
        }
    assert "all: best grasping point on the label" in run.stdout and "| dilate16 " in run.stdout
