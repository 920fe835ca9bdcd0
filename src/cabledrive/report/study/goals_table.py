"""Table of what was asked, for a load pulley and for a carriage."""

from cabledrive.report.blocks import Cell, Column, RowGroup, Table
from cabledrive.report.numbers import number
from cabledrive.studies.study import Goals


def goals_table(rows: list[tuple[Cell, ...]]) -> Table:
    """Goals beside their values; each row two cells."""
    return Table(
        caption="Goals.",
        columns=(Column(title="Goal"), Column(title="Value")),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def load_range(goals: Goals, otherwise: str) -> str:
    """Range of the load's inertia in words; ``otherwise`` where none was asked for."""
    if goals.load_inertia is None:
        return otherwise
    low, high = goals.load_inertia
    return f"{number(low, 4)} to {number(high, 4)} kg m²"
