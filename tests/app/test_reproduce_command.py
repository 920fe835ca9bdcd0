"""`cabledrive reproduce`: what it writes, what it refuses, and that a finished run is not done again."""

import json
import re

import pytest

from cabledrive.dissertation import registry, run
from command import call, refusal

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


def test_finished_results_are_not_replaced_unasked(tmp_path):
    (tmp_path / "results.json").write_text("{}")
    assert "exists" in refusal("reproduce", "-o", str(tmp_path))
    assert "does not exist" in refusal("reproduce", "-o", str(tmp_path / "a" / "b"))


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


def test_a_part_that_is_not_there_is_refused_and_nothing_is_written(tmp_path):
    assert "is no part of the dissertation" in refusal(
        "reproduce", "--only", "Fig. 9.9", "-o", str(tmp_path / "new")
    )
    assert not (tmp_path / "new").exists()
