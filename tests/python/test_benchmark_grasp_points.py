"""The benchmark of grasp points: figures of scorers that are known, classifiers, leaks, and a small run."""

import importlib.util
import json
import pickle
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest
from conftest import write_drawn_dataset

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "scipy", "PIL", "sklearn")):
    pytest.skip(
        "the benchmark needs the extras 'sim' and 'benchmark' (mujoco, scipy, pillow, scikit-learn)",
        allow_module_level=True,
    )

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import grasp_point_pictures as pictures
import grasp_points
import report
from grasp_point_methods import Method, refuse_leaks
from grasp_point_score import Ranking, ScoredView, estimates
from grasp_point_views import best_segment, describe, labelled_views, training_rows, with_mask
from patch_classifiers import Rbf, train_logistic, train_rbf

PROGRAM = Path(grasp_points.__file__)


def random_views(seed, score, views=400):
    """Views of 20 to 80 patches, 10 to 30 % of them labelled, scored by score(labels, rng)."""
    rng = np.random.default_rng(seed)
    made = []
    for _ in range(views):
        labels = (rng.random(rng.integers(20, 80)) < rng.uniform(0.1, 0.3)).astype(int)
        shares = np.where(labels, rng.uniform(0.05, 1, len(labels)), 0)
        has_label = bool(labels.any())
        made.append(ScoredView(score(labels, rng), labels, shares, rng.uniform(0, 0.1), has_label))
    return made


# ---- Pictures ----------------------------------------------------------------------------------------------


class Certain:
    """A scorer that is sure of the labelled patches, or of the others."""

    def __init__(self, of_label):
        self.of_label = of_label

    def score(self, view):
        patches = describe(view, "shape_context")
        return patches, (patches.described.labels == self.of_label).astype(float)


def ringed(tile, colour):
    """Whether the ring of that colour is in a tile."""
    return (np.asarray(tile) == colour).all(axis=2).sum() > 40


def test_a_tile_shows_whether_the_best_patch_is_labelled(drawn):
    (view,) = labelled_views(drawn / "scene_000000", "mug")
    hit, miss = (pictures.response_tile(view, Certain(of_label)) for of_label in (1, 0))
    assert ringed(hit, pictures.HIT) and not ringed(hit, pictures.MISS)
    assert ringed(miss, pictures.MISS) and not ringed(miss, pictures.HIT)
    outlined = np.any([(np.asarray(hit) == c).all(axis=2) for c in (pictures.MASK, pictures.LABEL)], axis=0)
    rows, columns = np.nonzero(outlined)
    margin = hit.width * pictures._MARGIN / (1 + 2 * pictures._MARGIN)  # the mask fills the rest
    assert max(np.ptp(rows), np.ptp(columns)) == pytest.approx(hit.width - 2 * margin, abs=3)


def test_colours_rise_with_p():
    brightness = [sum(pictures.colour_of(p)) for p in np.linspace(0, 1, 21)]
    assert brightness == sorted(brightness) and len(set(brightness)) == 21


def test_a_sheet_is_whole_or_not_there(tmp_path):
    tile = pictures.Image.new("RGB", (220, 220), (1, 2, 3))
    pictures.write_sheet(tmp_path / "new" / "sheet.png", [[("a", tile), ("b", tile)], [("c", tile)]])
    with pictures.Image.open(tmp_path / "new" / "sheet.png") as sheet:
        assert sheet.getpixel((300, 100)) == (1, 2, 3) and sheet.getpixel((300, 400)) == (255, 255, 255)
    (tmp_path / "file").write_text("")
    with pytest.raises(report.BadInputError, match="file"):
        pictures.write_sheet(tmp_path / "file" / "sheet.png", [[("a", tile)]])
    pictures.write_sheet(tmp_path / "none.png", [])
    assert not (tmp_path / "none.png").exists()


# ---- Figures -----------------------------------------------------------------------------------------------


def test_an_oracle_is_perfect():
    found = estimates(random_views(1, lambda labels, rng: labels + 0.5 * rng.random(len(labels)), views=60))
    for measure in ("ap", "ap_border_ignored", "auc", "top1", "top1_large_label"):
        assert found[measure].value == 1, measure
    assert found["ap"].low == found["ap"].high == 1
    assert found["top1"].n >= found["top1_large_label"].n > 0


def test_a_scorer_that_knows_nothing_is_at_chance():
    found = estimates(random_views(2, lambda labels, rng: rng.random(len(labels))))
    assert found["top1"].low < found["chance"].value < found["top1"].high
    assert found["ap"].value == pytest.approx(found["prior"].value, abs=0.02)
    assert found["ap_border_ignored"].value == pytest.approx(found["prior_border_ignored"].value, abs=0.02)
    assert found["auc"].low < 0.5 < found["auc"].high


