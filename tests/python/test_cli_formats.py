"""Data sets as other tools write them, and `check` on broken ones.

The drawn mugs of conftest.py are converted into each layout, by what the layouts' own documents say.
"""

import json
import re
import shutil

import numpy as np
import pytest
from conftest import write_drawn_dataset

hypothesis = pytest.importorskip("hypothesis")
Image = pytest.importorskip("PIL.Image")

FUZZ = hypothesis.settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(hypothesis.HealthCheck),
)
LABELS = ["--object-label", "mug", "--grasp-label", "handle"]


def load(file):
    with Image.open(file) as image:
        return np.array(image)


def save(file, array):
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(array).save(file)


# ---- from the project's layout into the others ----


def pictures(dataset):
    """Name, image, mask and label of each left view."""
    for scene in sorted(dataset.glob("scene_*")):
        yield (
            scene.name,
            load(scene / "left.png"),
            load(scene / "left_mask.png") > 0,
            load(scene / "left_label.png") > 0,
        )


def outline(mask):
    """A polygon around each row's run of pixels: up the left side, down the right. For regions without holes
    in their rows; what is between the outermost pixels of a row is filled.
    """
    rows = np.flatnonzero(mask.any(axis=1))
    left, right = [], []
    for v in rows:
        columns = np.flatnonzero(mask[v])
        left += [[int(columns[0]), int(v)], [int(columns[0]), int(v) + 1]]
        right += [[int(columns[-1]) + 1, int(v)], [int(columns[-1]) + 1, int(v) + 1]]
    return left + right[::-1]


def filled(mask):
    """What outline() covers."""
    result = np.zeros_like(mask)
    for v in np.flatnonzero(mask.any(axis=1)):
        columns = np.flatnonzero(mask[v])
        result[v, columns[0] : columns[-1] + 1] = True
    return result


def runs(mask):
    """COCO's uncompressed runs: down the columns, first those outside."""
    pixels = np.concatenate([[False], mask.T.reshape(-1), [not mask[-1, -1]]])
    changes = np.flatnonzero(pixels[1:] != pixels[:-1])
    return np.diff(np.concatenate([[0], changes])).tolist()


def write_saxena(dataset, folder):
    for name, image, mask, label in pictures(dataset):
        plain = np.where(mask[..., None], image, np.uint8(235))  # a plain, light background
        save(folder / "img" / f"{name}.png", plain.astype(np.uint8))
        coloured = np.zeros_like(image)
        coloured[label] = [0, 40, 255]
        save(folder / "grasp" / f"graspPriorityWidth_{name}.png", coloured)


def write_labelme(dataset, folder):
    for name, image, mask, label in pictures(dataset):
        save(folder / f"{name}.png", image)
        shapes = [
            {"label": text, "points": outline(region), "group_id": None, "shape_type": "polygon", "flags": {}}
            for text, region in (("mug", mask), ("handle", label))
        ]
        height, width = mask.shape
        document = {"version": "5.2.1", "flags": {}, "shapes": shapes, "imagePath": f"{name}.png"}
        document.update(imageData=None, imageHeight=height, imageWidth=width)
        (folder / f"{name}.json").write_text(json.dumps(document))


def write_coco(dataset, folder, encode=runs):
    document = {"images": [], "annotations": [], "categories": []}
    for index, text in enumerate(("mug", "handle"), 1):
        document["categories"].append({"id": index, "name": text, "supercategory": ""})
    for number, (name, image, mask, label) in enumerate(pictures(dataset), 1):
        height, width = mask.shape
        save(folder / "images" / f"{name}.png", image)
        document["images"].append(
            {"id": number, "file_name": f"{name}.png", "width": width, "height": height}
        )
        for category, region in ((1, mask), (2, label)):
            document["annotations"].append(
                {
                    "id": len(document["annotations"]) + 1,
                    "image_id": number,
                    "category_id": category,
                    "iscrowd": 1,
                    "segmentation": {"size": [height, width], "counts": encode(region)},
                }
            )
    (folder / "annotations").mkdir(parents=True)
    (folder / "annotations" / "instances_default.json").write_text(json.dumps(document))


WRITERS = {"saxena": write_saxena, "labelme": write_labelme, "coco": write_coco}


def label_options(layout):
    return [] if layout == "saxena" else LABELS


@pytest.fixture(scope="module")
def converted(drawn_dataset, tmp_path_factory):
    """The drawn mugs in each of the layouts."""
    folders = {}
    for layout, write in WRITERS.items():
        folders[layout] = tmp_path_factory.mktemp("converted") / layout
        folders[layout].mkdir()
        write(drawn_dataset, folders[layout])
    return folders


