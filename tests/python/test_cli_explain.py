"""graspctx_cli explain: its summary, its JSON, its picture, and what it refuses."""

import json
import shutil

import numpy as np
import pytest
from conftest import REPOSITORY

Image = pytest.importorskip("PIL.Image")


@pytest.fixture(scope="module")
def explain(cli, mug_pair, trained_model):
    """Runs the command on the bundled pair with the drawn model."""

    def run(*arguments, model=trained_model, **options):
        return cli("explain", *mug_pair.arguments, "--model", model, *arguments, **options)

    return run


@pytest.fixture(scope="module")
def document(explain):
    result = explain("--json", "-")
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


KEYS = [
    *["schema", "graspctx", "model", "object", "rank", "probability", "probability_left"],
    *["probability_right", "left_px"],
    *["decision_value", "view", "patch", "points", "windows", "ring_radii_px", "other_effect"],
    "nearest_images",
]
WINDOW_KEYS = ["side_px", "effect_sum", "effects", "outline_effects"]
IMAGE_KEYS = ["name", "similarity", "support_vectors", "contribution"]


def test_json_has_the_documented_keys_in_order(document):
    assert list(document) == KEYS
    assert list(document["view"]) == ["size", "scale", "origin_px"]
    assert list(document["patch"]) == ["view_px", "side_px"]
    assert list(document["points"]) == ["left_px", "view_px", "effects"]
    assert all(list(window) == WINDOW_KEYS for window in document["windows"])
    assert list(document["nearest_images"]) == ["graspable", "not_graspable"]
    images = document["nearest_images"]["graspable"] + document["nearest_images"]["not_graspable"]
    assert images and all(list(image) == IMAGE_KEYS for image in images)
    text = (REPOSITORY / "docs" / "explain.md").read_text()
    for key in [*KEYS, *WINDOW_KEYS, *IMAGE_KEYS, "size", "scale", "origin_px", "view_px", "graspable"]:
        assert f"`{key}`" in text, key


def test_json_is_of_the_grasp_that_detect_finds(document, cli, mug_pair, trained_model):
    detected = json.loads(cli("detect", *mug_pair.arguments, "--model", trained_model, "--json", "-").stdout)
    best = detected["objects"][0]["grasps"][0]
    assert document["object"] == detected["objects"][0]["id"]
    for key in ("rank", "probability", "probability_left", "probability_right", "left_px"):
        assert document[key] == best[key]
    assert document["model"] == detected["model"]
    assert [window["side_px"] for window in document["windows"]] == [10, 30, 70]
    for window in document["windows"]:
        effects = np.array(window["effects"])
        assert effects.shape == (8, 5)
        outline = np.array(window["outline_effects"])
        assert outline.shape == (8, 5)
        assert effects.sum() + outline.sum() == pytest.approx(window["effect_sum"])
    points = document["points"]
    assert len(points["left_px"]) == len(points["view_px"]) == len(points["effects"]) <= 300
    names = {image["name"] for image in document["nearest_images"]["graspable"]}
    assert names <= {f"scene_{index:06d}" for index in range(12)}


def test_another_rank_another_explanation(explain, document):
    result = explain("--rank", 2, "--object", document["object"], "--json", "-")
    assert result.returncode == 0, result.stderr
    second = json.loads(result.stdout)
    assert second["rank"] == 2
    assert second["patch"]["view_px"] != document["patch"]["view_px"]


def test_the_summary_is_short_and_names_what_matters(explain, document):
    result = explain()
    assert result.returncode == 0 and result.stderr == ""
    lines = result.stdout.splitlines()
    assert len(lines) < 30 and max(map(len, lines)) < 110
    assert f"object {document['object']}, grasp 1 at" in lines[0]
    for image in document["nearest_images"]["graspable"]:
        assert image["name"] in result.stdout


def test_same_bytes_for_any_threads(explain, document):
    for threads in (1, 3):
        assert json.loads(explain("--threads", threads, "--json", "-").stdout) == document


def test_a_picture_with_the_training_images(explain, drawn_dataset, tmp_path):
    plain, drawn, file = tmp_path / "plain.png", tmp_path / "drawn.png", tmp_path / "why.json"
    result = explain("--picture", plain, "--json", file)
    assert result.returncode == 0, result.stderr
    assert result.stdout.startswith("object ") and json.loads(file.read_text())["rank"] == 1
    result = explain("--picture", drawn, "--training-data", drawn_dataset)
    assert result.returncode == 0, result.stderr
    with Image.open(plain) as without, Image.open(drawn) as pictured:
        assert pictured.height > without.height and pictured.width == without.width
        colours = np.asarray(pictured.convert("RGB")).reshape(-1, 3).astype(int)
    # Blue speaks for a grasping point, orange against: both are there.
    assert ((colours[:, 2] - colours[:, 0]) > 60).sum() > 300
    assert ((colours[:, 0] - colours[:, 2]) > 60).sum() > 300


def test_no_path_of_this_machine_gets_into_the_names(trained_model, drawn_dataset):
    data = trained_model.read_bytes()
    header = json.loads(data[8 : 8 + int.from_bytes(data[:8], "little")])
    begin, end = header["training_images"]["data_offsets"]
    start = len(data) - max(tensor["data_offsets"][1] for name, tensor in header.items() if name[0] != "_")
    names = data[start + begin : start + end].decode().splitlines()
    assert names == [f"scene_{index:06d}" for index in range(12)]


def test_a_model_that_does_not_know_its_images(explain, old_model):
    result = explain(model=old_model)
    assert result.returncode == 0, result.stderr
    assert "does not say which images" in result.stdout
    assert json.loads(explain("--json", "-", model=old_model).stdout)["nearest_images"] is None


def assert_refused(result, *words):
    assert result.returncode == 3
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 1
    assert all(word in result.stderr for word in words), result.stderr


def test_what_is_not_there_cannot_be_explained(explain, mug_pair, drawn_dataset, old_model, tmp_path):
    picture = tmp_path / "why.png"
    assert_refused(explain("--rank", 900, "--picture", picture), "left.png", "rank", "900")
    assert_refused(explain("--object", 200), "no object 200")
    empty = tmp_path / "empty.png"
    Image.fromarray(np.zeros((480, 640), np.uint8)).save(empty)
    assert_refused(explain("--mask", empty), "no object")
    assert_refused(
        explain("--picture", picture, "--training-data", drawn_dataset, model=old_model), "trained anew"
    )
    other = tmp_path / "other"
    other.mkdir()
    shutil.copy(drawn_dataset / "dataset.json", other)
    shutil.copytree(drawn_dataset / "scene_000000", other / "kitchen")
    assert_refused(explain("--picture", picture, "--training-data", other), "other", "scene_0")
    assert_refused(explain("--picture", picture, "--training-data", tmp_path / "none"), "none", "no such")
    assert not picture.exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ["--rank", "0"],
        ["--object", "0"],
        ["--object", "256"],
        ["--picture", "why.txt"],
        ["--training-data", "folder"],
        ["--max-grasps", "3"],
        ["--mask", "m.png", "--cues", "plane"],
    ],
)
def test_wrong_usage(explain, tmp_path, arguments):
    result = explain(*arguments, cwd=tmp_path)
    assert result.returncode == 2
    assert result.stdout == "" and result.stderr
    assert list(tmp_path.iterdir()) == []