def test_figures_are_those_of_graspctx_also_where_scores_are_tied():
    views = random_views(3, lambda labels, rng: np.round(labels * 0.3 + rng.random(len(labels)), 1), views=50)
    scores, labels = (
        np.concatenate([getattr(view, name) for view in views]) for name in ("scores", "labels")
    )
    ranking, once = Ranking(views), np.ones(len(views))
    assert ranking.average_precision(once) == pytest.approx(gc.average_precision(scores, labels))
    assert ranking.roc_area(once) == pytest.approx(gc.roc_area(scores, labels))
    twice = np.arange(len(views)) % 3 * 1.0  # a resample counts views none, once or twice
    repeated = [view for view, weight in zip(views, twice) for _ in range(int(weight))]
    scores, labels = (
        np.concatenate([getattr(view, name) for view in repeated]) for name in ("scores", "labels")
    )
    assert ranking.average_precision(twice) == pytest.approx(gc.average_precision(scores, labels))
    assert ranking.roc_area(twice) == pytest.approx(gc.roc_area(scores, labels))


def test_what_was_not_found_fails_at_top1_and_has_no_patches():
    nothing = np.zeros(0)
    views = [
        ScoredView(np.array([0.9, 0.1]), np.array([1, 0]), np.array([1.0, 0]), 0.1, True),
        ScoredView(nothing, nothing.astype(int), nothing, 0.1, True),
        ScoredView(np.array([0.3, 0.2]), np.array([0, 0]), np.zeros(2), 0.0, False),  # no label to be seen
    ]
    found = estimates(views)
    assert (found["top1"].value, found["top1"].n) == (0.5, 2)
    assert found["chance"].value == 0.25 and found["ap"].n == 2 and found["ap"].value == 1
    assert "ap" not in estimates(views[2:]) and "top1" not in estimates(views[2:])


# ---- Classifiers -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shells():
    """Points inside and outside of a sphere, of a few groups: nothing that a plane can part."""
    rng = np.random.default_rng(0)
    features = rng.normal(size=(1500, 6)).astype(np.float32)
    features[:, 0] *= 100  # to be standardised
    labels = ((features / [100, 1, 1, 1, 1, 1]) ** 2).sum(1) < 4
    return features, labels.astype(np.int32), np.repeat(np.arange(15, dtype=np.int32), 100)


def test_an_rbf_of_any_width_answers_as_its_model_and_travels(shells):
    model = train_rbf(*shells)
    copied = pickle.loads(pickle.dumps(Rbf.of(model)))
    expected = model.predict_probability(shells[0])
    np.testing.assert_allclose(copied.predict_probability(shells[0]), expected, atol=1e-5)
    assert copied.predict_probability(shells[0][:0]).shape == (0,)
    assert gc.average_precision(expected, shells[1]) > 0.9


def test_logistic_regression_parts_what_a_plane_parts_and_is_calibrated(shells):
    features, _, groups = shells
    rng = np.random.default_rng(1)
    truth = 1 / (1 + np.exp(-(features[:, 0] / 50 - features[:, 1] - 1)))
    labels = (rng.random(len(truth)) < truth).astype(np.int32)
    model = pickle.loads(pickle.dumps(train_logistic(features, labels, groups)))
    assert np.abs(model.predict_probability(features) - truth).mean() < 0.04
    sphere = train_logistic(*shells).predict_probability(features)
    assert gc.roc_area(sphere, shells[1]) < 0.65  # no plane parts the shells


# ---- Scenes ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Drawn mugs, with what a rendered scene also says of its objects."""
    folder = tmp_path_factory.mktemp("drawn") / "mugs"
    write_drawn_dataset(folder, scenes=6, seed=5)
    for number, file in enumerate(sorted(folder.glob("*/scene.json"))):
        seeds = {"shape_seed": 16 * number, "texture_seed": 16 * number}
        visible = {"visible_px": {"left": 3000, "right": 3000}}
        objects = [{"id": 1, "family": "mug", **visible, **seeds}]
        file.write_text(json.dumps({"schema": 1, "objects": objects}))
    return folder


def test_both_descriptors_see_the_same_patches(drawn):
    (view,) = labelled_views(drawn / "scene_000000", "mug")
    shape, local = (describe(view, name) for name in ("shape_context", "local_appearance"))
    np.testing.assert_array_equal(shape.described.patches.cells, local.described.patches.cells)
    assert (shape.features.shape[1], local.features.shape[1]) == (240, 459)
    assert not labelled_views(drawn / "scene_000000", "pencil")


def test_training_rows_are_those_of_graspctx(drawn):
    rows = training_rows(drawn, "mug")
    views = [
        labelled_views(folder, "mug", group, ("left", "right"))
        for group, folder in enumerate(sorted(drawn.glob("scene_*")))
    ]
    first = gc.build_training_set(views[0], seed=1, **gc.robust_descriptor())
    np.testing.assert_array_equal(rows.features["shape_context"][rows.groups == 0], first.features)
    np.testing.assert_array_equal(rows.labels[rows.groups == 0], first.labels)
    assert set(rows.groups) == set(range(6)) and set(rows.of_scenes([1, 4]).groups) == {1, 4}
    assert set(rows.and_also(rows.of_scenes([2, 3])).groups) == {0, 1, 2, 3, 4, 5, 8, 9}
    with pytest.raises(report.BadInputError, match="no pencil in it"):
        training_rows(drawn, "pencil")


