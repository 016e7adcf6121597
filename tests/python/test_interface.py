"""The public names, their signatures, defaults and stubs."""

import ast
import importlib.metadata
import inspect
import os
import pickle
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest
from graspctx import _core


def run_python(code: str) -> str:
    return subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, text=True, env={**os.environ}
    ).stdout


def test_import_is_light():
    heavy = {"mujoco", "matplotlib", "PIL", "cv2", "scipy"}
    loaded = run_python("import graspctx, sys; print(*sys.modules)").split()
    assert heavy.isdisjoint(loaded)


def test_version_is_the_distribution_s():
    assert gc.__version__ == importlib.metadata.version("graspctx")


def test_all_names_exist_and_are_documented():
    for name in set(gc.__all__) - {"__version__"}:
        assert inspect.getdoc(getattr(gc, name)), name
    public = {name for name in vars(_core) if not name.startswith("_")} - {"descriptor_defaults"}
    assert public <= set(gc.__all__)


def test_the_docstring_s_example_runs(tmp_path, pair, monkeypatch):
    monkeypatch.chdir(tmp_path)
    left, right = pair
    gc.write_image("left.png", left)
    gc.write_image("right.png", right)
    Path("calib.txt").write_text(
        "cam0=[300 0 159.5; 0 300 119.5; 0 0 1]\ncam1=[300 0 159.5; 0 300 119.5; 0 0 1]\n"
        "doffs=0\nbaseline=80\nwidth=320\nheight=240\n"
    )
    lines = gc.__doc__.splitlines()
    example = "\n".join(line[4:] for line in lines if line.startswith("    "))
    exec(compile(example, "docstring", "exec"), {})
    assert gc.read_image("grasps.png").shape[1] == 960


# ---- Signatures and stubs ----------------------------------------------------------------------------------


def signature_of(function) -> ast.arguments:
    """The docstring's first line is the signature."""
    line = function.__doc__.splitlines()[0]
    return ast.parse(f"def {line}: ...").body[0].args


def argument_names(arguments: ast.arguments) -> tuple:
    def names(some):
        return [argument.arg for argument in some]

    required = len(arguments.args) - len(arguments.defaults)
    keyword_required = [default is None for default in arguments.kw_defaults]
    return names(arguments.args), required, names(arguments.kwonlyargs), keyword_required


def public_members(class_: type) -> dict:
    return {name: member for name, member in vars(class_).items() if not name.startswith("_")}


