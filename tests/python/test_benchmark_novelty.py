"""The benchmark of familiar and unfamiliar shapes: its figures on made-up objects, and a small run."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "scipy", "PIL", "sklearn")):
    pytest.skip(
        "the benchmark needs the extras 'sim' and 'benchmark' (mujoco, scipy, pillow, scikit-learn)",
        allow_module_level=True,
    )

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import novelty

PROGRAM = Path(novelty.__file__)


def seen(of_mug, of_pencil, chosen, hit=None):
    alone = {
        "mug": novelty.Answer(of_mug, of_mug > 0.1),
        "pencil": novelty.Answer(of_pencil, of_pencil > 0.1),
    }
    hits = None if hit is None else dict(zip(novelty.ANSWERS, hit))
    return novelty.SeenObject(alone, chosen, hits, 0.25)


def test_figures_of_made_up_objects():
    objects = {
        "mug": [
            seen(0.9, 0.0, "mug", (True, True, False)),
            seen(0.3, 0.2, "pencil", (False, True, True)),
            seen(0.05, 0.0, None, (False, False, False)),
        ],
        "pencil": [seen(0.0, 0.8, "pencil", (True, True, True)), seen(0.2, 0.6, "pencil")],
        "can": [seen(0.2, 0.0, "mug"), seen(0.0, 0.0, None)],
    }
    rows = novelty.rows_of(objects, ("mug", "pencil"))
    found = {(row["measure"], row["class"], row.get("model") or row.get("answer")): row for row in rows}
    value = {key: row["value"] for key, row in found.items()}
    assert value["auc", "can", "mug"] == pytest.approx(5 / 6)
    assert value["auc", "all others", "pencil"] == 1
    assert value["refused", "mug", "mug"] == pytest.approx(1 / 3)
    assert value["refused", "can", "mug"] == 0.5 and value["refused", "can", "pencil"] == 1
    assert value["refused_by_all", "can", None] == 0.5 and value["refused_by_all", "pencil", None] == 0
    assert value["answered_right", "mug", None] == pytest.approx(1 / 3)
    assert value["answered_right", "all", None] == pytest.approx(3 / 5)
    assert [value["top1", "mug", answer] for answer in novelty.ANSWERS] == pytest.approx(
        [1 / 3, 2 / 3, 1 / 3]
    )
    assert found["top1", "all", "vote"]["n"] == 4, "an object without a label does not count"
    assert value["chance", "mug", None] == 0.25


def test_a_small_run_measures_familiarity_and_the_vote(tmp_path):
    arguments = ["--seed", "5", "--scenes", "4", "--train-scenes", "12", "--split", "validation"]
    arguments += ["--classes", "mug,pencil", "--unfamiliar", "can", "--json", tmp_path / "novelty.json"]
    run = subprocess.run(
        [sys.executable, PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    rows = json.loads((tmp_path / "novelty.json").read_text())["rows"]
    found = {(row["measure"], row["class"], row.get("model") or row.get("answer")): row for row in rows}
    assert found["auc", "pencil", "mug"]["value"] > 0.7
    assert found["auc", "mug", "pencil"]["value"] > 0.7
    assert found["answered_right", "all", None]["value"] > 0.5
    assert found["refused_by_all", "can", None]["n"] == 4
    assert {answer for (measure, _, answer) in found if measure == "top1"} == set(novelty.ANSWERS)
    assert "| can " in run.stdout and "The vote" in run.stdout
