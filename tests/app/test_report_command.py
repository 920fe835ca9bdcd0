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
    path = tmp_path / "report.html"
    found = answer("report", "dissertation-1", "dissertation-2", "-o", path, "--quiet")
    assert found["report"] == str(path)
    assert [row["drive_hash"] for row in found["drives"]] == [
        cd.content_hash(cd.load_drive(name)) for name in ("dissertation-1", "dissertation-2")
    ]
    page = path.read_text(encoding="utf-8")
    for name, there in (("dissertation-1", True), ("dissertation-2", True), ("ropeway", False)):
        assert (typeset(cd.load_drive(name).title) in page) == there


def test_progress_goes_to_standard_error_and_quiet_stops_it(tmp_path):
    path = tmp_path / "a.html"
    shown = call("report", "dissertation-1", "-o", path)
    assert shown.stdout == f"written to {path}\n"
    assert shown.stderr
    quiet = call("report", "dissertation-1", "-o", path, "--force", "--quiet")
    assert (quiet.exit_code, quiet.stderr) == (0, "")
    assert os.listdir(tmp_path) == ["a.html"]
