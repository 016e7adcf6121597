"""graspctx_cli: what each subcommand answers."""

import json
import os
import struct
import subprocess

import numpy as np
import pytest
from conftest import REPOSITORY, write_drawn_dataset

Image = pytest.importorskip("PIL.Image")

SUBCOMMANDS = [
    *["detect", "explain", "train", "evaluate", "segment", "describe"],
    *["models", "info", "export", "check"],
]


def succeed(result):
    assert result.returncode == 0, result.stderr
    return result.stdout


def without_timings(text):
    document = json.loads(text)
    del document["timings_ms"]
    return json.dumps(document)


@pytest.fixture(scope="module")
def detection(cli, mug_pair, trained_model):
    text = succeed(cli("detect", *mug_pair.arguments, "--model", trained_model, "--json", "-"))
    return json.loads(text)


# ---- usage ----


@pytest.mark.parametrize("subcommand", SUBCOMMANDS)
def test_help_explains_with_an_example(cli, subcommand):
    result = cli(subcommand, "--help")
    assert result.returncode == 0
    assert result.stderr == ""
    assert f"graspctx_cli {subcommand}" in result.stdout


def test_help_lists_every_subcommand(cli):
    text = succeed(cli("--help"))
    assert all(f"\n  {subcommand} " in text for subcommand in SUBCOMMANDS)


def test_version(cli):
    name, number = succeed(cli("--version")).split()
    assert name == "graspctx_cli"
    assert len([int(part) for part in number.split(".")]) == 3


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["grasp"],
        ["--no-such-option"],
        ["detect"],
        ["detect", "LEFT", "RIGHT"],
        ["detect", "LEFT", "--calibration", "CALIB"],
        ["detect", "LEFT", "RIGHT", "--calibration"],
        ["detect", "LEFT", "RIGHT", "third.png", "--calibration", "CALIB"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--cues", "smell"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--max-grasps", "0"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--max-grasps", "many"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--max-grasps", "99999999999999"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--min-familiarity", "1.5"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--threads", "0"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--threads", "-1"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--threads", "257"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--fixate", "5"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--fixate", "nan,3"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--mask", "m.png", "--cues", "plane"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--picture", "grasps.txt"],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--json"],
        ["segment", "LEFT", "RIGHT", "--calibration", "CALIB"],
        ["segment", "LEFT", "RIGHT", "--calibration", "CALIB", "--output", "mask.jpg"],
        ["segment", "LEFT", "RIGHT", "--calibration", "CALIB", "--picture", "scene.txt"],
        ["segment", "LEFT", "RIGHT", "--calibration", "CALIB", "--json"],
        *[
            ["segment", "LEFT", "RIGHT", "--calibration", "CALIB", "--json", "-", *words.split()]
            for words in (
                "--roi 1,2,3",
                "--roi 1,2,3,4,5",
                "--roi -1,2,3,4",
                "--roi 1.5,2,3,4",
                "--roi 1,2,3,99999999999",
                "--roi nan,2,3,4",
                "--gravity 0,1",
                "--gravity 0,inf,0",
                "--gravity x,y,z",
                "--table-plane 0,-1,0",
                "--table-plane 0,-1,0,nan",
                "--table-plane 0,-1,0,0.5 --gravity 0,1,0",
            )
        ],
        ["detect", "LEFT", "RIGHT", "--calibration", "CALIB", "--mask", "m.png", "--roi", "1,2,3,4"],
        ["train", "folder"],
        ["train", "--output", "m.safetensors"],
        ["train", "folder", "--output", "m.safetensors", "--seed", "x"],
        ["train", "folder", "--output", "m.safetensors", "--descriptor", "none"],
        ["train", "folder", "--output", "m.safetensors", "--report", "report.pdf"],
        ["evaluate", "folder", "--model", "mug", "--report", "report"],
        ["evaluate", "folder"],
        ["describe", "LEFT"],
        ["describe", "LEFT", "--output", "d.npy", "--fovea"],
        ["info"],
        ["info", "a", "b"],
        ["export", "mug"],
        ["models", "mug"],
        ["check"],
    ],
)
def test_wrong_usage(cli, mug_pair, tmp_path, arguments):
    names = {"LEFT": mug_pair.left, "RIGHT": mug_pair.right, "CALIB": mug_pair.calibration}
    result = cli(*[names.get(argument, argument) for argument in arguments], cwd=tmp_path)
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr
    assert list(tmp_path.iterdir()) == []


