"""The benchmark of the descriptor's recipe: its variants are options of the core, and a small run."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import graspctx as gc
import pytest

if any(importlib.util.find_spec(module) is None for module in ("mujoco", "scipy", "PIL", "sklearn")):
    pytest.skip(
        "the benchmark needs the extras 'sim' and 'benchmark' (mujoco, scipy, pillow, scikit-learn)",
        allow_module_level=True,
    )

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks" / "accuracy"))
import recipe

PROGRAM = Path(recipe.__file__)


@pytest.mark.parametrize("variant", recipe.VARIANTS)
def test_every_variant_is_a_setting_of_the_descriptor(pair, mask, variant):
    options = recipe.VARIANTS[variant]
    features = gc.describe_view(gc.foveal_view(pair[0], mask), **options).features
    halves = 2 if "outline_px" in options else 1
    assert features.shape[1] == 3 * halves * options.get("angular_bins", 8) * 5


def test_variants_are_asked_for_by_name(capsys):
    parser = recipe.build_parser()
    asked = parser.parse_args(["--seed", "1", "--variants", "12x5;outline, 12x5"])
    assert asked.variants == ("12x5", "outline, 12x5") and asked.split == "validation"
    with pytest.raises(SystemExit):
        parser.parse_args(["--seed", "1", "--variants", "13x5"])
    assert "unknown variant '13x5'" in capsys.readouterr().err


def test_a_small_run_measures_each_variant(tmp_path):
    arguments = ["--seed", "5", "--scenes", "3", "--train-scenes", "10", "--classes", "mug"]
    arguments += ["--variants", "default;outline", "--json", tmp_path / "recipe.json"]
    run = subprocess.run(
        [sys.executable, PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    rows = json.loads((tmp_path / "recipe.json").read_text())["rows"]
    found = {(row["variant"], row["measure"], row["mask"]): row for row in rows}
    for variant in ("default", "outline"):
        assert found[variant, "ap", "true"]["value"] > found[variant, "prior", "true"]["value"]
        for mask in ("true", "dilate8", "dilate16", "wedge"):
            assert found[variant, "best_on_label", mask]["n"] > 0
    assert "| outline |" in run.stdout
