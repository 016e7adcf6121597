"""Reports and warm starts, as a user of the program meets them."""

import json
import re
import xml.etree.ElementTree as ElementTree

import pytest
from conftest import write_drawn_dataset


@pytest.fixture(scope="module")
def report(cli, drawn_dataset, tmp_path_factory):
    """A training with a report: folder, report as JSON."""
    folder = tmp_path_factory.mktemp("report")
    train(cli, drawn_dataset, folder / "drawn.safetensors", "--report", folder / "drawn.json")
    return folder, json.loads((folder / "drawn.json").read_text())


def train(cli, dataset, output, *options):
    result = cli("train", dataset, "--output", output, *options)
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    return json.loads(cli("info", output, "--json", "-").stdout)


def evaluate(cli, dataset, model):
    result = cli("evaluate", dataset, "--model", model, "--json", "-")
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)["classes"][-1]


def refused(result, *parts):
    assert result.returncode == 3, (result.stdout, result.stderr)
    assert len(result.stderr.splitlines()) == 1
    for part in parts:
        assert str(part) in result.stderr, result.stderr


# ---- Reports -----------------------------------------------------------------------------------------------


def test_a_report_tells_what_held_out_images_show(cli, report, drawn_dataset, trained_model):
    _, document = report
    assert document["schema"] == 1 and document["images"] == 12
    assert document["facts"]["data set"] == str(drawn_dataset)
    row = document["classes"][-1]
    assert row["views"] + row["views_without_label"] == 24
    assert row["patches"] == sum(part["patches"] for part in document["calibration"])
    assert row["label_prior"] < row["ap"] < evaluate(cli, drawn_dataset, trained_model)["ap"]
    for name, value in (("ap", row["ap"]), ("auc", row["auc"])):
        low, high = document["intervals"][name]
        assert low <= value <= high
    assert sum(part["views"] for part in document["label_shares"]) == 24
    assert {view["source"].split("/")[1] for view in document["worst"]} <= {"left", "right"}
    assert all((drawn_dataset / view["source"]).parent.is_dir() for view in document["worst"])
    images = [point["images"] for point in document["learning_curve"]]
    assert images == sorted(images) and images[-1] == round(12 * 4 / 5)
    assert document["learning_curve"][-1]["ap"] == row["ap"]


def test_a_report_changes_nothing_of_the_model(cli, report, drawn_dataset, trained_model):
    folder, _ = report
    differing = {}
    with_report, without = (
        json.loads(cli("info", file, "--json", "-").stdout)
        for file in (folder / "drawn.safetensors", trained_model)
    )
    for part in with_report:
        if with_report[part] != without[part]:
            differing[part] = {key for key in without[part] if with_report[part][key] != without[part][key]}
    assert differing == {"model": {"sha256"}, "provenance": {"command"}}
    assert with_report["provenance"]["command"].endswith("drawn.safetensors")


def test_html_reports_stand_alone(cli, report, drawn_dataset, tmp_path):
    _, document = report
    train(cli, drawn_dataset, tmp_path / "drawn.safetensors", "--report", tmp_path / "r.HTML")
    text = (tmp_path / "r.HTML").read_text()
    assert not re.search("<script|<link|<img|src=|href=|https?:|url\\(|@import", text)
    page = ElementTree.fromstring(text.removeprefix("<!DOCTYPE html>"))
    titles = [svg.find("title").text for svg in page.iter("svg")]
    assert titles == [
        "Precision against recall",
        "Reliability diagram",
        "Learning curve",
        "Top-1 by the visible share of the label",
    ]
    for element in page.iter():  # nothing is drawn outside of its picture
        for name in ("x", "cx"):
            assert 0 <= float(element.get(name, 0)) <= 430
        for name in ("y", "cy"):
            assert 0 <= float(element.get(name, 0)) <= 300
    words = " ".join(page.itertext())
    assert f"{document['classes'][-1]['ap']:.3f}" in words
    assert document["worst"][0]["source"] in words


