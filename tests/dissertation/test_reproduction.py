"""The dissertation item by item: nothing is left out, every verdict has its reason."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from reproduction import reproduce
from reproduction.__main__ import command
from reproduction.chapter_6_rig import _numbers
from reproduction.errata_text import PAGE, errata_items
from reproduction.item import (
    AGREES,
    DIFFERS,
    ERRATUM,
    NOT_COMPARABLE,
    NOT_COMPUTABLE,
    UNEXPLAINED,
)
from reproduction.judge import compared, last_place
from reproduction.registry import FIGURES, SKETCHES, TABLES, entries
from reproduction.rig_runs import LAWS

from cabledrive.app.failures import status_of

ROOT = Path(__file__).parents[2]
PRINT = ROOT.parent / "shared" / "reference" / "dissertation.txt"
FOUR = ("section-2-4", "table-6-1", "figure-6-1", "table-a-3")
CHEAP = ("section-2-4", "table-3-1", "table-a-1", "table-a-2", "table-a-3", "section-4-1", "table-6-3")


def test_every_table_and_figure_of_the_print_has_an_entry():
    covered = [name for entry in entries() for name in entry.covers]
    missing = [name for name in (*TABLES, *FIGURES) if name not in covered]
    assert not missing
    twice = {name for name in covered if covered.count(name) > 1}
    assert not twice


@pytest.mark.shared_data
def test_tables_figures_and_sketches_are_all_that_the_print_has(measured):
    if not PRINT.exists():
        pytest.skip("../shared/reference/dissertation.txt is not there")
    text = PRINT.read_text(encoding="utf-8")
    figures = {f"Fig. {number}" for number in re.findall(r"^Figure (\d\.\d+)\.", text, flags=re.M)}
    tables = {f"Table {number}" for number in re.findall(r"^Table ([\dA]\.\d)\.", text, flags=re.M)}
    drawn = len(figures - set(SKETCHES))
    measured(f"{len(tables)} tables, {drawn} figures, {len(figures) - drawn} sketches in the print")
    assert figures == {*FIGURES, *SKETCHES}
    assert tables == set(TABLES)


@pytest.fixture(scope="module")
def cheap():
    chosen = [entry for entry in entries() if entry.name in CHEAP]
    assert len(chosen) == len(CHEAP)
    return [item for entry in chosen for item in entry.compute(True).items]


def test_every_reason_points_to_a_place_that_exists(cheap):
    for item in cheap:
        assert item.note, item.id
        assert set(re.findall(r"reproduction/errata\.md#([\w-]+)", item.note)) <= set(errata_items()), item.id


def test_a_number_agrees_inside_the_rounding_of_the_print_and_not_outside():
    assert compared("a", "s", "116", 116.49, "Hz").verdict == AGREES
    outside = compared("a", "s", "116", 116.51, "Hz")
    assert (outside.verdict, outside.note) == (DIFFERS, UNEXPLAINED)
    assert compared("a", "s", "116", 116.51, "Hz", otherwise=(ERRATUM, "why")).verdict == ERRATUM
    assert last_place("7.316e-6") == pytest.approx(1e-9)
    assert compared("a", "s", "4", 4.4, "", tolerance=0.5).deviation == pytest.approx(0.1)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_no_printed_accuracy_of_a_lost_pulse_is_judged_whichever_side_the_rig_is_on(law, factor, monkeypatch):
    """Both figures are given; the verdict does not depend on which is the larger."""
    monkeypatch.setattr("reproduction.chapter_6_rig._slower", lambda law: "none")
    monkeypatch.setattr("reproduction.chapter_6_rig._origin", lambda law, runs: None)
    peaks = np.full(3, factor * LAWS[law][2])
    run = SimpleNamespace(summary={"peak_torque": 0.1})
    (item,) = [one for one in _numbers(law, peaks, [run]) if one is not None and "accuracy" in one.id]
    assert (item.verdict, item.tested) == (NOT_COMPUTABLE, False)
    assert item.note.startswith(NOT_COMPARABLE)
    assert (item.printed, item.computed) == (LAWS[law][2], pytest.approx(factor * LAWS[law][2]))


def test_every_place_in_the_errata_is_an_item_that_the_page_can_show():
    known = errata_items()
    anchors = re.findall(r"^\(([\w-]+)\)=", PAGE.read_text(encoding="utf-8"), flags=re.M)
    assert anchors
    assert set(anchors) <= set(known)
    assert all(item.title and item.lines for item in known.values())


@pytest.mark.verify
@pytest.mark.parametrize("quick", [True, False])
def test_no_item_differs_without_a_cause(quick, measured):
    found = reproduce(quick=quick)
    verdicts = ", ".join(f"{count} {word}" for word, count in found.counts.items())
    measured(f"{len(found.items)} items: {verdicts}; {found.inputs} inputs")
    json.dumps(found.plain(), allow_nan=False)
    ids = [item.id for item in found.items]
    assert len(set(ids)) == len(ids)
    unexplained = [item for item in found.items if item.verdict == DIFFERS and UNEXPLAINED in item.note]
    assert not unexplained, unexplained
    for item in found.items:
        assert item.note, item.id
        without = item.computed is None or item.note.startswith(NOT_COMPARABLE)
        assert (item.verdict == NOT_COMPUTABLE) == without, item
        assert set(re.findall(r"reproduction/errata\.md#([\w-]+)", item.note)) <= set(errata_items()), item.id
    drawn = {panel.figure for _, outcome in found.outcomes for panel in outcome.panels}
    assert set(FIGURES) <= drawn, set(FIGURES) - drawn


@pytest.fixture
def reproduced(capsys, monkeypatch):
    """The program on four entries: status, standard output, standard error."""
    chosen = tuple(entry for entry in entries() if entry.name in FOUR)
    monkeypatch.setattr("reproduction.run.entries", lambda: chosen)
    monkeypatch.setattr("reproduction.run.source_hash", lambda: "0" * 64)

    def run(*arguments):
        status = status_of(lambda: command.main([*arguments], "reproduction", standalone_mode=False))
        return status, *capsys.readouterr()

    return run


def test_items_and_page_are_written_and_a_second_run_takes_what_is_finished(reproduced, tmp_path, measured):
    folder = tmp_path / "out"
    status, _, progress = reproduced("--quick", "-o", str(folder))
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert (status, "1/4" in progress) == (0, True)
    measured(f"{len(re.findall(r'[1-4]/4', progress))} of 4 entries computed, none in a second run")
    assert sum(data["counts"].values()) == len(data["items"])
    assert all(item["verdict"] in page for item in data["items"])
    for more, word in ([], "finished run"), (["--force"], "report"):
        _, shown, progress = reproduced("--quick", *more, "--json", "-o", str(folder))
        assert json.loads(shown)["items"] == data["items"]
        assert (word in progress, "1/4" in progress) == (True, False)
