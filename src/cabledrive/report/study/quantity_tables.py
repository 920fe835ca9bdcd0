"""Tables of a study's quantities: what each adds to an error, and the plant of the worst run."""

from collections.abc import Mapping, Sequence

from cabledrive.report.blocks import Cell, Column, RowGroup, Table
from cabledrive.report.numbers import number
from cabledrive.studies.study.machine import UNITS, WORDS


def shares_table(caption: str, shares: Mapping[str, float], unit: str, size: float) -> Table:
    """Shares of each quantity, largest first, in a unit of a size in SI."""
    ordered = sorted(shares.items(), key=lambda item: -item[1])
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (named(name), number(share / size, 3)) for name, share in ordered
    )
    return Table(
        caption=caption,
        columns=(Column(title="Quantity"), Column(title="Share", unit=unit, numeric=True)),
        groups=(RowGroup(rows=rows),),
    )


def worst_plant_table(
    values: Mapping[str, float], best: Mapping[str, float], phases: Sequence[float]
) -> Table:
    """The plant of the worst run beside the best values, in SI; ``phases``: of the encoders, in counts."""
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            named(name),
            number(value, 5),
            number(best[name], 5) if name in best else "",
            unit_shown(UNITS[name]),
        )
        for name, value in values.items()
    )
    return Table(
        caption="The plant of the worst run.",
        columns=(
            Column(title="Quantity"),
            Column(title="Its value", numeric=True),
            Column(title="Best value", numeric=True),
            Column(title="Unit"),
        ),
        groups=(RowGroup(rows=rows),),
        note=f"Encoder phases in counts: {', '.join(f'{phase:+.2f}' for phase in phases)}.",
    )


def named(name: str) -> str:
    """A quantity at the head of a row."""
    return WORDS[name][:1].upper() + WORDS[name][1:]


def unit_shown(unit: str) -> str:
    """A unit in its column; nothing for a plain number."""
    return "" if unit == "1" else unit.replace("^2", "²")
