"""The laws of a study under one acceptance test, loads and carriages alike."""

from collections.abc import Sequence

from cabledrive.parameters.fields import percent
from cabledrive.report.blocks import Cell, Column, RowGroup, Table
from cabledrive.report.numbers import number
from cabledrive.studies.study.candidates import LawScore


def laws_table(scores: Sequence[LawScore], unit: str, size: float) -> Table:
    """Every law, simplest first, with its errors and the share of the plants it holds within the goal."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(_row(one, size) for one in scores)
    return Table(
        caption="Laws tried, simplest first.",
        columns=(
            Column(title="Law"),
            Column(title="Setting"),
            Column(title="Runs", numeric=True),
            Column(title="99 %", unit=unit, numeric=True),
            Column(title="Worst", unit=unit, numeric=True),
            Column(title="In goal", numeric=True),
            Column(title="At least", numeric=True),
            Column(title="Ended early", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note="; ".join(f"{one.controller}: {one.reason}" for one in scores if one.reason),
    )


def _row(one: LawScore, size: float) -> tuple[Cell, ...]:
    def shown(error: float | None) -> str:
        return "" if error is None else number(error / size, 3)

    def inside(share: float | None) -> str:
        return "" if share is None else percent(share)

    reached = one.reached.error if one.reached else None
    errors = (shown(reached), shown(one.worst))
    return (
        one.controller,
        one.setting,
        f"{one.runs}",
        *errors,
        inside(one.share),
        inside(one.share_low),
        f"{one.failed}",
    )
