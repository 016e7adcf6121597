"""Every command and every example of the README and the documents below runs, in their order."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"(<!-- test: skip.*-->\n)?^```(sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


DOCUMENTS = ("README.md", "docs/segmentation.md", "docs/explain.md")


def blocks():
    for document in DOCUMENTS:
        text = (ROOT / document).read_text(encoding="utf-8")
        for match in BLOCK.finditer(text):
            skip, language, code = match.groups()
            if not skip:
                line = text.count("\n", 0, match.start()) + 1
                yield pytest.param(language, code, id=f"{document} {line}: {code.splitlines()[0]}")


@pytest.fixture(scope="module")
def workplace(tmp_path_factory):
    """What a reader has in front of them, without writing into the repository."""
    folder = tmp_path_factory.mktemp("readme")
    for name in ("examples", "models", "docs"):
        (folder / name).symlink_to(ROOT / name)
    (folder / "out").mkdir()
    return folder


@pytest.fixture(scope="module")
def environment(cli_path, tmp_path_factory):
    """The reader's PATH: the program, and the Python that has the package."""
    folder = tmp_path_factory.mktemp("bin")
    (folder / "graspctx_cli").symlink_to(cli_path)
    python = folder / "python"  # no symbolic link: a virtual environment is found by the path it is called by
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', encoding="utf-8")
    python.chmod(0o755)
    return {**os.environ, "PATH": f"{folder}{os.pathsep}{os.environ['PATH']}"}


@pytest.mark.parametrize(("language", "code"), list(blocks()))
def test_block_runs(language, code, workplace, environment):
    command = ["bash", "-euc", code] if language == "sh" else [sys.executable, "-c", code]
    done = subprocess.run(
        command, cwd=workplace, env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("document", DOCUMENTS)
def test_links_lead_to_files_that_exist(document):
    folder = (ROOT / document).parent
    links = re.findall(r"\]\((?!https?:)([^)#]+)", (ROOT / document).read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if not (folder / link).exists()] == []
