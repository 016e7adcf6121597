"""Data sets of rendered scenes: the same bytes wherever they are made, resumed, summed and described."""

import collections
import hashlib
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

if importlib.util.find_spec("mujoco") is None:
    pytest.skip("rendered scenes need the extra 'sim' (mujoco)", allow_module_level=True)
Image = pytest.importorskip("PIL.Image", reason="rendered scenes need the extra 'sim' (pillow)")

from graspctx.sim.__main__ import main  # noqa: E402
from graspctx.sim.card import card_text  # noqa: E402
from graspctx.sim.checksum import files_checksum, scenes_checksum  # noqa: E402
from graspctx.sim.dataset import make_dataset  # noqa: E402
from graspctx.sim.sheet import choose_scenes, overlay, write_sheet  # noqa: E402
from graspctx.sim.workers import WorkerError  # noqa: E402

SCENES, SEED = 4, 3
OPTIONS = {"families": ["mug", "pencil"], "objects": (1, 2), "image_size": (160, 120)}
ARGUMENTS = ["--families", "mug,pencil", "--objects", "1-2", "--resolution", "160x120"]


def command(*arguments):
    return [sys.executable, "-m", "graspctx.sim", *map(str, arguments)]


def make(out, scenes, *arguments):
    """Make a set in one process: another than this one, where mujoco may stand without a graphics library."""
    arguments = ["make", out, "--scenes", scenes, "--seed", SEED, *ARGUMENTS, *arguments]
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=300)


