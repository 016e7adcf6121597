"""What several test files need: the program, a stereo pair, a drawn data set, a model trained on it."""

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Pair:
    """Files of a stereo pair with a Middlebury calibration."""

    left: Path
    right: Path
    calibration: Path

    @property
    def arguments(self):
        return [self.left, self.right, "--calibration", self.calibration]


@pytest.fixture(scope="session")
def cli_path():
    path = Path(os.environ.get("GRASPCTX_CLI", REPOSITORY / "build" / "dev" / "bin" / "graspctx_cli"))
    if not path.exists():
        pytest.skip(f"{path} is not built; GRASPCTX_CLI names another")
    return path


@pytest.fixture(scope="session")
def cli(cli_path):
    """Runs the program; what it prints comes back as text."""

    def run(*arguments, **options):
        settings = {"capture_output": True, "text": True, "timeout": 300, **options}
        return subprocess.run([cli_path, *map(str, arguments)], **settings)

    return run


@pytest.fixture(scope="session")
def mug_pair():
    folder = REPOSITORY / "examples" / "data" / "mug"
    return Pair(folder / "left.png", folder / "right.png", folder / "calib.txt")


def draw_mug(rng, size=(200, 150)):
    """A flat drawing of a mug: its left and right view, ids and labels, 8 px apart."""
    width, height = size
    v, u = np.mgrid[0:height, 0:width]
    scale = rng.uniform(22, 30)
    centre_u, centre_v = rng.uniform(75, 110), rng.uniform(65, 85)
    x, y = (u - centre_u) / scale, (v - centre_v) / scale
    body = (np.abs(x) < 1) & (np.abs(y) < 1.2)
    ring = np.hypot((x - 1) / 0.8, y / 0.75)
    handle = (ring < 1) & (ring > 0.65) & ~body & (x > 0.9)
    noise = rng.integers(0, 12, (height, width, 3))
    image = rng.integers(150, 230, 3) + noise
    image[body | handle] = rng.integers(20, 120, 3) + noise[body | handle]
    ids = np.where(body | handle, 1, 0).astype(np.uint8)
    label = np.where(handle, 255, 0).astype(np.uint8)
    image = image.astype(np.uint8)
    return {
        "left": (image, ids, label),
        "right": tuple(np.roll(plane, -8, axis=1) for plane in (image, ids, label)),
    }


def write_drawn_dataset(folder, scenes, seed):
    """Drawn mugs in the layout of docs/dataset-format.md."""
    image_module = pytest.importorskip("PIL.Image")
    rng = np.random.default_rng(seed)
    folder.mkdir()
    (folder / "dataset.json").write_text('{"format": "graspctx-dataset", "version": 1, "families": ["mug"]}')
    for index in range(scenes):
        scene = folder / f"scene_{index:06d}"
        scene.mkdir()
        views = draw_mug(rng)
        for side, planes in views.items():
            for name, plane in zip(("", "_mask", "_label"), planes):
                image_module.fromarray(plane).save(scene / f"{side}{name}.png")
        depth = np.full(views["left"][1].shape, 8000, np.uint16)
        image_module.fromarray(depth).save(scene / "left_depth.png")
        height, width = depth.shape
        matrix = f"[300 0 {width / 2}; 0 300 {height / 2}; 0 0 1]"
        (scene / "calib.txt").write_text(
            f"cam0={matrix}\ncam1={matrix}\ndoffs=0\nbaseline=80\nwidth={width}\nheight={height}\n"
        )
        (scene / "scene.json").write_text(
            json.dumps({"schema": 1, "objects": [{"id": 1, "family": "mug"}]}, indent=1)
        )


@pytest.fixture(scope="session")
def drawn_dataset(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawn") / "mugs"
    write_drawn_dataset(folder, scenes=12, seed=1)
    return folder


@pytest.fixture(scope="session")
def trained_model(cli, drawn_dataset, tmp_path_factory):
    """A small model, trained on drawings: enough for everything but good grasps."""
    file = tmp_path_factory.mktemp("model") / "drawn.safetensors"
    result = cli("train", drawn_dataset, "--output", file)
    assert result.returncode == 0, result.stderr
    return file


@pytest.fixture(scope="session")
def shared_data():
    """Public data that is no part of the repository."""
    folder = Path(os.environ.get("GRASPCTX_SHARED_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent; GRASPCTX_SHARED_DATA names another")
    return folder


# ---- The disc of scenes.py: known truth, for the Python package --------------------------------------------


@pytest.fixture(scope="session")
def camera():
    import scenes

    return scenes.camera()


@pytest.fixture(scope="session")
def pair():
    """Left and right view, RGB."""
    import scenes

    return scenes.disc_scene()[:2]


@pytest.fixture(scope="session")
def mask():
    import scenes

    return scenes.disc_scene()[2]


@pytest.fixture(scope="session")
def model():
    import scenes

    return scenes.disc_model()


@pytest.fixture(scope="session")
def detection(pair, camera, model, mask):
    import graspctx as gc

    return gc.detect_grasps(*pair, camera, model, mask=mask)


@pytest.fixture(scope="session")
def old_model(drawn_dataset, tmp_path_factory):
    """A model that knows neither what is familiar to it nor which images it was trained on, as older ones."""
    gc = pytest.importorskip("graspctx")
    path = tmp_path_factory.mktemp("old") / "old.safetensors"
    rows = gc.build_training_set(gc.load_dataset(drawn_dataset))
    search = {"svm_c": [3.0], "gamma_times_dimension": [1.0]}
    gc.train_model(rows.features, rows.labels, rows.groups, name="old", **search).save(path)
    return path