def summary_row(text, class_name):
    line = next(line for line in text.splitlines() if line.split()[:1] == [class_name])
    return [int(word) for word in line.split()[1:]]


def one_class(result):
    assert result.returncode == 0, result.stderr
    (row,) = json.loads(result.stdout)["classes"]
    return row


@pytest.mark.parametrize("layout", WRITERS)
def test_check_train_and_evaluate(cli, converted, drawn_dataset, trained_model, tmp_path, layout):
    folder, options = converted[layout], label_options(layout)
    checked = cli("check", folder, *options)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert checked.stdout.startswith(f"{folder}: sound, layout {layout}, 12 images\n")

    # The pixels are those that were written.
    regions = list(pictures(drawn_dataset))
    shape = filled if layout == "labelme" else (lambda mask: mask)
    object_px = sum(int(shape(mask).sum()) for _, _, mask, _ in regions)
    label_px = sum(int((shape(label) & shape(mask)).sum()) for _, _, mask, label in regions)
    name = "object" if layout == "saxena" else "mug"
    found = summary_row(checked.stdout, name)
    assert found[:3] == [12, 12, 0]
    if layout == "saxena":  # the masks are found, not written
        assert found[3] == pytest.approx(object_px, rel=0.03)
        assert found[4] == pytest.approx(label_px, rel=0.05)
    else:
        assert found[3:] == [object_px, label_px]

    model = tmp_path / "own.safetensors"
    trained = cli("train", folder, "--output", model, *options)
    assert trained.returncode == 0, trained.stderr
    facts = json.loads(cli("info", model, "--json", "-").stdout)
    assert facts["classes"] == [name]
    assert facts["provenance"]["dataset_format"] == layout
    assert all(option in facts["provenance"]["command"] for option in options)

    row = one_class(cli("evaluate", folder, "--model", model, "--json", "-", *options))
    assert row["class"] == name and row["views"] == 12
    assert row["ap"] > 0.8 > 2 * row["label_prior"]  # it was trained on them
    # A model that was trained on the project's own layout finds the handles here, too.
    other = one_class(cli("evaluate", folder, "--model", trained_model, "--json", "-", *options))
    assert other["ap"] > 2 * other["label_prior"]


def test_polygons_and_runs_say_the_same(cli, drawn_dataset, converted, trained_model, tmp_path):
    write_coco(drawn_dataset, tmp_path / "coco", encode=lambda mask: runs(filled(mask)))
    arguments = ["--model", trained_model, "--json", "-", *LABELS]
    row = one_class(cli("evaluate", tmp_path / "coco", *arguments))
    assert row == one_class(cli("evaluate", converted["labelme"], *arguments))


def test_compressed_runs(cli, drawn_dataset, converted, trained_model, tmp_path):
    coder = pytest.importorskip("pycocotools.mask")

    def compressed(mask):
        return coder.encode(np.asfortranarray(mask.astype(np.uint8)))["counts"].decode()

    write_coco(drawn_dataset, tmp_path / "coco", encode=compressed)
    arguments = ["--model", trained_model, "--json", "-", *LABELS]
    row = one_class(cli("evaluate", tmp_path / "coco", *arguments))
    assert row == one_class(cli("evaluate", converted["coco"], *arguments))


def assert_refused(result, *parts):
    assert result.returncode == 3, (result.stdout, result.stderr)
    assert len(result.stderr.splitlines()) == 1
    for part in parts:
        assert str(part) in result.stderr, result.stderr


def test_labels(cli, converted, trained_model):
    for layout in ("labelme", "coco"):
        folder = converted[layout]
        listed = cli("check", folder)
        assert listed.returncode == 0, listed.stderr
        assert "handle        12\nmug           12\n" in listed.stdout
        arguments = ["evaluate", folder, "--model", trained_model]
        assert_refused(cli(*arguments), folder, "--object-label", "handle, mug")
        assert_refused(cli(*arguments, "--object-label", "mug"), folder, "--grasp-label")
        wrong = ["--object-label", "cup", "--grasp-label", "handle"]
        assert_refused(cli(*arguments, *wrong), folder, "'cup'", "handle, mug")
    assert_refused(cli("check", converted["saxena"], *LABELS), converted["saxena"], "--object-label")


