"""`cabledrive report` and `reproduce`: pages of what is named, finished runs that are not done again."""

import json
import os
import re

import pytest

import cabledrive as cd
from cabledrive.dissertation import registry, run
from cabledrive.report import writing
from cabledrive.report.typesetting import typeset
from command import answer, call, refusal


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


def test_progress_goes_to_standard_error_and_quiet_stops_it_and_a_page_is_kept_unless_forced(tmp_path):
    path = tmp_path / "a.html"
    shown = call("report", "dissertation-1", "-o", path)
    assert shown.stdout == f"written to {path}\n"
    assert shown.stderr
    path.write_text("precious")
    assert f"{path}: exists and is not overwritten" in refusal("report", "dissertation-1", "-o", path)
    assert path.read_text() == "precious"
    quiet = call("report", "dissertation-1", "-o", path, "--force", "--quiet")
    assert (quiet.exit_code, quiet.stderr) == (0, "")
    assert path.read_text() != "precious"
    assert os.listdir(tmp_path) == ["a.html"]


CHEAP = ("section-2-4", "table-6-1", "figure-6-1", "table-a-3")


@pytest.fixture(autouse=True)
def few(monkeypatch):
    chosen = tuple(entry for entry in registry.entries() if entry.name in CHEAP)
    monkeypatch.setattr(run, "entries", lambda: chosen)
    monkeypatch.setattr(run, "source_hash", lambda: "0" * 64)


def test_items_and_page_are_written_and_a_second_run_takes_what_is_finished(tmp_path, measured):
    folder = tmp_path / "out"
    first = call("reproduce", "--quick", "-o", str(folder))
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    page = (folder / "report.html").read_text(encoding="utf-8")
    again, anew = (
        call("reproduce", "--quick", *more, "--json", "-o", str(folder)) for more in ([], ["--force"])
    )
    done = [len(re.findall(r"\b\d/4\b", run.stderr)) for run in (first, again, anew)]
    measured(f"{done[0]} of 4 entries computed, {done[1]} in a second run, {done[2]} in one with --force")
    assert first.exit_code == 0, first.stderr
    assert "1/4" in first.stderr
    keys = {"id", "source", "printed", "computed", "unit", "deviation", "verdict", "note"}
    assert all(set(item) >= keys for item in data["items"])
    assert sum(data["counts"].values()) == len(data["items"])
    for item in data["items"]:
        assert item["verdict"] in page
    assert "Fig. 6.1" in page
    assert "finished run" in again.stderr
    assert json.loads(again.stdout)["items"] == data["items"]
    assert "1/4" not in anew.stderr
    assert json.loads(anew.stdout)["items"] == data["items"]
    assert "exists" in refusal("reproduce", "-o", str(folder))


def test_one_part_is_computed_alone_and_its_page_links_to_the_errata_it_holds(tmp_path):
    folder = tmp_path / "out"
    done = call("reproduce", "--quick", "--only", "Section 2.4", "--json", "-o", str(folder))
    assert done.exit_code == 0, done.stderr
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert (data["only"], {item["id"].rpartition("-")[0] for item in data["items"]}) == (
        "Section 2.4",
        {"section-2-4"},
    )
    page = (folder / "report.html").read_text(encoding="utf-8")
    links = set(re.findall(r'href="#(errata-[\w-]+)"', page))
    assert "errata-erratum-2-31-spacing" in links
    assert all(f'id="{link}"' in page for link in links)
    assert "reproduce --only" in page
    anew = call("reproduce", "--quick", "--only", "Fig. 6.1", "--force", "--json", "-o", str(folder))
    shown = json.loads(anew.stdout)
    assert "Fig. 6.1" in shown["calls"]
    assert all("Fig. 6.1" in item["source"] for item in shown["items"])
