"""The fixed sets of the benchmarks: named, made again, and proved."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

if importlib.util.find_spec("mujoco") is None:
    pytest.skip("rendered scenes need the extra 'sim' (mujoco)", allow_module_level=True)

from graspctx.sim import FAMILIES
from graspctx.sim.__main__ import build_parser

PROGRAM = Path(__file__).resolve().parents[2] / "benchmarks" / "datasets.py"


@pytest.fixture
def datasets(tmp_path, monkeypatch):
    """The program as a module, with records of its own."""
    specification = importlib.util.spec_from_file_location("benchmark_datasets", PROGRAM)
    module = importlib.util.module_from_spec(specification)
    monkeypatch.setitem(sys.modules, specification.name, module)
    specification.loader.exec_module(module)
    monkeypatch.setattr(module, "RECORDS", tmp_path / "datasets.json")
    return module


@pytest.fixture(scope="module")
def smoke(tmp_path_factory):
    out = tmp_path_factory.mktemp("sets") / "smoke"
    made = subprocess.run([sys.executable, PROGRAM, "make", "smoke", out], capture_output=True, timeout=300)
    assert made.returncode == 0, made.stderr
    return out


def test_every_set_is_a_command_that_make_understands(datasets):
    seeds = []
    for name, fixed in datasets.SETS.items():
        options = build_parser().parse_args(datasets.make_arguments(name, Path("OUT")))
        assert (options.scenes, options.seed) == (fixed.scenes, fixed.seed)
        assert options.split == (
            "train" if name.startswith("training") else "validation" if name == "validation" else "test"
        )
        assert fixed.scenes % len(options.families) == 0  # as many scenes of each
        seeds.append(fixed.seed)
    assert len(set(seeds)) == len(seeds)


def test_every_family_is_trained_on_or_is_a_new_shape(datasets):
    assert sorted(f"{datasets.TRAINED},{datasets.UNTRAINED}".split(",")) == sorted(FAMILIES)


def test_other_numbers_and_seeds_can_be_asked_for(datasets):
    options = build_parser().parse_args(datasets.make_arguments("smoke", Path("OUT"), scenes=2, seed=9))
    assert (options.scenes, options.seed, options.split) == (2, 9, "test")


def test_a_set_is_proved_by_what_was_recorded(datasets, smoke, tmp_path, capsys):
    assert datasets.main(["verify", "smoke", str(smoke)]) == 3
    assert "nothing is recorded of smoke" in capsys.readouterr().err
    assert datasets.main(["record", "smoke", str(smoke)]) == 0
    recorded = json.loads(datasets.RECORDS.read_text())
    assert list(recorded) == ["smoke"] and recorded["smoke"]["made_with"]["mujoco"]
    assert datasets.main(["verify", "smoke", str(smoke)]) == 0
    assert capsys.readouterr().out.count("as recorded") == 2

    copy = tmp_path / "copy"
    shutil.copytree(smoke, copy)
    picture = copy / "scene_000002" / "right.png"
    picture.write_bytes(picture.read_bytes() + b"\0")
    assert datasets.main(["verify", "smoke", str(copy)]) == 3
    assert "the scenes that were recorded, but other bytes" in capsys.readouterr().err
    file = copy / "scene_000002" / "scene.json"
    info = json.loads(file.read_text())
    info["objects"][0]["shape_seed"] += 16
    file.write_text(json.dumps(info))
    assert datasets.main(["verify", "smoke", str(copy)]) == 3
    assert "other scenes than recorded" in capsys.readouterr().err
    shutil.rmtree(copy / "scene_000002")
    assert datasets.main(["verify", "smoke", str(copy)]) == 3
    assert "5 of 6 scenes" in capsys.readouterr().err
    assert datasets.main(["record", "smoke", str(copy)]) == 3
    assert json.loads(datasets.RECORDS.read_text()) == recorded


def test_a_set_of_another_name_is_refused(datasets, smoke, capsys):
    assert datasets.main(["verify", "low", str(smoke)]) == 3
    assert "expected seed" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [[], ["verify", "everything", "out"], ["make", "smoke"], ["record", "smoke", "out", "--seed", "1"]],
)
def test_wrong_usage_exits_with_2(datasets, arguments):
    with pytest.raises(SystemExit) as stopped:
        datasets.main(arguments)
    assert stopped.value.code == 2


def test_list_prints_the_commands(datasets, capsys):
    assert datasets.main(["list"]) == 0
    printed = capsys.readouterr().out
    assert all(f"\n{name}: " in f"\n{printed}" for name in datasets.SETS)
    assert printed.count("python -m graspctx.sim make OUT --scenes") == len(datasets.SETS)
