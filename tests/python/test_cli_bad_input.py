"""graspctx_cli: bad input ends with code 3, one line that names the file, and nothing written."""

import json
import shutil
import struct
import zlib

import numpy as np
import pytest
from conftest import Pair, write_drawn_dataset

hypothesis = pytest.importorskip("hypothesis")
Image = pytest.importorskip("PIL.Image")

FUZZ = hypothesis.settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(hypothesis.HealthCheck),
)
OLD = "what stood there"


def assert_one_line_naming(result, file):
    assert result.returncode == 3, (result.returncode, result.stdout, result.stderr)
    lines = result.stderr.splitlines()
    assert len(lines) == 1 and result.stderr.endswith("\n"), result.stderr
    assert str(file) in lines[0], lines[0]


@pytest.fixture
def pair(mug_pair, tmp_path):
    """A copy of the bundled pair that a test may damage."""
    folder = tmp_path / "pair"
    folder.mkdir()
    for file in (mug_pair.left, mug_pair.right, mug_pair.calibration):
        shutil.copy(file, folder / file.name)
    return Pair(folder / "left.png", folder / "right.png", folder / "calib.txt")


@pytest.fixture
def refuses(cli, tmp_path):
    """Runs a command into existing outputs, and checks that it refuses `file` and leaves them alone."""

    def run(file, *arguments, outputs=()):
        for output in outputs:
            output.write_text(OLD)
        before = sorted(tmp_path.rglob("*"))
        result = cli(*arguments)
        assert_one_line_naming(result, file)
        assert result.stdout == ""
        assert sorted(tmp_path.rglob("*")) == before
        for output in outputs:
            assert output.read_text() == OLD

    return run


@pytest.fixture
def refuses_detect(refuses, tmp_path, trained_model):
    def run(file, pair, *more, model=trained_model):
        outputs = [tmp_path / "out.json", tmp_path / "out.png"]
        arguments = ["detect", *pair.arguments, "--model", model, *more]
        refuses(file, *arguments, "--json", outputs[0], "--picture", outputs[1], outputs=outputs)

    return run


# ---- images ----


def damage_missing(file):
    file.unlink()


def damage_empty(file):
    file.write_bytes(b"")


def damage_folder(file):
    file.unlink()
    file.mkdir()


def damage_text(file):
    file.write_text("this is no picture\n" * 100)


def damage_truncate_header(file):
    file.write_bytes(file.read_bytes()[:20])


def damage_truncate_half(file):
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2])


def damage_truncate_end(file):
    file.write_bytes(file.read_bytes()[:-5])