def test_format_can_be_forced(cli, converted, tmp_path):
    folder = tmp_path / "both"
    shutil.copytree(converted["labelme"], folder)
    shutil.copytree(converted["coco"], folder, dirs_exist_ok=True)
    assert_refused(cli("check", folder), folder, "--format")
    for layout in ("labelme", "coco"):
        assert f"layout {layout}" in cli("check", folder, "--format", layout, *LABELS).stdout
    assert cli("check", folder, "--format", "yolo").returncode == 2
    assert_refused(cli("check", folder, "--format", "saxena"), folder / "img")
    assert_refused(cli("check", folder, "--format", "graspctx"), folder / "dataset.json")


@pytest.mark.parametrize("orientation", [1, 3, 6])
def test_photographs_that_are_stored_turned(cli, converted, tmp_path, orientation):
    shutil.copytree(converted["labelme"], tmp_path / "set")
    name = "scene_000003"
    file = tmp_path / "set" / f"{name}.jpg"
    with Image.open(tmp_path / "set" / f"{name}.png") as image:
        exif = image.getexif()
        exif[0x010F] = "a camera"
        exif[0x0112] = orientation
        image.save(file, exif=exif)
    document = tmp_path / "set" / f"{name}.json"
    document.write_text(document.read_text().replace(f"{name}.png", f"{name}.jpg"))
    result = cli("check", tmp_path / "set", *LABELS)
    if orientation == 1:
        assert result.returncode == 0, result.stdout
    else:
        assert_refused(result, file, f"EXIF orientation {orientation}")


@FUZZ
@hypothesis.given(data=hypothesis.strategies.data())
def test_fuzzed_annotations(cli, converted, trained_model, data):
    """Bytes changed, and values replaced by what no tool writes: refused in one line, or read."""
    layout = data.draw(hypothesis.strategies.sampled_from(["labelme", "coco"]))
    relative = {"labelme": "scene_000000.json", "coco": "annotations/instances_default.json"}[layout]
    file = converted[layout] / relative
    sound = file.read_text()
    text = sound
    for _ in range(data.draw(hypothesis.strategies.integers(1, 3))):
        numbers = [match.span() for match in re.finditer(r"-?\d+|null|\"[^\"]*\"", text)]
        start, end = data.draw(hypothesis.strategies.sampled_from(numbers))
        odd = [
            "-1",
            "1e308",
            "0.5",
            "18446744073709551615",
            "null",
            "[]",
            "{}",
            '"\\u0000"',
            "[[[]]]",
            "x",
            "",
        ]
        text = text[:start] + data.draw(hypothesis.strategies.sampled_from(odd)) + text[end:]
    try:
        file.write_text(text)
        arguments = ["--model", trained_model, "--json", "-", "--format", layout, *LABELS]
        result = cli("evaluate", converted[layout], *arguments)
    finally:
        file.write_text(sound)
    if result.returncode != 0:
        assert_refused(result, converted[layout])
        assert result.stdout == ""


def test_help_shows_how(cli):
    for command in ("train", "evaluate", "check"):
        text = cli(command, "--help").stdout
        assert "--grasp-label handle" in text and "Saxena" in text and "COCO" in text


# ---- check: what can be wrong with the project's own layout ----


@pytest.fixture
def dataset(tmp_path):
    """Two scenes with everything that docs/dataset-format.md allows, sound."""
    folder = tmp_path / "set"
    write_drawn_dataset(folder, scenes=2, seed=5)
    for index, scene in enumerate(sorted(folder.glob("scene_*"))):
        size = load(scene / "left.png").shape[1::-1]
        counts = {"visible_px": {}, "label_px": {}}
        for side in ("left", "right"):
            counts["visible_px"][side] = int((load(scene / f"{side}_mask.png") > 0).sum())
            counts["label_px"][side] = int((load(scene / f"{side}_label.png") > 0).sum())
        down = 0.6  # the camera looks down at the table by its sine
        table = [[1, 0, 0, 0], [0, -down, -0.8, 0.1], [0, 0.8, -down, 0.6], [0, 0, 0, 1]]
        normal, origin = np.array(table)[:3, 2], np.array(table)[:3, 3]
        scene_json = {
            "schema": 1,
            "seed": 5,
            "index": index,
            "image_size": list(size),
            "camera": {
                "focal_px": 300.0,
                "centre_px": [size[0] / 2, size[1] / 2],
                "baseline_m": 0.08,
                "doffs_px": 0.0,
            },
            "cam_from_table": table,
            "table_plane": {"normal": normal.tolist(), "offset_m": float(-normal @ origin)},
            "axes": {
                "table": "faint" if index else "textured",
                "occluded": False,
                "noise": 1.5 + index,
                "objects": 1,
            },
            "objects": [{"id": 1, "family": "mug", "cam_from_object": table, **counts}],
        }
        (scene / "scene.json").write_text(json.dumps(scene_json))
        shutil.copy(scene / "left_depth.png", scene / "right_depth.png")
    return folder


