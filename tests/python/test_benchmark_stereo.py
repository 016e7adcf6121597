"""The stereo benchmark: its figures on maps with known answers, and a small run."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "PIL")):
    pytest.skip("the benchmark needs the extra 'sim' (mujoco, pillow)", allow_module_level=True)

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import stereo

PROGRAM = Path(stereo.__file__)


def test_shares_count_what_both_views_see():
    truth = np.full((4, 100), 20.0)
    truth[0] = np.nan  # unknown truth counts nowhere
    found = truth.copy()
    found[1] += 1.9
    found[2, 20:60] += 2.1
    found[3, 20:40] = np.nan
    found[:, :20] = 77  # outside the right view
    shares = stereo.map_shares(found, truth)
    assert shares["known"] == pytest.approx(220 / 240)
    assert shares["bad_of_known"] == pytest.approx(40 / 220)
    assert shares["bad_of_all"] == pytest.approx(60 / 240)


def test_depth_errors_are_those_of_objects_that_were_found():
    ids = np.zeros((20, 20), np.uint8)
    ids[2:8, 2:8], ids[12:18, 12:18] = 1, 2
    truth = stereo.Truth(np.full(ids.shape, 50.0), ids, focal_baseline=50.0)
    found = np.full(ids.shape, 49.0)
    segments = np.where(ids == 1, 5, 0)
    segments[12, 12] = 6  # a corner of the other object
    errors = stereo.object_errors_mm(found, truth, segments)
    assert errors == [pytest.approx((1000 / 49, 1000 / 49), rel=0.03)]


def test_a_small_run(tmp_path):
    file = tmp_path / "stereo.json"
    command = [sys.executable, PROGRAM, "--seed", "7", "--scenes", "3", "--workers", "1", "--json", file]
    run = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stderr
    result = json.loads(file.read_text())
    assert (result["benchmark"], result["seed"]) == ("stereo", 7)
    rows = {(row["measure"], row["set"], row["method"], row["map"]): row["value"] for row in result["rows"]}
    for method in ("half", "half+objects", "full"):
        assert rows["known", "textured", method, "dense"] > 0.8
        assert rows["bad_of_known", "textured", method, "reliable"] < 0.1
        assert rows["known", "plain", method, "reliable"] <= rows["known", "plain", method, "dense"]
    assert "| half+objects" in run.stdout


@pytest.mark.parametrize(
    "arguments, words",
    [(["--middlebury", "nowhere"], "nowhere: no pair"), (["--data", "nowhere"], "nowhere: no such folder")],
)
def test_what_cannot_be_used_is_named(arguments, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("GRASPCTX_SHARED_DATA", raising=False)
    assert stereo.main(["--seed", "1", *arguments]) == 3
    assert words in capsys.readouterr().err