# ---- detect ----


def assert_unit(vector):
    assert np.linalg.norm(vector) == pytest.approx(1, abs=1e-6)


GRASP_KEYS = [
    *["rank", "probability", "probability_left", "probability_right", "left_px", "right_px"],
    *["position_m", "position_stddev_m", "rule", "approach", "closing", "cam_from_hand", "opening_m"],
    *["feasible", "infeasible_because"],
]
OBJECT_KEYS = ["id", "bounding_box_px", "centroid_px", "pose", "model", "familiarity", "unfamiliar", "grasps"]
POSE_KEYS = ["centroid_m", "major_axis_m", "minor_axis_m", "normal", "source"]
DOCUMENT_KEYS = ["schema", "graspctx", "frame", "image_size", "model", "table_plane", "objects", "timings_ms"]


def test_detection_json_has_the_documented_keys_in_order(detection):
    text = (REPOSITORY / "docs" / "detection-json.md").read_text()
    assert list(detection) == DOCUMENT_KEYS
    assert list(detection["model"]) == ["name", "sha256"]
    assert list(detection["table_plane"]) == ["normal", "offset_m"]
    for found in detection["objects"]:
        assert list(found) == OBJECT_KEYS
        assert found["pose"] is None or list(found["pose"]) == POSE_KEYS
        assert all(list(grasp) == GRASP_KEYS for grasp in found["grasps"])
    for key in DOCUMENT_KEYS + OBJECT_KEYS + POSE_KEYS + GRASP_KEYS:
        assert f"`{key}`" in text, key


def test_a_model_from_before_familiarity_answers_as_before(cli, mug_pair, old_model):
    found = json.loads(succeed(cli("detect", *mug_pair.arguments, "--model", old_model, "--json", "-")))
    assert found["objects"]
    keys = [key for key in OBJECT_KEYS if key not in ("model", "familiarity", "unfamiliar")]
    assert all(list(item) == keys for item in found["objects"])


def test_several_models_vote(cli, mug_pair, drawn_dataset, trained_model, tmp_path):
    """The second was taught with the descriptor of the paper, so it describes an object in another way."""
    other = tmp_path / "paper.safetensors"
    succeed(cli("train", drawn_dataset, "--output", other, "--descriptor", "paper"))
    names = f"{trained_model},{other}"
    words = ["detect", *mug_pair.arguments, "--model", names, "--min-familiarity"]
    every = json.loads(succeed(cli(*words, "0", "--json", "-")))
    assert every["model"]["name"] == "drawn,paper"
    assert [len(sha256) for sha256 in every["model"]["sha256"].split(",")] == [64, 64]
    for found in every["objects"]:
        assert found["model"] in ("drawn", "paper")
        assert 0 < found["familiarity"] <= 1 and found["unfamiliar"] is False
    assert any(found["grasps"] for found in every["objects"])
    picture = tmp_path / "grasps.png"
    table = succeed(cli(*words, "1", "--picture", picture, "--json", tmp_path / "all.json"))
    refused = json.loads((tmp_path / "all.json").read_text())["objects"]
    assert any(found["unfamiliar"] for found in refused)
    for found in refused:
        assert found["unfamiliar"] == (found["familiarity"] < 1)
        assert not found["unfamiliar"] or found["grasps"] == []
    assert "unfamiliar, most like what model" in table
    with Image.open(picture) as image:
        assert image.size[0] >= 640


def test_models_that_cannot_vote(cli, mug_pair, trained_model, old_model):
    result = cli("detect", *mug_pair.arguments, "--model", f"{trained_model},{old_model}")
    assert result.returncode == 3 and "'old' cannot tell what is familiar" in result.stderr
    result = cli("detect", *mug_pair.arguments, "--model", f"{trained_model},{trained_model}")
    assert result.returncode == 3 and "two models named 'drawn'" in result.stderr
    result = cli("detect", *mug_pair.arguments, "--model", f"{trained_model},none")
    assert result.returncode == 3 and "'none': no such file" in result.stderr


