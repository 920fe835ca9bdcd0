"""The natural modes of a machine: tables, shapes, the count that proves the list complete."""

from collections.abc import Sequence

from cabledrive.modal import Mode, Modes
from cabledrive.modal.mode_rows import ModeRow, mode_rows
from cabledrive.parameters import Drive
from cabledrive.report.blocks import Cell, Column, Figure, RowGroup, Table
from cabledrive.report.figures.ladder import ladder_picture
from cabledrive.report.figures.shapes import shapes_picture
from cabledrive.report.numbers import decimals_for, fixed, number

SHOWN_SHAPES, SHOWN_ACROSS = 4, 6
_PARTS = ("drive pulley", "load pulley", "motor", "carriages", "cable")


def ladder(drive: Drive, name: str, modes: Modes) -> Figure | None:
    """The count of modes as a staircase; None where no longitudinal mode lies in its range."""
    if not any(mode.frequency < modes.certificate.below for mode in modes.longitudinal):
        return None
    picture = ladder_picture(f"ladder-{name}", drive, modes)
    bound = modes.certificate.below
    steps = ", ".join(f"{number(mode.frequency)} Hz" for mode in modes.longitudinal if mode.frequency < bound)
    below = f"{number(bound)} Hz"
    return picture.figure(
        name=f"ladder-{name}",
        alt=f"Staircase of the number of longitudinal modes below a frequency, up to {below}; it rises at "
        f"{steps}. Under it each mode as a rung, {len(modes.transverse)} of them transverse.",
        caption=f"Longitudinal modes, counted up to {below} (line) and listed (dots); under "
        "it, each mode of both kinds as a rung.",
    )


def along_table(modes: Modes) -> Table:
    """Longitudinal modes and the shares of their kinetic energy."""
    rows = [(mode, _shares(mode)) for mode in modes.longitudinal]
    parts = [part for part in _PARTS if any(part in shares for _, shares in rows)]
    decimals = _decimals([mode.frequency for mode, _ in rows])
    cells: list[tuple[Cell, ...]] = [
        (
            fixed(mode.frequency, decimals),
            f"{mode.family} ×{mode.multiplicity}" if mode.multiplicity > 1 else mode.family,
            *(shares.get(part, 0.0) for part in parts),
        )
        for mode, shares in rows
    ]
    return Table(
        caption="Longitudinal modes and their kinetic energy.",
        columns=(
            Column(title="Frequency", unit="Hz", numeric=True),
            Column(title="What moves"),
            *(Column(title=part.removesuffix(" pulley"), unit="%", bar=True) for part in parts),
        ),
        groups=(RowGroup(rows=tuple(cells)),),
    )


def _shares(mode: Mode) -> dict[str, float]:
    """Shares of the kinetic energy, all carriages taken together."""
    shares: dict[str, float] = {}
    for name, share in mode.kinetic_shares.items():
        part = "carriages" if name.startswith("carriage") else name
        shares[part] = shares.get(part, 0.0) + share
    return shares


def _decimals(frequencies: Sequence[float]) -> int:
    """Enough decimals for five digits of the lowest and seven of the highest."""
    return min(8, max(decimals_for(min(frequencies), 5), decimals_for(max(frequencies), 7)))


def across_table(modes: Modes) -> Table:
    """The lowest transverse modes."""
    rows = mode_rows(modes.transverse)
    decimals = _decimals([row.frequency for row in rows[:SHOWN_ACROSS]])
    more = f"The lowest {SHOWN_ACROSS} of {len(rows)} frequencies." if len(rows) > SHOWN_ACROSS else ""
    return Table(
        caption="Transverse modes.",
        columns=(
            Column(title="Frequency", unit="Hz", numeric=True),
            Column(title="Modes", numeric=True),
            Column(title="Where"),
            Column(title="Model"),
        ),
        groups=(RowGroup(rows=tuple(_across_cells(row, decimals) for row in rows[:SHOWN_ACROSS])),),
        note=more,
    )


def _across_cells(row: ModeRow, decimals: int) -> tuple[Cell, ...]:
    carried = "the carriages move; " if row.family == "carriage-dominated" else ""
    models = sorted({mode.model or "" for mode in row.modes})
    return fixed(row.frequency, decimals), str(row.count), carried + row.where, " and ".join(models)


def shapes(drive: Drive, name: str, modes: Modes) -> Figure:
    """The lowest mode shapes along the unrolled cable."""
    across = [row.modes[0] for row in mode_rows(m for m in modes.transverse if m.plane == "w")]
    shown = [*modes.longitudinal[:SHOWN_SHAPES], *across[:2]]
    picture = shapes_picture(f"shapes-{name}", drive, shown)
    seen = "; ".join(f"{number(m.frequency)} Hz, {m.family}" for m in shown)
    what = "drive to load" if drive.kind == "line" else "drive, load and back to the drive"
    return picture.figure(
        name=f"shapes-{name}",
        alt=f"Displacement along the unrolled cable in {len(shown)} modes: {seen}.",
        caption=f"Shapes of the lowest longitudinal and transverse modes along the unrolled cable ({what}). "
        "Dots are the rims of the pulleys, squares the carriages; the largest displacement is scaled to one.",
    )
