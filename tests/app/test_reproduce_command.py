"""`cabledrive reproduce`: what it writes, what it refuses, and that a finished run is not done again."""

import json

import pytest

from cabledrive.studies.reproduction import registry, run
from command import call, refusal

CHEAP = ("section-2-4", "table-6-1", "figure-6-1", "table-a-3")


@pytest.fixture(autouse=True)
def few(monkeypatch):
    chosen = tuple(entry for entry in registry.entries() if entry.name in CHEAP)
    monkeypatch.setattr(run, "entries", lambda: chosen)
    monkeypatch.setattr(run, "source_hash", lambda: "0" * 64)


def test_items_and_page_are_written_and_a_second_run_takes_what_is_finished(tmp_path):
    folder = tmp_path / "out"
    first = call("reproduce", "--quick", "-o", str(folder))
    assert first.exit_code == 0, first.stderr
    assert "1/4" in first.stderr
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    keys = {"id", "source", "printed", "computed", "unit", "deviation", "verdict", "note"}
    assert all(set(item) >= keys for item in data["items"])
    assert sum(data["counts"].values()) == len(data["items"])
    page = (folder / "report.html").read_text(encoding="utf-8")
    for item in data["items"]:
        assert item["verdict"] in page
    assert "Fig. 6.1" in page
    again = call("reproduce", "--quick", "--json", "-o", str(folder))
    assert "nothing has changed" in again.stderr
    assert json.loads(again.stdout)["items"] == data["items"]
    anew = call("reproduce", "--quick", "--force", "--json", "-o", str(folder))
    assert "1/4" not in anew.stderr
    assert json.loads(anew.stdout)["items"] == data["items"]
    assert "exists" in refusal("reproduce", "-o", str(folder))


def test_finished_results_are_not_replaced_unasked(tmp_path):
    (tmp_path / "results.json").write_text("{}")
    assert "exists" in refusal("reproduce", "-o", str(tmp_path))
    assert "does not exist" in refusal("reproduce", "-o", str(tmp_path / "a" / "b"))