def damage_flip(file):
    data = bytearray(file.read_bytes())
    data[len(data) // 3] ^= 0x10
    file.write_bytes(data)


def damage_huge(file):
    header = struct.pack(">IIBBBBB", 2**31 - 1, 2**31 - 1, 8, 2, 0, 0, 0)
    chunk = b"IHDR" + header
    file.write_bytes(
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    )


def damage_smaller(file):
    with Image.open(file) as image:
        smaller = image.resize((320, 240))
    smaller.save(file)


def damage_grey(file):
    with Image.open(file) as image:
        grey = image.convert("L")
    grey.save(file)


def damage_jpeg_half(file):
    with Image.open(file) as image:
        image.load()
    image.save(file, format="JPEG")
    damage_truncate_half(file)


def damage_jpeg_end(file):
    with Image.open(file) as image:
        image.load()
    image.save(file, format="JPEG")
    file.write_bytes(file.read_bytes()[:-2])


def damage_gif(file):
    with Image.open(file) as image:
        other = image.convert("P")
    other.save(file, format="GIF")


UNREADABLE = [
    damage_missing,
    damage_empty,
    damage_folder,
    damage_text,
    damage_truncate_header,
    damage_truncate_half,
    damage_truncate_end,
    damage_flip,
    damage_huge,
    damage_jpeg_half,
    damage_jpeg_end,
    damage_gif,
]


@pytest.mark.parametrize("damage", [*UNREADABLE, damage_smaller, damage_grey])
@pytest.mark.parametrize("side", ["left", "right"])
def test_broken_image(refuses_detect, pair, side, damage):
    file = getattr(pair, side)
    damage(file)
    # Sizes and channels are compared with the left image's.
    blamed = pair.right if damage is damage_grey else file
    if damage is damage_smaller and side == "left":
        blamed = pair.left
    refuses_detect(blamed, pair)


@pytest.mark.parametrize("damage", UNREADABLE)
def test_broken_image_elsewhere(refuses, pair, tmp_path, damage):
    damage(pair.left)
    outputs = [tmp_path / name for name in ("out.png", "scene.png", "out.json")]
    arguments = ["--output", outputs[0], "--picture", outputs[1], "--json", outputs[2]]
    refuses(pair.left, "segment", *pair.arguments, *arguments, outputs=outputs)
    outputs = [tmp_path / "out.npy"]
    refuses(pair.left, "describe", pair.left, "--output", outputs[0], outputs=outputs)


def test_both_images_of_another_size_than_the_calibration(refuses_detect, pair):
    damage_smaller(pair.left)
    damage_smaller(pair.right)
    refuses_detect(pair.calibration, pair)


def test_a_name_with_a_line_break_still_gives_one_line(cli, pair, tmp_path):
    file = tmp_path / "two\nlines.png"
    file.write_text("no picture")
    result = cli("describe", file, "--output", tmp_path / "out.npy")
    assert_one_line_naming(result, "two lines.png")


# ---- masks ----


def mask_file(tmp_path, array):
    file = tmp_path / "own_mask.png"
    Image.fromarray(array).save(file)
    return file


@pytest.mark.parametrize(
    "array",
    [
        np.ones((240, 320), np.uint8),
        np.ones((640, 480), np.uint8),
        np.ones((480, 640, 3), np.uint8),
        np.ones((480, 640, 4), np.uint8),
        np.ones((480, 640), np.uint16),
    ],
    ids=["smaller", "transposed", "colour", "alpha", "16-bit"],
)
def test_unsuitable_mask(refuses_detect, pair, tmp_path, array):
    file = mask_file(tmp_path, array)
    refuses_detect(file, pair, "--mask", file)


@pytest.mark.parametrize("damage", UNREADABLE)
def test_broken_mask(refuses_detect, pair, tmp_path, damage):
    file = mask_file(tmp_path, np.ones((480, 640), np.uint8))
    damage(file)
    refuses_detect(file, pair, "--mask", file)


def test_empty_mask_holds_nothing_to_describe(refuses, pair, tmp_path):
    file = mask_file(tmp_path, np.zeros((480, 640), np.uint8))
    refuses(file, "describe", pair.left, "--mask", file, "--fovea", "--output", tmp_path / "out.npy")


@pytest.mark.parametrize(
    "words",
    [
        "--fixate 640,10",
        "--roi 600,400,41,80",
        "--roi 600,400,40,81",
        "--roi 0,0,0,5",
        "--roi 32767,0,32767,5",
        "--gravity 0,0,0",
        "--table-plane 0,-1,0,0",
        "--table-plane 0,-1,-1,0.4",
        "--table-plane 0,-0.6,-0.8,-0.4",
    ],
)
def test_options_that_do_not_fit_are_named(refuses, refuses_detect, pair, tmp_path, words):
    option, value = words.split()
    refuses_detect(option, pair, option, value)
    outputs = [tmp_path / name for name in ("mask.png", "scene.png", "found.json")]
    arguments = ["--output", outputs[0], "--picture", outputs[1], "--json", outputs[2]]
    refuses(option, "segment", *pair.arguments, option, value, *arguments, outputs=outputs)


def test_fixation_outside_of_the_box(refuses, pair):
    words = ["--roi", "10,10,50,50", "--fixate", "5,30"]
    refuses("--fixate", "segment", *pair.arguments, *words, "--json", "-")


# ---- calibrations ----


def without_line(key):
    return lambda text: "".join(line for line in text.splitlines(True) if not line.startswith(key + "="))


def with_value(key, value):
    return lambda text: "".join(
        f"{key}={value}\n" if line.startswith(key + "=") else line for line in text.splitlines(True)
    )


CALIBRATIONS = {
    "empty": lambda text: "",
    "blank": lambda text: "\n\n",
    "words": lambda text: "a camera\n",
    "binary": lambda text: "\x00\x01\x02" * 100,
    "half": lambda text: text[: len(text) // 2],
    "json": lambda text: '{"cam0": 1}',
    "no cam0": without_line("cam0"),
    "no cam1": without_line("cam1"),
    "no doffs": without_line("doffs"),
    "no baseline": without_line("baseline"),
    "no width": without_line("width"),
    "no height": without_line("height"),
    "twice": lambda text: text + "baseline=1\n",
    "baseline zero": with_value("baseline", "0"),
    "baseline negative": with_value("baseline", "-80"),
    "baseline nan": with_value("baseline", "nan"),
    "baseline inf": with_value("baseline", "inf"),
    "baseline overflow": with_value("baseline", "1e999"),
    "baseline huge": with_value("baseline", "1e30"),
    "baseline comma": with_value("baseline", "80,5"),
    "baseline word": with_value("baseline", "eighty"),
    "doffs differs": with_value("doffs", "12"),
    "width zero": with_value("width", "0"),
    "width negative": with_value("width", "-640"),
    "width fraction": with_value("width", "640.5"),
    "height huge": with_value("height", "4800000000"),
    "matrix short": with_value("cam0", "[600 0 320; 0 600 240]"),
    "matrix long": with_value("cam0", "[600 0 320; 0 600 240; 0 0 1; 0 0 1]"),
    "matrix open": with_value("cam0", "[600 0 320; 0 600 240; 0 0 1"),
    "matrix nan": with_value("cam0", "[nan 0 320; 0 600 240; 0 0 1]"),
    "focal zero": with_value("cam0", "[0 0 320; 0 0 240; 0 0 1]"),
    "focal negative": with_value("cam0", "[-600 0 320; 0 -600 240; 0 0 1]"),
    "focal differs": with_value("cam1", "[500 0 320; 0 500 240; 0 0 1]"),
    "skew": with_value("cam0", "[600 5 320; 0 600 240; 0 0 1]"),
}


@pytest.mark.parametrize("name", CALIBRATIONS)
def test_broken_calibration(refuses_detect, pair, name):
    pair.calibration.write_text(CALIBRATIONS[name](pair.calibration.read_text()))
    refuses_detect(pair.calibration, pair)


@pytest.mark.parametrize("damage", [damage_missing, damage_folder])
def test_calibration_that_is_no_file(refuses_detect, pair, damage):
    damage(pair.calibration)
    refuses_detect(pair.calibration, pair)


YAMLS = {
    "empty": "",
    "words": "a camera",
    "sequence": "- 1\n- 2\n",
    "unclosed": "camera_matrix: {rows: 3",
    "alias": "a: *b\n",
    "tab": "a:\n\t- b\n",
    "flow nesting": "a: " + "[" * 200000,
    "map nesting": "{a: " * 100000,
    "block nesting": "".join(" " * i + "a:\n" for i in range(900)),
    "compact nesting": "- " * 20000,
    "opencv": "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1., 0. ]\n",
}


@pytest.mark.parametrize("name", YAMLS)
def test_broken_camera_info(refuses, pair, trained_model, tmp_path, name):
    file = tmp_path / "left.yaml"
    file.write_text(YAMLS[name])
    (tmp_path / "right.yaml").write_text(YAMLS[name])
    calibration = ["--calibration", file, tmp_path / "right.yaml"]
    refuses(file, "detect", pair.left, pair.right, *calibration, "--model", trained_model)


@FUZZ
@hypothesis.given(data=hypothesis.strategies.data())
def test_fuzzed_calibration(cli, mug_pair, trained_model, tmp_path_factory, data):
    text = bytearray(mug_pair.calibration.read_bytes())
    for _ in range(data.draw(hypothesis.strategies.integers(1, 3))):
        at = data.draw(hypothesis.strategies.integers(0, len(text) - 1))
        text[at] = data.draw(hypothesis.strategies.integers(0, 255))
    folder = tmp_path_factory.mktemp("fuzz")
    (folder / "calib.txt").write_bytes(text)
    arguments = [mug_pair.left, mug_pair.right, "--calibration", folder / "calib.txt"]
    result = cli("detect", *arguments, "--model", trained_model, "--json", "-")
    if result.returncode == 0:
        json.loads(result.stdout)
    else:
        assert_one_line_naming(result, "")
        assert result.stdout == ""


# ---- models ----


def split_model(data):
    (size,) = struct.unpack_from("<Q", data)
    return json.loads(data[8 : 8 + size]), data[8 + size :]


def join_model(header, tensors):
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + tensors


def edit_header(edit):
    def damage(data):
        header, tensors = split_model(data)
        edit(header)
        return join_model(header, tensors)

    return damage


def edit_metadata(**entries):
    return edit_header(lambda header: header["__metadata__"].update(entries))


def number_key(header, word):
    return next(key for key in header["__metadata__"] if word in key and not key.startswith("provenance."))


def edit_number(word, value):
    def edit(header):
        header["__metadata__"][number_key(header, word)] = value

    return edit_header(edit)


def edit_tensor(index, **entries):
    def edit(header):
        name = sorted(set(header) - {"__metadata__"})[index]
        header[name].update(entries)

    return edit_header(edit)


def remove_tensor(header):
    del header[sorted(set(header) - {"__metadata__"})[0]]


def put_floats(value):
    def damage(data):
        header, tensors = split_model(data)
        tensors = bytearray(tensors)
        for name in set(header) - {"__metadata__"}:
            begin, _ = header[name]["data_offsets"]
            struct.pack_into("<d" if header[name]["dtype"] == "F64" else "<f", tensors, begin, value)
        return join_model(header, bytes(tensors))

    return damage


MODELS = {
    "empty": lambda data: b"",
    "short": lambda data: data[:7],
    "header length only": lambda data: data[:8],
    "half a header": lambda data: data[:300],
    "no tensors": lambda data: join_model(*split_model(data))[: -len(split_model(data)[1])],
    "half": lambda data: data[: len(data) // 2],
    "last byte": lambda data: data[:-1],
    "one byte more": lambda data: data + b"\0",
    "random": lambda data: np.random.default_rng(3).bytes(len(data)),
    "zeros": lambda data: bytes(len(data)),
    "text": lambda data: b"svm_type c_svc\nkernel_type rbf\n",
    "header length huge": lambda data: b"\xff" * 8 + data[8:],
    "header length past the end": lambda data: struct.pack("<Q", len(data)) + data[8:],
    "header length zero": lambda data: struct.pack("<Q", 0) + data[8:],
    "header no JSON": lambda data: data[:8] + b"x" + data[9:],
    "header nested": lambda data: struct.pack("<Q", 90000) + b"[" * 90000,
    "header a list": lambda data: join_model([1, 2], split_model(data)[1]),
    "no metadata": edit_header(lambda header: header.pop("__metadata__")),
    "metadata a number": edit_header(lambda header: header["__metadata__"].update(name=5)),
    "other format": edit_metadata(format="pt"),
    "other version": edit_metadata(format_version="99"),
    "missing number": edit_header(lambda header: header["__metadata__"].pop(number_key(header, "gamma"))),
    "gamma nan": edit_number("gamma", "nan"),
    "gamma negative": edit_number("gamma", "-1"),
    "gamma a word": edit_number("gamma", "much"),
    "rho inf": edit_number("rho", "inf"),
    "bins huge": edit_number("angular_bins", "1000000000"),
    "bins other": edit_number("angular_bins", "12"),
    "patch zero": edit_number("patch_px", "0"),
    "tensor missing": edit_header(remove_tensor),
    "tensor type": edit_tensor(0, dtype="F16"),
    "tensor type unknown": edit_tensor(0, dtype="Z9"),
    "tensor offsets swapped": edit_tensor(0, data_offsets=[8, 0]),
    "tensor offsets far": edit_tensor(0, data_offsets=[0, 2**62]),
    "tensor offsets negative": edit_tensor(0, data_offsets=[-8, 0]),
    "tensor shape": edit_tensor(0, shape=[1]),
    "tensor shape huge": edit_tensor(0, shape=[2**32, 2**32]),
    "tensor shape negative": edit_tensor(0, shape=[-1]),
    "tensor nan": put_floats(float("nan")),
    "tensor inf": put_floats(float("inf")),
}


@pytest.mark.parametrize("name", MODELS)
def test_broken_model(refuses, refuses_detect, pair, trained_model, tmp_path, name):
    file = tmp_path / "model.safetensors"
    file.write_bytes(MODELS[name](trained_model.read_bytes()))
    refuses(file, "info", file)
    outputs = [tmp_path / "out.model", tmp_path / "out.model.range"]
    refuses(file, "export", file, "--libsvm", outputs[0], outputs=outputs)
    refuses_detect(file, pair, model=file)


def test_unknown_model(refuses, drawn_dataset, tmp_path):
    for name in ("no_such_model", tmp_path / "no_such_file.safetensors", tmp_path):
        refuses(name, "info", name)
        refuses(name, "evaluate", drawn_dataset, "--model", name)


@FUZZ
@hypothesis.given(data=hypothesis.strategies.data())
def test_fuzzed_model(cli, trained_model, tmp_path_factory, data):
    bytes_ = bytearray(trained_model.read_bytes())
    (header_size,) = struct.unpack_from("<Q", bytes_)
    for _ in range(data.draw(hypothesis.strategies.integers(1, 4))):
        last = data.draw(hypothesis.strategies.sampled_from([8, 8 + header_size, len(bytes_)]))
        at = data.draw(hypothesis.strategies.integers(0, last - 1))
        bytes_[at] = data.draw(hypothesis.strategies.integers(0, 255))
    file = tmp_path_factory.mktemp("fuzz") / "model.safetensors"
    file.write_bytes(bytes_)
    result = cli("info", file, "--json", "-")
    if result.returncode == 0:
        json.loads(result.stdout)
    else:
        assert_one_line_naming(result, file)


# ---- data sets ----


@pytest.fixture
def dataset(tmp_path):
    write_drawn_dataset(tmp_path / "set", scenes=2, seed=5)
    return tmp_path / "set"


def scene_json(content):
    return "scene_000001/scene.json", lambda file: file.write_text(content)


DATASETS = {
    "no header": ("dataset.json", damage_missing),
    "header no JSON": ("dataset.json", damage_text),
    "header other": ("dataset.json", lambda file: file.write_text('{"format": "coco", "version": 1}')),
    "header version": (
        "dataset.json",
        lambda file: file.write_text('{"format": "graspctx-dataset", "version": 2}'),
    ),
    "no image": ("scene_000001/left.png", damage_missing),
    "truncated image": ("scene_000000/right.png", damage_truncate_half),
    "no mask": ("scene_000001/right_mask.png", damage_missing),
    "no label": ("scene_000001/left_label.png", damage_missing),
    "smaller label": ("scene_000001/left_label.png", damage_smaller),
    "colour label": (
        "scene_000001/left_label.png",
        lambda file: Image.fromarray(np.zeros((150, 200, 3), np.uint8)).save(file),
    ),
    "scene no JSON": scene_json("{"),
    "scene nested": scene_json("[" * 100000),
    "scene a list": scene_json("[1]"),
    "scene without objects": scene_json('{"schema": 1}'),
    "scene of another schema": scene_json('{"schema": 2, "objects": []}'),
    "object id": scene_json('{"schema": 1, "objects": [{"id": 256, "family": "mug"}]}'),
    "object family": scene_json('{"schema": 1, "objects": [{"id": 1}]}'),
}


@pytest.mark.parametrize("name", DATASETS)
def test_broken_dataset(cli, refuses, dataset, trained_model, tmp_path, name):
    relative, damage = DATASETS[name]
    damage(dataset / relative)
    outputs = [tmp_path / "out.safetensors"]
    refuses(dataset / relative, "train", dataset, "--output", outputs[0], outputs=outputs)
    outputs = [tmp_path / "out.json"]
    arguments = ["--model", trained_model, "--json", outputs[0]]
    refuses(dataset / relative, "evaluate", dataset, *arguments, outputs=outputs)
    result = cli("check", dataset)
    assert_one_line_naming(result, dataset)
    assert str(dataset / relative) in result.stdout


def test_datasets_that_hold_nothing(refuses, dataset, tmp_path):
    output = ["--output", tmp_path / "out.safetensors"]
    (tmp_path / "empty").mkdir()
    for folder in (tmp_path / "empty", tmp_path / "missing", dataset / "dataset.json"):
        refuses(folder, "train", folder, *output)
    refuses(dataset, "train", dataset, *output, "--classes", "teapot")
    # Two scenes are fewer groups than the folds of the cross-validation.
    refuses(dataset, "train", dataset, *output)


# ---- outputs ----


def test_output_that_cannot_be_written(refuses, pair, trained_model, drawn_dataset, tmp_path):
    nowhere = tmp_path / "no_folder" / "out"
    folder = tmp_path / "folder.png"
    folder.mkdir()
    detect = ["detect", *pair.arguments, "--model", trained_model]
    refuses(nowhere, *detect, "--json", nowhere)
    refuses(folder, *detect, "--picture", folder)
    outputs = [tmp_path / "out.json"]
    refuses(folder, *detect, "--json", outputs[0], "--picture", folder, outputs=outputs)
    refuses(nowhere, "train", drawn_dataset, "--output", nowhere)
    refuses(nowhere, "evaluate", drawn_dataset, "--model", trained_model, "--json", nowhere)
    refuses(folder, "segment", *pair.arguments, "--output", folder)
    refuses(nowhere, "describe", pair.left, "--output", nowhere)
    refuses(nowhere, "export", trained_model, "--libsvm", nowhere)
    refuses(nowhere, "info", trained_model, "--json", nowhere)


def test_full_disk(cli, pair, trained_model, tmp_path):
    with open("/dev/full", "w") as full:
        result = cli("info", trained_model, capture_output=False, stdout=full, stderr=-1)
    assert result.returncode == 3
    assert len(result.stderr.splitlines()) == 1
    result = cli("detect", *pair.arguments, "--model", trained_model, "--json", "/dev/full")
    assert_one_line_naming(result, "/dev/full")