def test_the_segment_of_an_object_is_the_one_that_fits(drawn):
    (view,) = labelled_views(drawn / "scene_000000", "mug")
    mask = view.mask > 0
    segments = np.where(mask, 7, 0).astype(np.uint8)
    segments[:3] = 2
    np.testing.assert_array_equal(best_segment(view, segments), mask)
    halves = segments.copy()
    halves[:, : int(np.median(np.nonzero(mask)[1]))] = 0
    assert best_segment(view, np.where(halves == 7, 0, segments)) is None
    assert grasp_points.label_covered(view, segments) == 1
    assert grasp_points.label_covered(view, np.where(mask & (view.label == 0), 7, 0)) == 0
    assert grasp_points.label_covered(view, np.zeros_like(segments)) is None
    np.testing.assert_array_equal(with_mask(view, mask[::-1].copy()).mask > 0, mask[::-1])


def test_what_shares_a_shape_with_the_test_is_refused(drawn, tmp_path):
    other = tmp_path / "other"
    write_drawn_dataset(other, scenes=2, seed=6)
    refuse_leaks([other], [drawn])
    with pytest.raises(report.BadInputError, match="shares 6 shapes and 6 textures with the test"):
        refuse_leaks([drawn], [drawn])


# ---- The command -------------------------------------------------------------------------------------------


def test_a_small_run(tmp_path):
    file = tmp_path / "grasp_points.json"
    arguments = ["--seed", "5", "--scenes", "4", "--train-scenes", "10", "--classes", "mug", "--workers", "1"]
    arguments += ["--json", file, "--pictures", tmp_path / "pictures"]
    run = subprocess.run([sys.executable, PROGRAM, *arguments], capture_output=True, text=True, timeout=900)
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "pictures" / "worst_mug.png").stat().st_size > 10000
    content = json.loads(file.read_text())
    assert (content["benchmark"], content["seed"]) == ("grasp_points", 5)
    found = {}
    for row in content["rows"]:
        keys = ("class", "descriptor", "classifier", "trained_on", "mask")
        assert set(row) == {"measure", *keys, "value", "low", "high", "n"} and row["class"] == "mug"
        assert 0 <= row["value"] <= 1 and 1 <= row["n"] <= 4
        found[(row["measure"], *(row[key] for key in keys[1:]))] = row
    measures = ("ap", "ap_border_ignored", "auc", "top1", "chance", "prior")
    for method in (
        ("shape_context", "rbf", "shipped"),
        ("shape_context", "rbf", "run"),
        ("shape_context", "logistic", "run"),
        ("local_appearance", "rbf", "run"),
        ("local_appearance", "logistic", "run"),
    ):
        assert all((measure, *method, "true") in found for measure in measures), method
        assert ("found", *method, "segmented") in found and ("label_covered", *method, "segmented") in found
    priors = {
        row["value"] for (measure, *_, mask), row in found.items() if (measure, mask) == ("prior", "true")
    }
    assert len(priors) == 1  # the same patches, whoever scores them
    assert "At the true mask" in run.stdout and "| mug " in run.stdout
    assert "train on mug: 4 of 4" in run.stderr


def test_the_figures_of_the_command_are_those_of_evaluate_model(tmp_path):
    """At the true mask, against the evaluation in C++, on drawn mugs with the shipped model."""
    folder = tmp_path / "mugs"
    write_drawn_dataset(folder, scenes=8, seed=9)
    for file in folder.glob("*/scene.json"):
        objects = [{"id": 1, "family": "mug", "visible_px": {"left": 3000, "right": 3000}}]
        file.write_text(json.dumps({"schema": 1, "objects": objects}))
    model = gc.load_model("mug")
    method = Method("shape_context", "rbf", "shipped", model, model.descriptor)
    rows = grasp_points.class_rows(folder, "mug", [method], workers=1)
    found = {row["measure"]: row["value"] for row in rows if row["mask"] == "true"}
    (expected,) = gc.evaluate_model(model, gc.load_dataset(folder, views="left"))
    assert found["ap"] == pytest.approx(expected.average_precision)
    assert found["ap_border_ignored"] == pytest.approx(expected.average_precision_border_ignored)
    assert found["auc"] == pytest.approx(expected.roc_area)
    assert found["prior"] == pytest.approx(expected.label_prior)
    assert (found["top1"], found["chance"]) == pytest.approx((expected.top1, expected.top1_chance))


@pytest.mark.parametrize(
    "arguments, code, words",
    [
        (["--classes", "mug", "--train-data", "nowhere"], 3, "nowhere: no such folder"),
        (["--classes", "unicorn"], 2, "unknown class 'unicorn'"),
        (["--train-scenes", "2"], 2, "is not a whole number of at least 10"),
    ],
)
def test_what_cannot_be_used_is_named(arguments, code, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    given = ["--seed", "1", "--scenes", "1", "--workers", "1", *arguments]
    try:
        assert grasp_points.main(given) == code
    except SystemExit as stopped:
        assert stopped.code == code
    assert words in capsys.readouterr().err
