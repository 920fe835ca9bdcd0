"""`cabledrive report`: one page about the drives that are named, or about all packaged ones."""

import os

import pytest

import cabledrive as cd
from cabledrive.report import chapters
from cabledrive.report.typesetting import typeset
from command import answer, call, refusal


@pytest.fixture(autouse=True)
def few_chapters(monkeypatch):
    """The page without its long studies; with them the example of the command's help makes one."""
    chosen = tuple(entry for entry in chapters.registry() if entry.name == "what_moves_them")
    monkeypatch.setattr(chapters, "registry", lambda: chosen)


def test_page_holds_the_drives_that_are_named(tmp_path):
    path = tmp_path / "report.html"
    found = answer("report", "elevator", "finger-tendon", "-o", path, "--quiet")
    assert found["report"] == str(path)
    assert [row["drive_hash"] for row in found["drives"]] == [
        cd.content_hash(cd.load_drive(name)) for name in ("elevator", "finger-tendon")
    ]
    page = path.read_text(encoding="utf-8")
    for name, there in (("elevator", True), ("finger-tendon", True), ("ropeway", False)):
        assert (typeset(cd.load_drive(name).title) in page) == there


def test_progress_goes_to_standard_error_and_quiet_stops_it(tmp_path):
    shown = call("report", "finger-tendon", "-o", tmp_path / "a.html")
    quiet = call("report", "finger-tendon", "-o", tmp_path / "b.html", "--quiet")
    assert shown.stdout == f"written to {tmp_path / 'a.html'}\n"
    assert shown.stderr
    assert quiet.stderr == ""


def test_one_bad_drive_among_good_ones_leaves_no_page(tmp_path):
    line = refusal("report", "elevator", "elevater", "-o", tmp_path / "report.html")
    assert line.startswith("elevater: no such file")
    assert os.listdir(tmp_path) == []
