"""The dissertation item by item: nothing is left out, every verdict has its reason."""

import json
import re
from pathlib import Path

import pytest
from reproduction import items, reproduce
from reproduction.__main__ import command
from reproduction.items import AGREES, DIFFERS, ERRATUM, NOT_COMPUTABLE, Row, entries, judge, last_place
from reproduction.page import ERRATA, errata_items

from cabledrive.app.failures import status_of

ROOT = Path(__file__).parents[2]
PRINT = ROOT.parent / "shared" / "reference" / "dissertation.txt"
FOUR = ("section-2-4", "table-6-1", "figure-6-1", "table-a-3")
CHEAP = ("section-2-4", "table-3-1", "table-a-1", "table-a-2", "table-a-3", "section-4-1", "table-6-3")


def numbered(chapter, *ranges):
    return [f"Fig. {chapter}.{number}" for low, high in ranges for number in range(low, high + 1)]


TABLES = tuple(
    f"Table {one}" for one in ("3.1", "3.2", "4.1", "4.2", "6.1", "6.2", "6.3", "A.1", "A.2", "A.3")
)
# Figures whose data the text defines, and sketches, schemes and photographs, which hold no data.
FIGURES = [*numbered(3, (1, 6), (8, 10)), *numbered(4, (6, 17), (19, 19), (21, 21)), *numbered(5, (2, 7))]
FIGURES += numbered(6, (1, 1), (3, 3), (5, 29))
SKETCHES = [*numbered(1, (1, 2)), *numbered(2, (1, 3)), *numbered(3, (7, 7), (11, 13)), *numbered(5, (1, 1))]
SKETCHES += [*numbered(4, (1, 5), (18, 18), (20, 20)), *numbered(6, (2, 2), (4, 4))]
EVERY = [entry for entry in entries() if entry.name in CHEAP]


def test_every_table_and_figure_of_the_print_has_an_entry():
    covered = [name for entry in entries() for name in entry.covers]
    missing = [name for name in (*TABLES, *FIGURES) if name not in covered]
    assert not missing
    assert len(set(covered)) == len(covered)


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


@pytest.mark.parametrize("entry", EVERY, ids=lambda one: one.name)
def test_items_have_a_verdict_and_a_reason_that_points_to_a_place_that_exists(entry):
    for item in entry.judged(True)[0]:
        assert item.note, item.id
        assert set(re.findall(r"reproduction/errata\.md#([\w-]+)", item.note)) <= set(errata_items()), item.id
        assert item.verdict != DIFFERS or item.id == "table-6-1-stiffness", item


def row(number, how="", **words):
    return Row(id="a", source="s", printed=number, unit="Hz", how=how, words=words)


def test_a_number_agrees_inside_the_rounding_of_the_print_and_not_outside():
    assert judge(row("116"), {"a": 116.49}).verdict == AGREES
    outside = judge(row("116"), {"a": 116.51})
    assert (outside.verdict, outside.note) == (DIFFERS, items.UNEXPLAINED)
    assert judge(row("116", erratum="why"), {"a": 116.51}).verdict == ERRATUM
    assert last_place("7.316e-6") == pytest.approx(1e-9)
    for how, found in (("within 0.5", 4.4), ("within 12 %", 4.4), ("", (4.4, 0.5))):
        assert judge(row("4", how), {"a": found}).deviation == pytest.approx(0.1)
        assert judge(row("4", how), {"a": found}).verdict == AGREES
    for lost in (row("4"), row("", printed="p", computed="c", agrees="why")):
        with pytest.raises(KeyError):
            judge(lost, {})


@pytest.mark.parametrize("found", [0.085, 0.34])
def test_no_printed_accuracy_of_a_lost_pulse_is_judged_whichever_side_the_rig_is_on(found):
    """Both figures are given; the verdict does not depend on which is the larger."""
    item = judge(row("0.17", **{NOT_COMPUTABLE: f"{items.NOT_COMPARABLE}: lost"}), {"a": found})
    assert (item.verdict, item.tested) == (NOT_COMPUTABLE, False)
    assert (item.printed, item.computed) == (0.17, found)


def test_every_place_in_the_errata_is_an_item_that_the_page_can_show():
    anchors = re.findall(r"^\(([\w-]+)\)=", ERRATA.read_text(encoding="utf-8"), flags=re.M)
    assert [anchor for anchor, (title, lines) in errata_items().items() if title and lines] == anchors


@pytest.mark.verify
@pytest.mark.parametrize("quick", [True, False])
def test_no_item_differs_without_a_cause(quick, measured):
    found = reproduce(quick=quick)
    verdicts = ", ".join(f"{count} {word}" for word, count in found.counts().items())
    assert [*found.counts().values()] == [167, 37, 5, 34]
    assert [*found.counts(untested=True).values()] == [68, 16, 0, 34]
    measured(f"{len(found.items)} items: {verdicts}; {found.inputs} inputs")
    json.dumps(found.plain(), allow_nan=False)
    ids = [item.id for item in found.items]
    assert len(set(ids)) == len(ids)
    unexplained = [item for item in found.items if item.verdict == DIFFERS and items.UNEXPLAINED in item.note]
    assert not unexplained, unexplained
    for item in found.items:
        assert item.note, item.id
        without = item.computed is None or item.note.startswith(items.NOT_COMPARABLE)
        assert (item.verdict == NOT_COMPUTABLE) == without, item
        assert set(re.findall(r"reproduction/errata\.md#([\w-]+)", item.note)) <= set(errata_items()), item.id
    drawn = {panel.figure for *_, panels in found.outcomes for panel in panels}
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
    for more in [], ["--force"]:
        _, shown, progress = reproduced("--quick", *more, "--json", "-o", str(folder))
        assert json.loads(shown)["items"] == data["items"]
        assert ("report" in progress, "1/4" in progress) == (True, False)
