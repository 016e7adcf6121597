"""What the benchmarks share: intervals against known values, rows, tables, exit codes, processes."""

import json
import math
import sys
import time
from pathlib import Path

import graspctx as gc
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))
import report


def test_shares_have_wilsons_interval():
    # Wilson 1927 for 8 of 10, and none of 20: (p + z²/2n ± z √(p(1-p)/n + z²/4n²)) / (1 + z²/n), z = 1.96.
    assert report.share(8, 10) == pytest.approx((0.8, 0.490, 0.943, 10), abs=1e-3)
    none = report.share(0, 20)
    assert (none.value, none.n) == (0, 20) and none.low == pytest.approx(0, abs=1e-9)
    assert none.high == pytest.approx(1.96**2 / (20 + 1.96**2), abs=1e-3)
    assert report.share(np.int64(20), 20).high == pytest.approx(1, abs=1e-9)


def test_the_bootstrap_of_a_mean_is_as_wide_as_its_standard_error():
    values = np.random.default_rng(3).normal(5, 2, 400)
    mean = report.bootstrap(values, np.mean)
    assert mean.value == pytest.approx(values.mean()) and mean.n == 400
    half = 1.96 * values.std() / math.sqrt(400)
    assert mean.low == pytest.approx(values.mean() - half, abs=0.15 * half)
    assert mean.high == pytest.approx(values.mean() + half, abs=0.15 * half)
    assert report.bootstrap(values, np.mean) == mean  # seeded
    assert report.bootstrap([7.0], np.median) == (7, 7, 7, 1)


def test_the_bootstrap_draws_things_with_all_their_values():
    # Two objects of 50 equal values each: a resample is all 0, all 1 or half and half, never in between.
    values = np.repeat([[0.0], [1.0]], 50, axis=1)
    mean = report.bootstrap(values, np.mean)
    assert mean == (0.5, 0.0, 1.0, 2)


def test_no_false_object_in_a_few_scenes_proves_little():
    assert report.rate([0] * 20) == pytest.approx((0, 0, 3.689 / 20, 20), abs=1e-3)
    some = report.rate([0, 2, 0, 0])
    assert (some.value, some.low) == (0.5, 0) and some.high > 1


def test_rows_and_the_json_file(tmp_path):
    row = report.row("recall", report.share(9, 10), cues="colour", axis="all")
    assert list(row) == ["measure", "cues", "axis", "value", "low", "high", "n"]
    file = tmp_path / "result.json"
    report.write_json(file, "segmentation", 7, [row], split="test")
    content = json.loads(file.read_text())
    assert (content["benchmark"], content["seed"], content["rows"]) == ("segmentation", 7, [row])
    assert content["split"] == "test" and "graspctx" in content["ran_on"]
    assert list(tmp_path.iterdir()) == [file]


def test_a_place_that_takes_no_file_is_refused(tmp_path):
    report.check_place(None)
    report.check_place(tmp_path / "fine.json")
    for place in (tmp_path, tmp_path / "absent" / "result.json"):
        with pytest.raises(report.BadInputError, match="expected a file name in a folder that exists"):
            report.check_place(place)


def test_tables_are_markdown_and_aligned():
    text = report.table(["axis", "n"], [["all", 120], ["a longer one", 5]])
    assert text.splitlines() == [
        "| axis         |   n |",
        "| ------------ | --: |",
        "| all          | 120 |",
        "| a longer one |   5 |",
    ]
    assert report.figure(report.Estimate(0.934, 0.88, 0.96, 100)) == "0.93 [0.88, 0.96]"
    assert report.figure(report.Estimate(12.3, None, None, 4), 1) == "12.3"
    assert report.figure(None) == "-"


def test_what_the_user_can_mend_is_one_line(capsys):
    def raises(error):
        def command():
            raise error

        return command

    assert report.run("name.py", lambda: None) == 0
    for error, code in [
        (report.BadInputError("a.json: cannot be written"), 3),
        (gc.InvalidInput("calib.txt: missing"), 3),
        (FileNotFoundError(2, "No such file or directory", "left.png"), 3),
        (KeyboardInterrupt(), 130),
    ]:
        assert report.run("name.py", raises(error)) == code
        printed = capsys.readouterr()
        assert printed.err.startswith("name.py: ") and printed.err.count("\n") == 1 and not printed.out


def test_worker_processes_keep_the_order():
    items = [4.0, 9.0, 16.0]
    assert list(report.spread(math.sqrt, items, workers=1)) == [2, 3, 4]
    assert list(report.spread(math.sqrt, items, workers=2)) == [2, 3, 4]


def test_progress_off_a_terminal_is_the_last_line(capsys):
    progress = report.Progress("segment", 3)
    for done in (1, 2, 3):
        progress.show(done)
    printed = capsys.readouterr().err
    assert printed.count("\n") == 1 and printed.startswith("segment: 3 of 3, ")


def test_progress_tells_how_long_it_takes(capsys, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    progress = report.Progress("segment", 4)
    now[0] += 40
    progress.show(1)
    assert capsys.readouterr().err == "segment: 1 of 4, 40 s, 120 s left\n"
