"""`cabledrive study`: the contract's files and keys, its refusals, a second run from the cache."""

import re

import pytest

from command import answer, call, object_of
from report_page import Reader
from study_drives import FOLDER

WINCH = str(FOLDER / "winch.toml")
GOALS = '[goals]\nerror = "0.5 deg"\n[motion]\nangle = "30 deg"\nduration = "0.3 s"\ndwell = "0.1 s"\n'
FEW = "[acceptance]\ndraws = 300\ncable_draws = 0\n"


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished study of the turntable by its data sheet, with its answer."""
    folder = tmp_path_factory.mktemp("turntable")
    (folder / "study.toml").write_text(GOALS + FEW)
    arguments = ["study", str(FOLDER / "turntable.toml"), "--goals", str(folder / "study.toml")]
    return [*arguments, "-o", str(folder / "out")], folder / "out", answer(*arguments, "-o", folder / "out")


def test_the_report_needs_nothing_else_and_starts_with_the_verdict(finished, measured):
    _, out, found = finished
    text = (out / "report.html").read_text()
    page = Reader(text).root
    loaded = [e.attributes for tag in ("link", "img", "iframe", "script") for e in page.all(tag)]
    others = [one for one in loaded if one.get("src", one.get("href", "data:,")) != "data:,"]
    pictures = [e.attributes for e in page.all("div") if e.attributes.get("role") == "img"]
    measured(f"{len(text) / 1e6:.2f} MB, {len(pictures)} pictures, {len(others)} other files loaded")
    assert others == []
    assert not re.search(r"url\((?!#)", text)
    headings = [e.attributes["id"] for e in page.all("h2")]
    assert (headings[0], headings[-1]) == ("verdict-title", "provenance-title")
    assert len(pictures) >= 5
    assert all(one.get("aria-label") for one in pictures)
    assert len(text) < 15e6
    assert found["provenance"]["drive_hash"] in text


def test_a_second_run_is_served_and_changes_no_file(finished):
    arguments, out, found = finished
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*")}
    result = call(*arguments, "--json")
    assert "finished study" in result.stderr
    assert {**object_of(result.stdout), "provenance": 0} == {**found, "provenance": 0}
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*")} == before


def test_a_no_is_an_answer_and_not_a_failure(tmp_path, monkeypatch):
    monkeypatch.setattr("cabledrive.report.study.results.study_html", lambda result: "drawn elsewhere")
    (tmp_path / "hasty.toml").write_text(GOALS.replace("30 deg", "90 deg"))
    asked = ["--goals", tmp_path / "hasty.toml", "--quick", "--json"]
    result = call("study", WINCH, *asked, "-o", tmp_path / "out")
    found = object_of(result.stdout)
    assert (result.exit_code, found["verdict"]) == (0, "no")
    assert found["reasons"][0].startswith("torque")
    assert not (tmp_path / "out" / "controller.json").exists()