def test_detection_json_keeps_the_contract(detection, cli):
    assert detection["schema"] == 1
    assert detection["graspctx"] == succeed(cli("--version")).split()[1]
    assert detection["frame"] == "left_rectified_optical"
    assert detection["image_size"] == [640, 480]
    assert len(detection["model"]["sha256"]) == 64
    assert_unit(detection["table_plane"]["normal"])
    assert detection["objects"], "the bundled pair shows a mug"
    assert all(value >= 0 for value in detection["timings_ms"].values())
    best = []
    for found in detection["objects"]:
        assert all(isinstance(value, int) for value in found["bounding_box_px"])
        x, y, width, height = found["bounding_box_px"]
        u, v = found["centroid_px"]
        assert x <= u <= x + width and y <= v <= y + height
        if found["pose"]:
            assert_unit(found["pose"]["normal"])
            assert found["pose"]["source"] in ("stereo", "segment_depth")
        grasps = found["grasps"]
        assert [grasp["rank"] for grasp in grasps] == list(range(1, len(grasps) + 1))
        order = [(not grasp["feasible"], -grasp["probability"]) for grasp in grasps]
        assert order == sorted(order)
        best += order[:1]
    assert best == sorted(best), "the first object is the one with the best grasp"


def test_grasps_are_right_handed_and_consistent(detection):
    grasps = [grasp for found in detection["objects"] for grasp in found["grasps"]]
    assert grasps
    for grasp in grasps:
        cam_from_hand = np.array(grasp["cam_from_hand"])
        rotation = cam_from_hand[:3, :3]
        assert cam_from_hand[3].tolist() == [0, 0, 0, 1]
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-6)
        assert np.linalg.det(rotation) == pytest.approx(1, abs=1e-6)
        np.testing.assert_allclose(rotation[:, 0], grasp["closing"], atol=1e-9)
        np.testing.assert_allclose(rotation[:, 2], grasp["approach"], atol=1e-9)
        np.testing.assert_allclose(cam_from_hand[:3, 3], grasp["position_m"], atol=1e-9)
        product = grasp["probability_left"] * grasp["probability_right"]
        assert grasp["probability"] == pytest.approx(product, abs=1e-12)
        assert grasp["rule"] in ("plane_normal", "major_axis", "minor_axis")
        assert grasp["opening_m"] > 0
        assert grasp["feasible"] == (grasp["infeasible_because"] is None)


def test_same_bytes_for_any_threads_and_any_run(cli, mug_pair, trained_model, detection):
    for threads in (1, 2, 3):
        text = succeed(
            cli("detect", *mug_pair.arguments, "--model", trained_model, "--threads", threads, "--json", "-")
        )
        assert without_timings(text) == without_timings(json.dumps(detection))


def test_detection_does_not_depend_on_the_locale(cli, mug_pair, trained_model, detection):
    installed = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=True).stdout.split()
    if "de_DE.utf8" not in installed:
        pytest.skip("the locale de_DE.UTF-8, with a decimal comma, is not installed")
    text = succeed(
        cli(
            *["detect", *mug_pair.arguments, "--model", trained_model, "--json", "-"],
            env={**os.environ, "LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"},
        )
    )
    assert without_timings(text) == without_timings(json.dumps(detection))


def test_detect_prints_a_table_of_ranked_grasps(cli, mug_pair, trained_model, detection):
    lines = succeed(cli("detect", *mug_pair.arguments, "--model", trained_model)).splitlines()
    ranks = [int(line.split()[0]) for line in lines if line.split()[:1] and line.split()[0].isdigit()]
    assert ranks == [grasp["rank"] for found in detection["objects"] for grasp in found["grasps"]]


def test_detect_writes_json_and_picture_beside_the_table(cli, mug_pair, trained_model, tmp_path, detection):
    text = succeed(
        cli(
            *["detect", *mug_pair.arguments, "--model", trained_model],
            *["--json", tmp_path / "grasps.json", "--picture", tmp_path / "grasps.png"],
        )
    )
    assert "rank" in text
    assert without_timings((tmp_path / "grasps.json").read_text()) == without_timings(json.dumps(detection))
    with Image.open(tmp_path / "grasps.png") as picture:
        assert picture.mode == "RGB"
        assert np.asarray(picture).std() > 10
    assert len(list(tmp_path.iterdir())) == 2


def test_max_grasps_keeps_the_best(cli, mug_pair, trained_model, detection):
    text = succeed(
        cli("detect", *mug_pair.arguments, "--model", trained_model, "--max-grasps", 2, "--json", "-")
    )
    for few, all_of_them in zip(json.loads(text)["objects"], detection["objects"]):
        assert few["grasps"] == all_of_them["grasps"][:2]