def test_a_sound_data_set(cli, dataset):
    result = cli("check", dataset)
    assert result.returncode == 0, result.stdout
    assert result.stdout.startswith(f"{dataset}: sound, layout graspctx, 2 scenes, 4 images\n")
    label_px = sum(int((load(file) > 0).sum()) for file in dataset.glob("*/*_label.png"))
    object_px = sum(int((load(file) > 0).sum()) for file in dataset.glob("*/*_mask.png"))
    assert summary_row(result.stdout, "mug") == [2, 4, 0, object_px, label_px]
    axes = [line.split() for line in result.stdout.splitlines()]
    for row in (
        "table faint 1",
        "table textured 1",
        "occluded false 2",
        "noise 1.5 to 2.5 2",
        "objects 1 to 1 2",
    ):
        assert row.split() in axes


def test_a_mesh_has_its_checksum_in_the_header(cli, dataset):
    replaced('["mug"]', '["pan@64cd", "mug@6d01"]')(dataset / "dataset.json")
    assert cli("check", dataset).returncode == 0


def edited_scene(edit):
    def damage(file):
        scene = json.loads(file.read_text())
        edit(scene)
        file.write_text(json.dumps(scene))

    return damage


def edited_object(**entries):
    return edited_scene(lambda scene: scene["objects"][0].update(entries))


def edited_pose(row, column, value):
    def edit(scene):
        scene["objects"][0]["cam_from_object"][row][column] = value

    return edited_scene(edit)


def edited_pixels(edit):
    def damage(file):
        pixels = load(file)
        save(file, edit(pixels))

    return damage


def with_patch(value):
    def edit(pixels):
        pixels[:3, :3] = value
        return pixels

    return edited_pixels(edit)


def removed(file):
    file.unlink()


def truncated(file):
    file.write_bytes(file.read_bytes()[:-30])