def digests(folder):
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Four small scenes, made in this process."""
    out = tmp_path_factory.mktemp("sets") / "one"
    made = make(out, SCENES)
    assert made.returncode == 0, made.stderr
    (out / "README.md").unlink()
    return out


@pytest.fixture(scope="module")
def records(dataset):
    return [json.loads(file.read_text()) for file in sorted(dataset.glob("*/scene.json"))]


def test_two_workers_make_the_same_files_as_this_process(dataset, tmp_path):
    counts = []
    make_dataset(
        tmp_path / "two", SCENES, SEED, **OPTIONS, workers=2, progress=lambda *now: counts.append(now)
    )
    assert digests(tmp_path / "two") == digests(dataset)
    assert len(digests(dataset)) == 1 + 10 * SCENES
    assert counts == [(finished, 0) for finished in range(SCENES + 1)]


def test_a_dask_cluster_of_two_processes_makes_the_same_files(dataset, tmp_path):
    distributed = pytest.importorskip("distributed", reason="needs the extra 'dask'")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, processes=True, host="127.0.0.1", dashboard_address=None
    ) as cluster:
        make_dataset(tmp_path / "dask", SCENES, SEED, **OPTIONS, scheduler=cluster.scheduler_address)
    assert digests(tmp_path / "dask") == digests(dataset)


def test_a_scene_does_not_depend_on_the_number_of_scenes(dataset, tmp_path):
    assert make(tmp_path / "few", 2).returncode == 0
    whole, few = digests(dataset), digests(tmp_path / "few")
    few.pop("dataset.json"), few.pop("README.md")
    assert few == {name: whole[name] for name in few} and len(few) == 2 * 10


@pytest.mark.parametrize("how, workers", [(signal.SIGKILL, 1), (signal.SIGINT, 2)])
def test_an_interrupted_run_is_taken_up_again(how, workers, dataset, tmp_path):
    out = tmp_path / "set"
    arguments = ["make", out, "--scenes", SCENES, "--seed", SEED, *ARGUMENTS]
    arguments += ["--workers", workers]
    # SIGINT may be ignored where the tests run, and is then ignored by what they start.
    process = subprocess.Popen(
        command(*arguments),
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    try:
        deadline = time.monotonic() + 120
        while not list(out.glob("scene_*/scene.json")):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.01)
        process.send_signal(how)
        _, error = process.communicate(timeout=120)
    finally:
        process.kill()
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert re.search(rf"interrupted: \d of {SCENES} scenes stand in .*run the same command again", error)
        assert error.count("\n") == 1
    else:
        assert process.returncode == -signal.SIGKILL
    stood = {path: path.stat().st_mtime_ns for path in out.glob("scene_*/left.png")}
    assert 1 <= len(stood) < SCENES
    # As a kill between two files of a scene leaves it.
    (out / "scene_000003.partial").mkdir(exist_ok=True)
    (out / "scene_000003.partial" / "left.png").write_bytes(b"half")
    again = subprocess.run(command(*arguments), capture_output=True, text=True, timeout=300)
    assert again.returncode == 0, again.stderr
    assert f"({len(stood)} stood there already)" in again.stderr and "scenes/s" in again.stderr
    assert again.stdout == f"files   {files_checksum(dataset)}\nscenes  {scenes_checksum(dataset)}\n"
    finished = digests(out)
    finished.pop("README.md")
    assert finished == digests(dataset)
    assert {path: path.stat().st_mtime_ns for path in stood} == stood


def test_a_finished_set_is_left_as_it_is(dataset, tmp_path, capsys):
    copy = tmp_path / "copy"
    shutil.copytree(dataset, copy)
    # Nothing is to be rendered, so an unreachable cluster does not matter.
    arguments = ["make", copy, "--scenes", SCENES, "--seed", SEED, *ARGUMENTS, "--scheduler", "127.0.0.1:1"]
    assert main(list(map(str, arguments))) == 0
    out, error = capsys.readouterr()
    assert error == f"all {SCENES} scenes stood there already\n"
    assert out.startswith(f"files   {files_checksum(dataset)}\n")


def test_a_set_cannot_be_written_by_two_at_once(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    out = tmp_path / "set"
    out.mkdir()
    handle = os.open(out, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        refused = make(out, 1)
        assert refused.returncode == 3 and "another process is writing to it" in refused.stderr
        assert not list(out.iterdir())
    finally:
        os.close(handle)


def test_unusable_output_exits_with_3_and_is_left_alone(dataset, tmp_path, capsys):
    before = digests(dataset)
    (tmp_path / "file").write_text("mine")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("mine")
    for name, content in (("broken", "{"), ("deep", 100_000 * "["), ("list", "[]")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "dataset.json").write_text(content)
    (tmp_path / "readonly").mkdir(mode=0o500)
    cases = [
        (tmp_path / "file", SEED, 1, "is a file"),
        (tmp_path / "other", SEED, 1, "no dataset.json"),
        (tmp_path / "broken", SEED, 1, "not readable as JSON"),
        (tmp_path / "deep", SEED, 1, "not readable as JSON"),
        (tmp_path / "list", SEED, 1, "holds a list; expected a JSON object"),
        (dataset, SEED + 1, SCENES, "made with other options: seed 3; expected 4"),
        (dataset, SEED, 2, "expected at most 2 scenes"),
        (tmp_path / "file" / "set", SEED, 1, "Not a directory"),
    ]
    if os.geteuid() != 0:  # root may write everywhere
        cases.append((tmp_path / "readonly" / "set", SEED, 1, "Permission denied"))
    for out, seed, scenes, message in cases:
        assert main(["make", str(out), "--scenes", str(scenes), "--seed", str(seed), *ARGUMENTS]) == 3
        error = capsys.readouterr().err
        assert message in error and str(out) in error and error.count("\n") == 1, error
    assert digests(dataset) == before
    assert (tmp_path / "file").read_text() == "mine"
    assert os.listdir(tmp_path / "other") == ["notes.txt"]


@pytest.mark.parametrize("sheet", ["missing/sheet.png", "."])
def test_a_place_where_no_sheet_can_stand_is_refused_before_anything_is_rendered(sheet, tmp_path, capsys):
    arguments = [
        "make",
        tmp_path / "set",
        "--scenes",
        1,
        "--seed",
        1,
        *ARGUMENTS,
        "--sheet",
        tmp_path / sheet,
    ]
    assert main(list(map(str, arguments))) == 3
    assert "cannot be written" in capsys.readouterr().err
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize(
    "address, message",
    [
        ("127.0.0.1:1", "127.0.0.1:1: no Dask scheduler answers there"),
        ("127.0.0.1", "'127.0.0.1': not the address of a Dask scheduler; expected HOST:PORT"),
        ("", "'': not the address of a Dask scheduler"),
    ],
)
def test_a_scheduler_that_does_not_answer_exits_with_3_and_writes_nothing(address, message, tmp_path, capfd):
    pytest.importorskip("distributed", reason="needs the extra 'dask'")
    arguments = ["make", tmp_path / "set", "--scenes", 1, "--seed", 1, "--scheduler", address]
    start = time.monotonic()
    assert main(list(map(str, arguments))) == 3
    assert time.monotonic() - start < 60
    error = capfd.readouterr().err
    assert message in error and error.count("\n") == 1
    assert not (tmp_path / "set").exists()


def test_a_missing_dask_is_named_with_the_command_that_installs_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(WorkerError, match=r"pip install 'graspctx\[sim,dask\]'"):
        make_dataset(tmp_path / "set", 1, 1, scheduler="127.0.0.1:8786")
    assert not (tmp_path / "set").exists()


def test_checksum_is_what_the_shell_prints(dataset):
    listing = subprocess.run(
        "find dataset.json scene_* -type f | LC_ALL=C sort | xargs sha256sum | sha256sum",
        shell=True, cwd=dataset, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert listing.stdout == f"{files_checksum(dataset)}  -\n"


def test_checksums_see_what_they_are_for(dataset, tmp_path):
    def changed(change):
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(dataset, copy)
        change(copy)
        return files_checksum(copy) == files, scenes_checksum(copy) == scenes

    def edit(key, value):
        def change(copy):
            file = copy / "scene_000001" / "scene.json"
            info = json.loads(file.read_text())
            info["objects"][0][key] = value(info["objects"][0][key])
            file.write_text(json.dumps(info, indent=1) + "\n")

        return change

    files, scenes = files_checksum(dataset), scenes_checksum(dataset)
    assert changed(lambda copy: (copy / "README.md").write_text("a card")) == (True, True)
    assert changed(lambda copy: (copy / "scene_000001" / "left.png").write_bytes(b"")) == (False, True)
    assert changed(lambda copy: (copy / "scene_000001" / "left.png").rename(copy / "scene_000001" / "b")) == (
        False,
        True,
    )
    assert changed(edit("visible_px", lambda px: {"left": px["left"] + 1})) == (False, True)
    assert changed(edit("shape_seed", lambda seed: seed + 1)) == (False, False)
    assert changed(edit("cam_from_object", lambda m: (np.array(m) + 1e-5).tolist())) == (False, False)
    assert changed(edit("cam_from_object", lambda m: (np.array(m) + 1e-10).tolist())) == (False, True)
    assert changed(lambda copy: shutil.rmtree(copy / "scene_000003")) == (False, False)


def test_card_counts_what_is_there(dataset, records):
    text = card_text(dataset)
    entries = [entry for record in records for entry in record["objects"]]
    assert text.startswith(f"# {SCENES} stereo scenes of {len(entries)} objects\n")
    assert "make OUT --scenes 4 --seed 3 --families mug,pencil --objects 1-2 --resolution 160x120" in text
    for family in ("mug", "pencil"):
        mine = [entry for entry in entries if entry["family"] == family]
        cells = re.search(rf"^\| {family} \|(.*)\|$", text, re.MULTILINE)[1].split("|")
        holding = sum(any(entry["family"] == family for entry in record["objects"]) for record in records)
        seen = [sum(entry["label_px"][side] > 0 for entry in mine) for side in ("left", "right")]
        assert list(map(str.strip, cells[:5])) == [
            str(holding),
            str(len(mine)),
            str(len({entry["shape_seed"] for entry in mine})),
            str(len({entry["texture_seed"] for entry in mine})),
            f"{seen[0]} / {seen[1]}",
        ]
    bars = re.findall(r"^ *(\d+) to +(\d+) % +(\d+)", text, re.MULTILINE)
    shares = [entry["label_px"]["left"] / entry["visible_px"]["left"] for entry in entries]
    unhidden = [entry["visible_share"]["left"] for entry in entries]
    expected = [np.histogram(values, 10, (0, 1))[0].tolist() for values in (shares, unhidden)]
    assert [int(count) for _, _, count in bars] == expected[0] + expected[1]
    for name, of in (("table", SCENES), (r"pose \(object\)", len(entries))):
        table = re.search(rf"^\| {name} \| count .*\n\|.*\n((?:\|.*\n)+)", text, re.MULTILINE)[1]
        assert sum(int(row.split("|")[2]) for row in table.splitlines()) == of
    assert files_checksum(dataset) in text and scenes_checksum(dataset) in text


def test_card_counts_named_axes_whatever_they_are_called(dataset, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(dataset, copy)
    lights, distances = ["lamp", "sun", "lamp", "lamp"], [0.5, 0.8, 0.7, 0.6]
    for file, light, distance in zip(sorted(copy.glob("*/scene.json")), lights, distances):
        info = json.loads(file.read_text())
        info["axes"] = {"light": light, "distance_m": distance}
        for entry in info["objects"]:
            entry["axes"] = {"occluded": entry["id"] == 2}
        file.write_text(json.dumps(info))
    text = card_text(copy)
    assert "| lamp | 3 | 75 % |\n| sun | 1 | 25 % |" in text
    assert "| distance_m | 4 | 0.5 | 0.6 | 0.65 | 0.7 | 0.8 |" in text
    objects = [
        entry["id"] for file in copy.glob("*/scene.json") for entry in json.loads(file.read_text())["objects"]
    ]
    counts = collections.Counter(number == 2 for number in objects)
    assert f"| no | {counts[False]} |" in text and f"| yes | {counts[True]} |" in text


def test_card_tells_of_an_unfinished_set(dataset, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(dataset, copy)
    shutil.rmtree(copy / "scene_000002")
    assert "**Unfinished**: 1 scene missing" in card_text(copy)
    assert "Unfinished" not in card_text(dataset)


def test_every_family_has_its_rows_on_the_sheet(tmp_path):
    def scene(index, *families):
        return tmp_path / f"scene_{index}", {"objects": [{"family": family} for family in families]}

    scenes = [scene(0, "bowl")] + [scene(index, "mug", "pencil") for index in range(1, 40)]
    chosen = choose_scenes(scenes)
    assert list(chosen) == ["bowl", "mug", "pencil"]
    assert len(chosen["bowl"]) == 1 and len(chosen["mug"]) == len(chosen["pencil"]) == 6
    assert not {folder for folder, _ in chosen["mug"]} & {folder for folder, _ in chosen["pencil"]}
    # Where all scenes stand for others already, they are shown again.
    few = [scene(index, "mug", "pencil") for index in range(4)]
    assert {name: len(found) for name, found in choose_scenes(few).items()} == {"mug": 4, "pencil": 4}
    many = [scene(index, f"family{index % 30:02d}") for index in range(90)]
    assert {name: len(found) for name, found in choose_scenes(many).items()} == {
        f"family{number:02d}": 3 for number in range(30)
    }
    assert choose_scenes([scene(0)])["(no object)"]


def test_sheet_shows_pictures_beside_labels(dataset, tmp_path):
    write_sheet(dataset, tmp_path / "sheet.png")
    sheet = np.asarray(Image.open(tmp_path / "sheet.png")).astype(int)
    # Two families, a row of three tiles for each; the labels' red is on the right half of a tile alone.
    width = (sheet.shape[1] - 6) // 3
    red = (sheet[..., 0] > 150) & (sheet[..., 1] < 90) & (sheet[..., 2] < 120)
    for column in range(2):
        left = 6 + column * width
        assert red[:, left : left + 320].mean() < 0.02
        assert red[:, left + 320 : left + 640].sum() > 100


def test_sheet_of_a_single_scene(dataset, tmp_path):
    single = tmp_path / "single"
    shutil.copytree(dataset / "scene_000001", single / "scene_000001")
    assert main(["sheet", str(single), str(tmp_path / "sheet.png")]) == 0
    info = json.loads((dataset / "scene_000001" / "scene.json").read_text())
    tiles = len({entry["family"] for entry in info["objects"]})
    assert Image.open(tmp_path / "sheet.png").size == (6 + tiles * 646, 26 + 240 + 12)


def test_a_set_of_empty_tables_has_a_card_and_a_sheet(tmp_path):
    made = make(tmp_path / "set", 1, "--objects", "0", "--sheet", tmp_path / "sheet.png")
    assert made.returncode == 0, made.stderr
    assert "# 1 stereo scene of 0 objects\n" in (tmp_path / "set" / "README.md").read_text()
    assert Image.open(tmp_path / "sheet.png").size == (6 + 646, 26 + 240 + 12)


def test_overlay_outlines_instances_and_tints_labels():
    colour = np.full((6, 8, 3), 90, np.uint8)
    instances, label = np.zeros((6, 8), np.uint8), np.zeros((6, 8), np.uint8)
    instances[2:5, 2:6] = 1
    label[3, 3:5] = 255
    picture = overlay(colour, instances, label)
    assert (picture[0, 0] == 90).all()
    assert (picture[3, 3] != 90).all() and picture[3, 3, 0] > picture[3, 3, 1]
    assert (picture[1, 3] == [255, 255, 0]).all() and (picture[4, 3] == [255, 255, 0]).all()
    assert (colour == 90).all()


def test_disjoint_sets_and_shared_ones(dataset, tmp_path, capsys):
    assert make(tmp_path / "test", 2, "--split", "test").returncode == 0
    assert main(["disjoint", str(dataset), str(tmp_path / "test")]) == 0
    assert capsys.readouterr().out == ""
    few = tmp_path / "few"
    shutil.copytree(dataset / "scene_000001", few / "scene_000001")
    assert main(["disjoint", str(few), str(dataset)]) == 3
    out, error = capsys.readouterr()
    entries = json.loads((few / "scene_000001" / "scene.json").read_text())["objects"]
    expected = [f"shape    {entry['family']} {entry['shape_seed']}" for entry in entries]
    expected += [f"texture  {entry['texture_seed']}" for entry in entries]
    assert sorted(out.splitlines()) == sorted(expected)
    assert error.count("\n") == 1 and "expected none" in error


@pytest.mark.parametrize("name", ["checksum", "card", "sheet", "disjoint"])
@pytest.mark.parametrize("fault", ["missing", "empty", "broken", "no objects"])
def test_commands_that_read_name_what_is_wrong(name, fault, tmp_path, capsys):
    folder = tmp_path / "set"
    if fault != "missing":
        folder.mkdir()
    if fault in ("broken", "no objects"):
        (folder / "dataset.json").write_text('{"format": "graspctx-dataset", "version": 1}')
        (folder / "scene_000000").mkdir()
        (folder / "scene_000000" / "scene.json").write_text("{" if fault == "broken" else '{"objects": 3}')
    arguments = {"sheet": [folder, tmp_path / "sheet.png"], "disjoint": [folder, folder]}.get(name, [folder])
    code = main([name, *map(str, arguments)])
    if (name, fault) == ("checksum", "no objects"):  # sums whatever is there
        assert code == 0
        return
    assert code == 3
    error = capsys.readouterr().err
    assert str(folder) in error and error.count("\n") == 1
    assert not (tmp_path / "sheet.png").exists() and not (folder / "README.md").exists()


@pytest.mark.parametrize(
    "arguments, message",
    [
        ([], "COMMAND"),
        (["make"], "OUT"),
        (["make", "out", "--scenes", "0", "--seed", "1"], "'0' is not a whole number of at least 1"),
        (["make", "out", "--scenes", "x", "--seed", "1"], "'x' is not a whole number"),
        (["make", "out", "--scenes", "1"], "--seed"),
        (
            ["make", "out", "--scenes", "1", "--seed", "1", "--families", "mug,unicorn"],
            "unknown family 'unicorn'",
        ),
        (["make", "out", "--scenes", "1", "--seed", "1", "--objects", "3-2"], "'3-2' is not N or N-M"),
        (["make", "out", "--scenes", "1", "--seed", "1", "--resolution", "640"], "'640' is not WIDTHxHEIGHT"),
        (["make", "out", "--scenes", "1", "--seed", "1", "--colour", "1"], "--colour"),
        (["make", "out", "--scenes", "1", "--seed", "1", "--split", "dev"], "invalid choice: 'dev'"),
        (
            ["make", "out", "--scenes", "1", "--seed", "1", "--workers", "2", "--scheduler", "a:1"],
            "not allowed with argument",
        ),
    ],
)
def test_wrong_usage_exits_with_2(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_help_has_examples(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["make", "--help"])
    assert stopped.value.code == 0
    assert "examples:" in capsys.readouterr().out