def test_options_may_stand_before_the_images(cli, mug_pair, trained_model, detection):
    text = succeed(
        cli(
            *["detect", "--calibration", mug_pair.calibration, mug_pair.left, mug_pair.right],
            *["--json", "-", "--model", trained_model],
        )
    )
    assert without_timings(text) == without_timings(json.dumps(detection))


def test_own_mask_takes_the_place_of_the_segmentation(cli, mug_pair, trained_model, detection, tmp_path):
    x, y, width, height = detection["objects"][0]["bounding_box_px"]
    ids = np.zeros((480, 640), np.uint8)
    ids[y : y + height, x : x + width // 2] = 4
    ids[y : y + height, x + width // 2 : x + width] = 200
    Image.fromarray(ids).save(tmp_path / "mask.png")
    text = succeed(
        cli(
            *["detect", *mug_pair.arguments, "--model", trained_model],
            *["--mask", tmp_path / "mask.png", "--json", "-"],
        )
    )
    objects = {found["id"]: found for found in json.loads(text)["objects"]}
    assert set(objects) == {4, 200}
    assert objects[4]["bounding_box_px"] == [x, y, width // 2, height]


def test_nothing_found_is_an_answer(cli, mug_pair, trained_model, tmp_path):
    Image.fromarray(np.zeros((480, 640), np.uint8)).save(tmp_path / "mask.png")
    common = ["detect", *mug_pair.arguments, "--model", trained_model, "--mask", tmp_path / "mask.png"]
    assert json.loads(succeed(cli(*common, "--json", "-")))["objects"] == []
    assert succeed(cli(*common)) == "no object found\n"


def camera_info(side, *, distortion=0.0):
    camera = CALIBRATION
    shift = "0" if side == "left" else repr(-camera["focal"] * camera["baseline_m"])
    f, cx, cy = camera["focal"], camera["cx"], camera["cy"]
    return (
        f"image_width: {camera['width']}\nimage_height: {camera['height']}\ncamera_name: {side}\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{f}, 0, {cx}, 0, {f}, {cy}, 0, 0, 1]\n"
        f"distortion_model: plumb_bob\n"
        f"distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{distortion}, 0, 0, 0, 0]\n"
        f"rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
        f"projection_matrix:\n  rows: 3\n  cols: 4\n"
        f"  data: [{f}, 0, {cx}, {shift}, 0, {f}, {cy}, 0, 0, 0, 1, 0]\n"
    )


CALIBRATION = {}


@pytest.fixture(autouse=True, scope="module")
def _read_calibration(mug_pair):
    entries = dict(line.split("=") for line in mug_pair.calibration.read_text().split("\n") if line)
    matrix = [float(word) for word in entries["cam0"].strip("[]").replace(";", " ").split()]
    CALIBRATION.update(
        focal=matrix[0],
        cx=matrix[2],
        cy=matrix[5],
        baseline_m=float(entries["baseline"]) / 1000,
        width=int(entries["width"]),
        height=int(entries["height"]),
    )


def test_camera_info_pair_is_the_same_camera(cli, mug_pair, trained_model, detection, tmp_path):
    for side in ("left", "right"):
        (tmp_path / f"{side}.yaml").write_text(camera_info(side))
    files = [tmp_path / "left.yaml", tmp_path / "right.yaml"]
    rest = ["--model", trained_model, "--json", "-"]
    text = succeed(cli("detect", mug_pair.left, mug_pair.right, "--calibration", *files, *rest))
    before = succeed(cli("detect", "--calibration", *files, mug_pair.left, mug_pair.right, *rest))
    assert without_timings(text) == without_timings(before)
    for ours, theirs in zip(json.loads(text)["objects"], detection["objects"]):
        assert ours["bounding_box_px"] == theirs["bounding_box_px"]
        np.testing.assert_allclose(
            [grasp["position_m"] for grasp in ours["grasps"]],
            [grasp["position_m"] for grasp in theirs["grasps"]],
            atol=1e-6,
        )


def test_rectified_flag_leaves_the_images_alone(cli, mug_pair, trained_model, detection, tmp_path):
    for side in ("left", "right"):
        (tmp_path / f"{side}.yml").write_text(camera_info(side, distortion=-0.2))
    common = ["detect", mug_pair.left, mug_pair.right]
    common += ["--calibration", tmp_path / "left.yml", tmp_path / "right.yml", "--model", trained_model]
    rectified = json.loads(succeed(cli(*common, "--rectified", "--json", "-")))
    raw = json.loads(succeed(cli(*common, "--json", "-")))
    boxes = [found["bounding_box_px"] for found in detection["objects"]]
    assert [found["bounding_box_px"] for found in rectified["objects"]] == boxes
    assert [found["bounding_box_px"] for found in raw["objects"]] != boxes


def test_fixation_looks_at_one_object(cli, mug_pair, trained_model, detection):
    u, v = detection["objects"][0]["centroid_px"]
    common = ["detect", *mug_pair.arguments, "--model", trained_model, "--json", "-"]
    objects = json.loads(succeed(cli(*common, "--fixate", f"{u:.0f},{v:.0f}")))["objects"]
    assert len(objects) == 1
    x, y, width, height = objects[0]["bounding_box_px"]
    assert x <= u <= x + width and y <= v <= y + height


@pytest.mark.parametrize("name", ["art", "laundry", "reindeer", "adirondack", "motorcycle"])
def test_real_pairs_are_answered(cli, shared_data, trained_model, name):
    folder = shared_data / "stereo" / name
    arguments = [folder / "left.png", folder / "right.png", "--calibration", folder / "calib.txt"]
    found = json.loads(succeed(cli("detect", *arguments, "--model", trained_model, "--json", "-")))
    with Image.open(folder / "left.png") as image:
        assert found["image_size"] == list(image.size)
    assert found["graspctx"]


# ---- segment, describe ----


def test_segment_writes_instance_ids(cli, mug_pair, detection, tmp_path):
    text = succeed(cli("segment", *mug_pair.arguments, "--output", tmp_path / "mask.png"))
    with Image.open(tmp_path / "mask.png") as picture:
        assert picture.mode == "L"
        ids = np.asarray(picture)
    assert ids.shape == (480, 640)
    found = {item["id"]: item["bounding_box_px"] for item in detection["objects"]}
    assert set(np.unique(ids)) - {0} == set(found)
    printed = [[int(word) for word in line.split()[:5]] for line in text.splitlines()[1:]]
    assert {row[0]: row[1:] for row in printed} == found


SEGMENTED_KEYS = [
    *["id", "bounding_box_px", "centroid_px", "saliency", "touches_border", "leaves_table", "size_m"],
    "depth_m",
]
SEGMENTATION_KEYS = [
    *["schema", "graspctx", "frame", "image_size", "cues", "table_plane", "objects"],
    *["vertical_offset_px", "warnings", "timings_ms"],
]


def test_segmentation_json_is_as_documented(cli, mug_pair, detection, tmp_path):
    arguments = ["segment", *mug_pair.arguments, "--output", tmp_path / "mask.png"]
    text = succeed(cli(*arguments, "--json", "-"))
    found = json.loads(text)
    documented = (REPOSITORY / "docs" / "segmentation-json.md").read_text()
    assert list(found) == SEGMENTATION_KEYS
    assert all(list(item) == SEGMENTED_KEYS for item in found["objects"])
    for key in SEGMENTATION_KEYS + SEGMENTED_KEYS:
        assert f"`{key}`" in documented, key
    assert found["schema"] == 1 and found["cues"] == "colour" and found["warnings"] == []
    assert found["image_size"] == [640, 480]
    assert found["table_plane"] == detection["table_plane"]
    assert abs(found["vertical_offset_px"]) < 0.3
    assert list(found["timings_ms"]) == ["rectify", "disparity", "segmentation"]
    ids = np.asarray(Image.open(tmp_path / "mask.png"))
    assert found["objects"], "the bundled pair shows a mug"
    for item in found["objects"]:
        v, u = np.nonzero(ids == item["id"])
        x, y, width, height = item["bounding_box_px"]
        assert [u.min(), v.min(), u.max() + 1, v.max() + 1] == [x, y, x + width, y + height]
        np.testing.assert_allclose(item["centroid_px"], [u.mean(), v.mean()], atol=1e-9)
        length, across, tall = item["size_m"]
        assert 0.02 < across <= length < 0.3 and 0.02 < tall < 0.3
        assert 0.3 < item["depth_m"] < 1
    succeed(cli(*arguments, "--json", tmp_path / "found.json", "--threads", 4))
    assert without_timings((tmp_path / "found.json").read_text()) == without_timings(text)


def test_no_object_is_an_answer_of_segment(cli, tmp_path):
    Image.fromarray(np.full((240, 320, 3), 128, np.uint8)).save(tmp_path / "plain.png")
    calibration = tmp_path / "calib.txt"
    calibration.write_text(
        "cam0=[300 0 160; 0 300 120; 0 0 1]\ncam1=[300 0 160; 0 300 120; 0 0 1]\n"
        "doffs=0\nbaseline=80\nwidth=320\nheight=240\n"
    )
    views = [tmp_path / "plain.png", tmp_path / "plain.png", "--calibration", calibration]
    outputs = ["--json", "-", "--picture", tmp_path / "scene.png", "--output", tmp_path / "mask.png"]
    result = cli("segment", *views, *outputs)
    found = json.loads(succeed(result))
    assert found["objects"] == [] and found["table_plane"] is None
    assert found["warnings"] and all(warning in result.stderr for warning in found["warnings"])
    assert not np.asarray(Image.open(tmp_path / "mask.png")).any()
    assert Image.open(tmp_path / "scene.png").size[0] > 2000


def test_badly_rectified_views_are_warned_about(cli, mug_pair, tmp_path):
    with Image.open(mug_pair.right) as image:
        right = np.roll(np.asarray(image), 3, axis=0)
    Image.fromarray(right).save(tmp_path / "lower.png")
    views = [mug_pair.left, tmp_path / "lower.png", "--calibration", mug_pair.calibration]
    result = cli("segment", *views, "--json", "-")
    found = json.loads(succeed(result))
    assert found["vertical_offset_px"] == pytest.approx(3, abs=0.3)
    assert any("px" in warning for warning in found["warnings"])
    assert all(warning in result.stderr for warning in found["warnings"])


def test_picture_of_a_segmentation(cli, mug_pair, tmp_path):
    common = ["segment", *mug_pair.arguments]
    assert succeed(cli(*common, "--picture", tmp_path / "one.png")).startswith("id ")
    succeed(cli(*common, "--picture", tmp_path / "two.png", "--threads", 4))
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
    succeed(cli(*common, "--picture", tmp_path / "small.jpg", "--cues", "plane"))
    with Image.open(tmp_path / "one.png") as picture, Image.open(tmp_path / "small.jpg") as other:
        assert picture.mode == "RGB" and picture.size == other.size
        assert picture.size[0] > 4 * 640 and picture.size[1] > 2 * 480


def test_what_is_known_of_the_rig(cli, mug_pair, trained_model):
    """The table that was found, or the direction that it says is down, gives the same objects again."""
    for command in (["segment"], ["detect", "--model", trained_model]):
        common = [*command, *mug_pair.arguments, "--json", "-"]
        found = json.loads(succeed(cli(*common)))
        (mug,) = found["objects"]
        normal = np.array(found["table_plane"]["normal"])
        table = ",".join(map(str, [*normal, found["table_plane"]["offset_m"]]))
        down = ",".join(map(str, -9.81 * normal))
        x, y, width, height = mug["bounding_box_px"]
        roi = f"{x - 9},{y - 9},{width + 18},{height + 18}"
        for option, value in (("--table-plane", table), ("--gravity", down), ("--roi", roi)):
            again = json.loads(succeed(cli(*common, f"{option}={value}")))
            np.testing.assert_allclose(again["table_plane"]["normal"], normal, atol=0.01, err_msg=option)
            assert len(again["objects"]) == 1, option
            np.testing.assert_allclose(
                again["objects"][0]["bounding_box_px"], mug["bounding_box_px"], atol=12, err_msg=option
            )
        # A word that starts with a minus is a value, too.
        sideways = json.loads(succeed(cli(*common, "--gravity", "-1,0,0")))
        assert sideways["table_plane"] is None


def test_more_threads_than_processors_are_no_news(cli, mug_pair, tmp_path):
    result = cli("segment", *mug_pair.arguments, "--output", tmp_path / "mask.png", "--threads", 256)
    succeed(result)
    assert result.stderr == ""


@pytest.mark.parametrize("cues", ["disparity", "plane", "colour"])
def test_segment_takes_every_cue_level(cli, mug_pair, tmp_path, cues):
    succeed(cli("segment", *mug_pair.arguments, "--output", tmp_path / "mask.png", "--cues", cues))
    assert np.asarray(Image.open(tmp_path / "mask.png")).shape == (480, 640)


def test_descriptors_are_three_square_rooted_distributions(cli, drawn_dataset, tmp_path):
    scene = drawn_dataset / "scene_000000"
    for extra in ([], ["--mask", scene / "left_mask.png"], ["--mask", scene / "left_mask.png", "--fovea"]):
        output = tmp_path / "descriptors.npy"
        assert succeed(cli("describe", scene / "left.png", *extra, "--output", output)) == ""
        descriptors = np.load(output)
        assert descriptors.dtype == np.float32
        assert descriptors.shape[0] > 20 and descriptors.shape[1] == 120
        # Each scale is the square root of an L1-normalised histogram, so its squares sum to one.
        sums = (descriptors.reshape(-1, 3, 40).astype(float) ** 2).sum(axis=2)
        np.testing.assert_allclose(sums, 1, atol=1e-5)


def test_an_image_without_a_contour_has_no_descriptors(cli, tmp_path):
    Image.fromarray(np.full((60, 80, 3), 128, np.uint8)).save(tmp_path / "plain.png")
    succeed(cli("describe", tmp_path / "plain.png", "--output", tmp_path / "plain.npy"))
    assert np.load(tmp_path / "plain.npy").shape == (0, 120)


def test_the_kind_of_png_makes_no_difference(cli, drawn_dataset, tmp_path):
    colour = (
        Image.open(drawn_dataset / "scene_000000" / "left.png").convert("RGB").quantize(64).convert("RGB")
    )
    grey = colour.convert("L")
    kinds = {
        "colour": [colour, colour.convert("RGBA"), colour.quantize(256)],
        "grey": [grey, grey.convert("LA"), Image.fromarray(np.asarray(grey).astype(np.uint16) * 257)],
    }
    for name, images in kinds.items():
        results = []
        for index, image in enumerate(images):
            file = tmp_path / f"{name}{index}.png"
            image.save(file)
            succeed(cli("describe", file, "--output", file.with_suffix(".npy")))
            results.append(file.with_suffix(".npy").read_bytes())
        assert len(set(results)) == 1, name


# ---- train, evaluate, models ----


def read_safetensors(file):
    """Metadata and tensors, by the format's own definition."""
    data = file.read_bytes()
    (size,) = struct.unpack_from("<Q", data)
    header = json.loads(data[8 : 8 + size])
    types = {"F32": "<f4", "F64": "<f8", "I32": "<i4", "U8": "u1"}
    tensors = {}
    for name, entry in header.items():
        if name != "__metadata__":
            begin, end = entry["data_offsets"]
            raw = data[8 + size + begin : 8 + size + end]
            tensors[name] = np.frombuffer(raw, types[entry["dtype"]]).reshape(entry["shape"])
    return header["__metadata__"], tensors


def test_training_gives_the_same_bytes_again(cli, drawn_dataset, trained_model, tmp_path):
    again = tmp_path / trained_model.name
    result = cli("train", drawn_dataset, "--output", again, cwd=tmp_path)
    assert succeed(result) == ""
    assert result.stderr == "", "progress belongs on a terminal"
    metadata, tensors = read_safetensors(trained_model)
    metadata_again, tensors_again = read_safetensors(again)
    assert tensors.keys() == tensors_again.keys()
    for name, tensor in tensors.items():
        np.testing.assert_array_equal(tensor, tensors_again[name], err_msg=name)
    differing = {key for key in metadata if metadata[key] != metadata_again[key]}
    assert differing == {"provenance.command"}, "the output's path is all that differs"


def test_info_tells_where_a_model_comes_from(cli, drawn_dataset, trained_model, tmp_path):
    facts = json.loads(succeed(cli("info", trained_model, "--json", "-")))
    assert facts["model"]["name"] == "drawn"
    assert facts["classes"] == ["mug"]
    command = facts["provenance"]["command"]
    assert command == f"graspctx_cli train {drawn_dataset} --output {trained_model}"
    assert facts["provenance"]["views"] == "24"
    _, tensors = read_safetensors(trained_model)
    assert facts["svm"]["support_vectors"] in {tensor.shape[0] for tensor in tensors.values()}
    text = succeed(cli("info", trained_model))
    assert "classes: mug" in text and command in text
    succeed(cli("info", trained_model, "--json", tmp_path / "info.json"))
    assert json.loads((tmp_path / "info.json").read_text()) == facts


def test_a_model_is_of_the_robust_descriptor_or_of_the_paper_s(cli, drawn_dataset, trained_model, tmp_path):
    facts = json.loads(succeed(cli("info", trained_model, "--json", "-")))
    assert facts["descriptor"]["outline_px"] == 3 and facts["descriptor"]["refine_mask"]
    assert facts["svm"]["dimension"] == 240
    output = tmp_path / "m.safetensors"
    succeed(cli("train", drawn_dataset, "--output", output, "--descriptor", "paper"))
    facts = json.loads(succeed(cli("info", output, "--json", "-")))
    assert facts["descriptor"]["outline_px"] == 0 and not facts["descriptor"]["refine_mask"]
    assert facts["svm"]["dimension"] == 120
    assert facts["provenance"]["command"].endswith(" --descriptor paper")


def test_name_and_classes_are_the_callers(cli, drawn_dataset, tmp_path):
    output = tmp_path / "m.safetensors"
    arguments = ["--output", output, "--name", "handles", "--classes", "cup,mug"]
    succeed(cli("train", drawn_dataset, *arguments))
    facts = json.loads(succeed(cli("info", output, "--json", "-")))
    assert facts["model"]["name"] == "handles"
    assert facts["classes"] == ["mug"]


def test_a_model_finds_the_handles_of_other_mugs(cli, trained_model, tmp_path):
    write_drawn_dataset(tmp_path / "others", scenes=6, seed=77)
    text = succeed(cli("evaluate", tmp_path / "others", "--model", trained_model, "--json", "-"))
    (row,) = json.loads(text)["classes"]
    assert row["class"] == "mug" and row["views"] == 12
    assert 0 < row["label_prior"] < 0.5
    assert row["ap"] > 2 * row["label_prior"]
    assert row["auc"] > 0.8
    assert row["top1"] >= 0.75 > row["chance"]
    assert row["top1_low"] <= row["top1"] <= row["top1_high"]
    table = succeed(cli("evaluate", tmp_path / "others", "--model", trained_model))
    assert "mug" in table and f"{row['ap']:.3f}" in table


def test_export_holds_the_same_numbers(cli, trained_model, tmp_path):
    assert succeed(cli("export", trained_model, "--libsvm", tmp_path / "out.model")) == ""
    header, vectors = (tmp_path / "out.model").read_text().split("SV\n")
    entries = {line.split()[0]: line.split()[1:] for line in header.strip().split("\n")}
    facts = json.loads(succeed(cli("info", trained_model, "--json", "-")))["svm"]
    assert entries["kernel_type"] == ["rbf"]
    assert float(entries["gamma"][0]) == facts["gamma"]
    assert float(entries["rho"][0]) == facts["rho"]
    assert float(entries["probA"][0]) == facts["sigmoid_a"]
    assert int(entries["total_sv"][0]) == facts["support_vectors"] == len(vectors.strip().split("\n"))
    _, tensors = read_safetensors(trained_model)
    coefficients = [float(line.split()[0]) for line in vectors.strip().split("\n")]
    stored = next(t for t in tensors.values() if t.shape == (facts["support_vectors"],))
    np.testing.assert_allclose(coefficients, stored, rtol=1e-6)
    limits = (tmp_path / "out.model.range").read_text().strip().split("\n")
    assert limits[0] == "x" and len(limits) == 2 + facts["dimension"]


def test_models_lists_what_info_can_show(cli):
    lines = succeed(cli("models")).splitlines()
    names = [line.split()[0] for line in lines[1:]]
    assert {"mug", "pencil", "wineglass", "bowl", "eraser", "box", "book"} <= set(names)
    for name in names:
        facts = json.loads(succeed(cli("info", name, "--json", "-")))
        assert facts["svm"]["dimension"] == 240


def test_check_finds_nothing_wrong(cli, drawn_dataset):
    result = succeed(cli("check", drawn_dataset))
    assert result.startswith(f"{drawn_dataset}: sound, layout graspctx, 12 scenes, 24 images\n")


def test_progress_is_shown_on_a_terminal(cli_path, drawn_dataset, tmp_path):
    pty = pytest.importorskip("pty")
    master, slave = pty.openpty()
    command = [cli_path, "train", drawn_dataset, "--output", tmp_path / "m.safetensors"]
    with subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=slave) as process:
        os.close(slave)
        shown = b""
        while True:
            try:
                block = os.read(master, 4096)
            except OSError:  # the terminal is gone with the program
                break
            if not block:
                break
            shown += block
        assert process.stdout.read() == b""
    os.close(master)
    assert process.returncode == 0
    assert b"%" in shown and b"describing the views" in shown