def save_16_bit_rgb(file):
    """Pillow cannot write one."""
    import struct
    import zlib

    height, width = load(file).shape[:2]
    rows = b"".join(b"\0" + bytes(6 * width) for _ in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


def replaced(old, new):
    return lambda file: file.write_text(file.read_text().replace(old, new, 1))


S = "scene_000001/scene.json"
# What is broken, how, the words that name it, and how many problems there are.
BROKEN = {
    "no dataset.json": ("dataset.json", removed, "no such file", 1),
    "version": ("dataset.json", replaced('"version": 1', '"version": 7'), "'version' is 7, expected 1", 1),
    "family": ("dataset.json", replaced("mug", "pan"), None, 2),
    "missing label": ("scene_000001/left_label.png", removed, "no such file", 1),
    "missing right view": ("scene_000001/right.png", removed, "no such file", 1),
    "missing depth": ("scene_000001/left_depth.png", removed, "no such file", 1),
    "missing calibration": ("scene_000001/calib.txt", removed, "no such file", 1),
    "missing scene.json": (S, removed, "no such file", 1),
    "wrong size": (
        "scene_000001/right_mask.png",
        edited_pixels(lambda pixels: pixels[:-10]),
        "is 200x140 px, expected 200x150",
        1,
    ),
    "right view of another size": (
        "scene_000001/right.png",
        edited_pixels(lambda pixels: pixels[:-10]),
        "is 200x140 px, expected 200x150",
        1,
    ),
    "depth of another size": (
        "scene_000001/right_depth.png",
        edited_pixels(lambda pixels: pixels[:-10]),
        "is 200x140 px, expected 200x150",
        1,
    ),
    "empty mask": ("scene_000001/left_mask.png", edited_pixels(np.zeros_like), "is empty", None),
    "unknown id": ("scene_000001/left_mask.png", with_patch(9), "holds id 9", 1),
    "label off the object": (
        "scene_000001/left_label.png",
        with_patch(255),
        "9 px outside of every object",
        1,
    ),
    "label of other values": (
        "scene_000001/left_label.png",
        edited_pixels(lambda pixels: pixels // 2),
        "expected 0 and 255",
        1,
    ),
    "no JSON": (S, lambda file: file.write_text('{"schema": 1,'), "no valid JSON", 1),
    "truncated image": ("scene_000001/left.png", truncated, "truncated", 1),
    "truncated depth": ("scene_000001/left_depth.png", truncated, "truncated", 1),
    "schema": (S, edited_scene(lambda scene: scene.update(schema=3)), "'schema' is 3, expected 1", 1),
    "no objects": (S, edited_scene(lambda scene: scene.update(objects=[])), None, 2),
    "same id twice": (
        S,
        edited_scene(lambda scene: scene["objects"].append(scene["objects"][0])),
        "the id 1 is given twice",
        1,
    ),
    "id out of range": (S, edited_object(id=256), "'id' is 256", None),
    "pose of NaN": (S, edited_pose(0, 3, float("nan")), "NaN", 1),
    "pose of null": (S, edited_pose(0, 3, None), "cam_from_object of object 1", 1),
    "pose no rotation": (S, edited_pose(0, 0, 1.2), "no rigid transform", 1),
    "pose mirrored": (S, edited_pose(0, 0, -1), "no rigid transform", 1),
    "pose short": (S, edited_object(cam_from_object=[[1, 0, 0, 0]]), "expected 4 rows of 4", 1),
    "pose missing": (
        S,
        edited_scene(lambda scene: scene["objects"][0].pop("cam_from_object")),
        "cam_from_object of object 1 is missing",
        1,
    ),
    "table no rotation": (
        S,
        edited_scene(lambda scene: scene["cam_from_table"][0].__setitem__(0, 2)),
        "cam_from_table is no rigid transform",
        1,
    ),
    "another table plane": (
        S,
        edited_scene(lambda scene: scene["table_plane"].update(offset_m=9)),
        "different planes",
        1,
    ),
    "visible_px": (
        S,
        edited_scene(lambda scene: scene["objects"][0]["visible_px"].update(left=7)),
        None,
        1,
    ),
    "visible_share": (
        S,
        edited_object(visible_share={"left": 1.5, "right": 1.0}),
        "visible_share of object 1 is 1.5 for the left view",
        1,
    ),
    "axes": (S, edited_scene(lambda scene: scene["axes"].update(light=[1])), "the axis 'light'", 1),
    "image size": (
        S,
        edited_scene(lambda scene: scene.update(image_size=[8, 8])),
        "'image_size' is [8,8]",
        1,
    ),
    "other camera": (
        "scene_000001/calib.txt",
        replaced("baseline=80", "baseline=90"),
        "baseline_m is 0.09",
        1,
    ),
    "camera of another size": ("scene_000001/calib.txt", replaced("width=200", "width=100"), "100x150", 1),
    "16-bit image": ("scene_000001/left.png", save_16_bit_rgb, "16 bits a channel", 1),
    "16-bit mask": (
        "scene_000001/left_mask.png",
        edited_pixels(lambda pixels: pixels.astype(np.uint16)),
        "16 bits a pixel",
        1,
    ),
    "8-bit depth": (
        "scene_000001/left_depth.png",
        edited_pixels(lambda pixels: (pixels // 256).astype(np.uint8)),
        "expected a 16-bit",
        1,
    ),
    "grey right view": (
        "scene_000001/right.png",
        edited_pixels(lambda pixels: pixels[..., 0].copy()),
        "expected the same as the left image",
        1,
    ),
    "text for an image": ("scene_000001/left.png", lambda file: file.write_text("hello"), "no image", 1),
}


@pytest.mark.parametrize("name", BROKEN)
def test_check_names_what_is_broken(cli, dataset, name):
    relative, damage, said, count = BROKEN[name]
    damage(dataset / relative)
    result = cli("check", dataset)
    problems = result.stdout.splitlines()
    assert_refused(result, dataset, "problem", problems[0])
    if said is not None:
        assert any(line.startswith(f"{dataset / relative}: ") and said in line for line in problems), problems
    if count is not None:
        assert len(problems) == count, problems


def test_check_names_everything_at_once(cli, dataset):
    (dataset / "scene_000000" / "left_label.png").unlink()
    (dataset / "scene_000000" / "calib.txt").write_text("no calibration")
    truncated(dataset / "scene_000001" / "right_mask.png")
    edited_pose(1, 1, 5)(dataset / S)
    result = cli("check", dataset)
    assert_refused(result, f"{dataset}: 4 problems")
    named = {line.split(": ")[0] for line in result.stdout.splitlines()}
    files = ["scene_000000/left_label.png", "scene_000000/calib.txt", "scene_000001/right_mask.png", S]
    assert named == {str(dataset / file) for file in files}


def test_check_stops_listing_some_time(cli, tmp_path):
    for index in range(250):
        (tmp_path / f"photo_{index:03d}.json").write_text('{"shapes": 1}' if index else '{"shapes": []}')
    result = cli("check", tmp_path)
    lines = result.stdout.splitlines()
    assert_refused(result, "250 problems")
    assert len(lines) == 201 and lines[-1] == "... and 50 more"