def test_evaluate_writes_the_same_report_of_a_model(cli, trained_model, tmp_path):
    write_drawn_dataset(tmp_path / "others", scenes=6, seed=77)
    arguments = ["evaluate", tmp_path / "others", "--model", trained_model]
    for name in ("r.json", "again.json", "r.html"):
        result = cli(*arguments, "--report", tmp_path / name)
        assert result.returncode == 0 and "top-1" in result.stdout
    document = json.loads((tmp_path / "r.json").read_text())
    assert (tmp_path / "r.json").read_bytes() == (tmp_path / "again.json").read_bytes()
    assert document["classes"][-1] == evaluate(cli, tmp_path / "others", trained_model)
    assert document["learning_curve"] == []
    assert (tmp_path / "r.html").read_text().count("<svg") == 3


def test_a_report_that_cannot_be_written_ends_it_before_the_training(cli, drawn_dataset, tmp_path):
    output = tmp_path / "m.safetensors"
    place = tmp_path / "no" / "r.html"
    refused(cli("train", drawn_dataset, "--output", output, "--report", place), place)
    assert list(tmp_path.iterdir()) == []


# ---- Warm starts -------------------------------------------------------------------------------------------


def test_a_warm_start_remembers_its_base(cli, trained_model, tmp_path):
    write_drawn_dataset(tmp_path / "own", scenes=5, seed=31)
    facts = train(cli, tmp_path / "own", tmp_path / "own.safetensors", "--base", trained_model)
    base = json.loads(cli("info", trained_model, "--json", "-").stdout)
    provenance = facts["provenance"]
    assert provenance["base.name"] == "drawn" and provenance["base.sha256"] == base["model"]["sha256"]
    assert provenance["command"].endswith(f" --base {trained_model}")
    assert provenance["training.base_rows"] == str(base["svm"]["support_vectors"])
    assert facts["descriptor"] == base["descriptor"] and facts["svm"]["c"] == base["svm"]["c"]
    again = tmp_path / "again.safetensors"
    train(cli, tmp_path / "own", again, "--name", "own", "--base", trained_model)
    write_drawn_dataset(tmp_path / "test", scenes=6, seed=32)
    row = evaluate(cli, tmp_path / "test", tmp_path / "own.safetensors")
    assert row["ap"] > 2 * row["label_prior"]
    assert row == evaluate(cli, tmp_path / "test", again)


def test_the_base_s_descriptor_is_kept(cli, drawn_dataset, tmp_path):
    base = tmp_path / "paper.safetensors"
    train(cli, drawn_dataset, base, "--descriptor", "paper")
    facts = train(cli, drawn_dataset, tmp_path / "m.safetensors", "--base", base)
    assert facts["descriptor"]["outline_px"] == 0 and not facts["descriptor"]["refine_mask"]
    before = (tmp_path / "m.safetensors").read_bytes()
    arguments = ["train", drawn_dataset, "--output", tmp_path / "m.safetensors", "--base"]
    refused(cli(*arguments, base, "--descriptor", "robust"), "--descriptor robust", base, "no --descriptor")
    refused(cli(*arguments, "no_such_model"), "no_such_model")
    (tmp_path / "broken.safetensors").write_bytes(before[:-4])
    refused(cli(*arguments, tmp_path / "broken.safetensors"), tmp_path / "broken.safetensors")
    assert (tmp_path / "m.safetensors").read_bytes() == before


def test_a_shipped_model_takes_a_few_images(cli, tmp_path):
    write_drawn_dataset(tmp_path / "own", scenes=5, seed=41)
    facts = train(
        cli,
        tmp_path / "own",
        tmp_path / "own.safetensors",
        "--base",
        "mug",
        "--report",
        tmp_path / "own.json",
    )
    assert facts["classes"] == ["mug"] and facts["provenance"]["base.name"] == "mug"
    document = json.loads((tmp_path / "own.json").read_text())
    assert document["images"] == 5 and document["facts"]["base"] == "mug"
    assert document["classes"][-1]["views"] == 10  # none of the base's
