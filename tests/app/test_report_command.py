"""`cabledrive report`: pages of what is named."""

import os

import pytest

import cabledrive as cd
from cabledrive.report import writing
from cabledrive.report.typesetting import typeset
from command import answer, call


@pytest.fixture(autouse=True)
def no_study(monkeypatch):
    """The page without its long studies; with them the example of the command's help makes one."""
    monkeypatch.setattr(writing, "effect_of_parameters", lambda context: None)


def test_page_holds_the_drives_that_are_named(tmp_path):
    path, named = tmp_path / "report.html", ("dissertation-1", "dissertation-2")
    found = answer("report", *named, "-o", path, "--quiet")
    hashes = [cd.content_hash(cd.load_drive(name)) for name in named]
    assert [row["drive_hash"] for row in found["drives"]] == hashes
    page = path.read_text(encoding="utf-8")
    for name in (*named, "ropeway"):
        assert (typeset(cd.load_drive(name).title) in page) == (name in named)


def test_progress_goes_to_standard_error_and_quiet_stops_it(tmp_path):
    path = tmp_path / "a.html"
    shown = call("report", "dissertation-1", "-o", path)
    assert shown.stdout == f"written to {path}\n"
    assert shown.stderr
    quiet = call("report", "dissertation-1", "-o", path, "--force", "--quiet")
    assert (quiet.exit_code, quiet.stderr) == (0, "")
    assert os.listdir(tmp_path) == ["a.html"]
