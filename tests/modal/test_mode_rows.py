"""Rows of the mode table hold every mode once, whichever span comes out lower by round-off."""

import pytest

from cabledrive.modal import modes
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.parameters import load_drive, packaged_drives


@pytest.mark.parametrize("name", packaged_drives("loop", "line"))
def test_every_mode_stands_in_one_row_that_says_where_it_is(name):
    """Equal strings on both spans differ by round-off, so that either may be listed first."""
    found = modes(load_drive(name), count=12)
    rows = mode_rows(found)
    assert sum(row.count for row in rows) == sum(mode.multiplicity for mode in found.modes)
    for row in rows:
        spans = {mode.span for mode in row.modes}
        if row.kind == "transverse":
            message = "both spans" if len(spans) > 1 or spans == {"both"} else f"{spans.pop()} span"
            assert row.where.startswith(message)
        else:
            assert "%" in row.where


def test_equal_modes_of_both_spans_are_one_row_and_other_modes_are_not():
    found = modes(load_drive("dissertation-2", overrides=["layout.gravity=0"]), count=12).modes
    across = [mode for mode in found if mode.kind == "transverse"]
    rows = mode_rows(across)
    assert max(row.count for row in rows) == 4  # two spans, two planes
    assert len(rows) < len(across)
    for row in rows:
        first = row.modes[0].frequency
        assert all(mode.frequency == pytest.approx(first, rel=1e-6) for mode in row.modes)