@pytest.fixture(scope="module")
def stub() -> dict:
    tree = ast.parse(Path(gc.__file__).with_name("_core.pyi").read_text(encoding="utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}


def test_the_package_is_typed():
    assert Path(gc.__file__).with_name("py.typed").exists()


def test_stubs_hold_exactly_the_public_names(stub):
    public = {name for name in vars(_core) if not name.startswith("_")}
    assert public == set(stub), "run tools/make_stubs"


def test_stubs_hold_every_signature(stub):
    for name, node in stub.items():
        thing = getattr(_core, name)
        if isinstance(node, ast.FunctionDef):
            assert argument_names(node.args) == argument_names(signature_of(thing)), (
                f"{name}: tools/make_stubs"
            )
            continue
        members = {
            m.name: m for m in node.body if isinstance(m, ast.FunctionDef) and not m.name.startswith("_")
        }
        if issubclass(thing, Exception):
            continue
        assert set(members) == set(public_members(thing)), f"{name}: run tools/make_stubs"
        for method, member in public_members(thing).items():
            if callable(member) and not isinstance(member, (property, staticmethod)):
                assert argument_names(members[method].args) == argument_names(signature_of(member)), (
                    f"{name}.{method}: run tools/make_stubs"
                )


# ---- Options -----------------------------------------------------------------------------------------------

POINTS = np.random.default_rng(0).uniform(0, 99, (50, 2)).astype(np.float32)
IMAGE = np.random.default_rng(1).integers(0, 256, (60, 80, 3), dtype=np.uint8)


def functions_with_options() -> list[str]:
    return [
        name
        for name in gc.__all__
        if inspect.isbuiltin(getattr(gc, name)) and signature_of(getattr(gc, name)).kwonlyargs
    ]


def test_there_are_functions_with_options():
    assert {"compute_disparity", "detect_grasps", "sample_contour", "train_model"} <= set(
        functions_with_options()
    )


@pytest.mark.parametrize("name", functions_with_options())
def test_no_option_is_named_twice(name):
    names = [argument.arg for argument in signature_of(getattr(gc, name)).kwonlyargs]
    assert len(names) == len(set(names))


def test_unknown_options_are_refused(pair, camera, model, mask, detection):
    contour = gc.sample_contour(IMAGE)
    view = gc.foveal_view(pair[0], mask)
    calls = {
        "compute_disparity": lambda **o: gc.compute_disparity(*pair, **o),
        "segment_objects": lambda **o: gc.segment_objects(*pair, camera, **o),
        "segment_scene": lambda **o: gc.segment_scene(*pair, camera, **o),
        "draw_segmentation": lambda **o: gc.draw_segmentation(*pair, camera, **o),
        "foveal_view": lambda **o: gc.foveal_view(pair[0], mask, **o),
        "sample_contour": lambda **o: gc.sample_contour(IMAGE, **o),
        "shape_contexts": lambda **o: gc.shape_contexts(POINTS, **o),
        "patch_descriptors": lambda **o: gc.patch_descriptors(contour, (80, 60), **o),
        "describe_view": lambda **o: gc.describe_view(view, **o),
        "train_model": lambda **o: gc.train_model(POINTS, np.zeros(50, int), np.zeros(50, int), **o),
        "find_grasp_points": lambda **o: gc.find_grasp_points(gc.describe_view(view), np.zeros(1), **o),
        "detect_grasps": lambda **o: gc.detect_grasps(*pair, camera, model, **o),
        "draw_detection": lambda **o: gc.draw_detection(detection, **o),
        "explain_grasp": lambda **o: gc.explain_grasp(detection, model, **o),
        "draw": lambda **o: detection.draw(**o),
        "describe_labelled_view": lambda **o: gc.describe_labelled_view(
            gc.LabelledView(pair[0], mask, mask), **o
        ),
        "augment_views": lambda **o: gc.augment_views([], **o),
        "build_training_set": lambda **o: gc.build_training_set([], **o),
    }
    with pytest.raises(TypeError):
        gc.load_dataset(".", smaples=3)
    with pytest.raises(TypeError):
        gc.check_dataset(".", smaples=3)
    assert set(functions_with_options()) <= {*calls, "check_dataset", "load_dataset"}
    for name, call in calls.items():
        with pytest.raises(TypeError, match=rf"{name}\(\).*'smaples'"):
            call(smaples=3)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"samples": "300"}, TypeError, "samples: expected an int, got str"),
        ({"samples": 300.0}, TypeError, "samples: expected an int, got float"),
        ({"samples": True}, TypeError, "samples: expected an int, got bool"),
        ({"samples": None}, TypeError, "samples: expected an int, got NoneType"),
        ({"samples": 10**30}, ValueError, "samples: expected an int from"),
        ({"samples": -1}, ValueError, "samples"),
        ({"canny_low": "20"}, TypeError, "canny_low: expected a float, got str"),
        ({"canny_low": 1j}, TypeError, "canny_low: expected a float, got complex"),
        ({"canny_low": float("nan")}, ValueError, "canny"),
        ({"canny_low": 99}, ValueError, "canny"),
    ],
)
def test_bad_options_are_named(options, error, message):
    with pytest.raises(error, match=message):
        gc.sample_contour(IMAGE, **options)


def test_other_kinds_of_options(pair, camera):
    contour = gc.sample_contour(IMAGE)
    with pytest.raises(TypeError, match="windows_patches: expected 3 ints, got int"):
        gc.patch_descriptors(contour, (80, 60), windows_patches=3)
    with pytest.raises(ValueError, match="windows_patches: expected 3 ints, got 2 values"):
        gc.patch_descriptors(contour, (80, 60), windows_patches=(1, 3))
    with pytest.raises(TypeError, match="relative_to_gradient: expected a bool, got int"):
        gc.shape_contexts(POINTS, relative_to_gradient=1)
    with pytest.raises(ValueError, match="cues: expected 'disparity', 'plane' or 'colour', got 'color'"):
        gc.segment_objects(*pair, camera, cues="color")
    with pytest.raises(TypeError, match="cues: expected a str, got int"):
        gc.segment_objects(*pair, camera, cues=1)
    with pytest.raises(ValueError, match="fixation_px: expected a pixel"):
        gc.segment_objects(*pair, camera, fixation_px=(1, 2, 3))
    with pytest.raises(TypeError, match="fixation_px: expected a float, got str"):
        gc.segment_objects(*pair, camera, fixation_px=("a", "b"))
    with pytest.raises(ValueError, match="roi_px: expected a box"):
        gc.segment_objects(*pair, camera, roi_px=(1, 2, 3))
    with pytest.raises(TypeError, match="roi_px: expected an int, got float"):
        gc.segment_objects(*pair, camera, roi_px=(1.5, 2, 3, 4))
    with pytest.raises(ValueError, match="roi_px must lie inside"):
        gc.segment_objects(*pair, camera, roi_px=(300, 2, 30, 4))
    with pytest.raises(ValueError, match="gravity: expected a vector"):
        gc.segment_objects(*pair, camera, gravity=(0, 1))
    with pytest.raises(ValueError, match="gravity must be finite"):
        gc.segment_objects(*pair, camera, gravity=np.zeros(3))
    with pytest.raises(TypeError, match="table: expected a TablePlane or"):
        gc.segment_objects(*pair, camera, table="flat")
    with pytest.raises(ValueError, match="table: the normal must have length 1"):
        gc.segment_objects(*pair, camera, table=(0, -1, -1, 0.4))


def test_numpy_numbers_are_numbers():
    few = gc.sample_contour(IMAGE, samples=np.int64(7), canny_low=np.float32(20))
    assert len(few) == 7


def test_stated_defaults_are_the_ones_in_force():
    """Passing what the signature says changes nothing; passing something else does."""
    for function, arguments, other in [
        (gc.shape_contexts, (POINTS,), {"radial_bins": 4}),
        (lambda *a, **o: gc.sample_contour(*a, **o).points, (IMAGE,), {"canny_high": 200}),
    ]:
        name = "shape_contexts" if function is gc.shape_contexts else "sample_contour"
        stated = {
            argument.arg: ast.literal_eval(default)
            for argument, default in zip(
                signature_of(getattr(gc, name)).kwonlyargs, signature_of(getattr(gc, name)).kw_defaults
            )
        }
        np.testing.assert_array_equal(function(*arguments, **stated), function(*arguments))
        changed = function(*arguments, **{**stated, **other})
        assert changed.shape != function(*arguments).shape or (changed != function(*arguments)).any()


# ---- Files and errors --------------------------------------------------------------------------------------


def test_bad_files_are_value_errors_that_name_the_file(tmp_path):
    broken = tmp_path / "broken.safetensors"
    broken.write_bytes(b"\x00" * 40)
    text = tmp_path / "calib.txt"
    text.write_text("cam0=[nonsense\n")
    image = tmp_path / "image.png"
    image.write_bytes(b"\x89PNG\r\n\x1a\nno")
    for call in (
        lambda: gc.load_model(broken),
        lambda: gc.StereoCamera.load(text),
        lambda: gc.read_image(image),
        lambda: gc.load_dataset(tmp_path / "nowhere"),
        lambda: gc.read_image(str(tmp_path / "nowhere.png")),
        lambda: gc.write_image(tmp_path / "no" / "folder" / "x.png", IMAGE),
    ):
        with pytest.raises(gc.InvalidInput, match=tmp_path.name):
            call()
    assert issubclass(gc.InvalidInput, ValueError)
    with pytest.raises(ValueError, match="no_such_model"):
        gc.load_model("no_such_model")
    with pytest.raises(TypeError):
        gc.load_model(3)


def test_messages_name_files_whose_names_are_no_utf8(tmp_path):
    name = os.fsdecode(os.fsencode(tmp_path) + b"/mug\xff.png")
    with pytest.raises(gc.InvalidInput, match=r"mug\\xff\.png: no such file"):
        gc.read_image(name)


@pytest.mark.parametrize("channels", [1, 3])
def test_images_come_back_from_files(tmp_path, channels):
    image = IMAGE if channels == 3 else np.ascontiguousarray(IMAGE[..., 0])
    gc.write_image(tmp_path / "image.png", image)
    np.testing.assert_array_equal(gc.read_image(tmp_path / "image.png"), image)


def test_values_can_be_pickled(camera, model):
    raw = gc.RawView(
        camera_matrix=[[300, 0, 160], [0, 301, 120], [0, 0, 1]],
        rectified_from_raw=np.eye(3),
        distortion=[0.1, 0.01, 0, 0],
    )
    with_raw = gc.StereoCamera(focal_px=300, centre_px=(160, 120), baseline_m=0.1, raw=(raw, raw))
    for before in (camera, with_raw):
        after = pickle.loads(pickle.dumps(before))
        assert repr(after) == repr(before)
        assert (after.raw is None) == (before.raw is None)
    assert after.raw[1].distortion == raw.distortion
    np.testing.assert_array_equal(after.raw[0].camera_matrix, raw.camera_matrix)
    assert pickle.loads(pickle.dumps(model)).to_bytes() == model.to_bytes()
