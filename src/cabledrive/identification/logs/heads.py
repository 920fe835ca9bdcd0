"""Names and units of the columns of a text log, from the lines above its first row of numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

from cabledrive.identification.logs.cells import MISSING, is_number, split_line
from cabledrive.identification.logs.quantities import name_and_unit, recognise
from cabledrive.parameters import InputRefused

TWINCAT_INTERVAL = "SampleTime[ms]"
NO_UNIT = ("", "-", "(None)", "None")


@dataclass(frozen=True, slots=True, kw_only=True)
class Heads:
    """Columns of a text log.

    Attributes
    ----------
    names : tuple of str
    units : dict of str to str
    notes : tuple of str
        What a reader of the log has to know.
    """

    names: tuple[str, ...]
    units: dict[str, str]
    notes: tuple[str, ...] = ()


def heads_of(lines: Sequence[str], delimiter: str, decimal: str, row: Sequence[str]) -> Heads:
    """Find the heads among the lines above the first row of numbers; other lines there are metadata.

    The line that names most channels is the line of heads, also behind a comment sign; where none names
    any, the first of the last two lines that have as many cells as the numbers. A line of units may follow.

    ``lines``: above the first row of numbers; ``row``: cells of the first row of numbers.
    Raises `InputRefused` if two columns have one name.
    """
    width = len(row)
    plain = [(k, cells) for k, line in enumerate(lines) if (cells := _cells(line, delimiter, row, sign=""))]
    behind = [(k, cells) for k, line in enumerate(lines) if (cells := _cells(line, delimiter, row, sign="#"))]
    exported = _twincat([cells for _, cells in plain], width)
    if exported is not None:
        return exported
    best = max([*plain, *behind], key=lambda entry: _channels(entry[1]), default=None)
    if best is None or not _channels(best[1]):
        rest = plain[-2:] or (behind[-1:] if delimiter != " " else [])
        best = rest[0] if rest else None
    if best is None:
        return Heads(names=tuple(f"column {k + 1}" for k in range(width)), units={}, notes=())
    place, cells = best
    below = next((later for k, later in plain if k == place + 1), None)
    names, units = _names(cells, below, decimal)
    notes = _numbers_above(plain[[k for k, _ in plain].index(place) + 1 :] if best in plain else plain, row)
    return Heads(names=names, units=units, notes=notes)


def _cells(line: str, delimiter: str, row: Sequence[str], sign: str) -> list[str]:
    """Cells of a line that has as many as the numbers; the empty last cell of every row may be left out."""
    stripped = line.strip() if delimiter != "\t" else line.rstrip("\n")
    if not stripped.strip() or stripped.lstrip().startswith("#") != bool(sign):
        return []
    cells = split_line(stripped.lstrip().lstrip("#") if sign else stripped, delimiter)
    if len(cells) == len(row) - 1 and not row[-1]:
        cells.append("")
    return cells if len(cells) == len(row) else []


def _channels(cells: Sequence[str]) -> int:
    return sum(recognise(cell) is not None for cell in cells)


def _names(
    heads: Sequence[str], below: Sequence[str] | None, decimal: str
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Names and units from a line of heads, and perhaps one of units below it."""
    parted = [name_and_unit(head) for head in heads]
    names = tuple(name or f"column {k + 1}" for k, (name, _) in enumerate(parted))
    units = {name: unit for name, (_, unit) in zip(names, parted, strict=True) if unit}
    if below is not None and not units and not any(is_number(cell, decimal) for cell in below):
        units = {
            name: cell.strip("[]()") for name, cell in zip(names, below, strict=True) if cell.strip("[]()")
        }
    _require_different(names)
    return names, units


def _require_different(names: Sequence[str]) -> None:
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputRefused(f'two columns are called "{twice}": rename one')


def _numbers_above(lines: Sequence[tuple[int, Sequence[str]]], row: Sequence[str]) -> tuple[str, ...]:
    """Lines of text and numbers below the heads: what they hold in the columns of numbers is not read."""
    filled = [k for k, cell in enumerate(row) if cell not in MISSING]
    mixed = sum(
        any(is_number(cells[k], ".") or is_number(cells[k], ",") for k in filled) for _, cells in lines
    )
    if not mixed:
        return ()
    return (f"{mixed} lines above the first row of numbers hold text beside numbers and are not read",)


def _twincat(lines: Sequence[Sequence[str]], width: int) -> Heads | None:
    """Heads of a TwinCAT Scope export: rows of metadata by column, a time in ms before every group."""
    keys = [cells[0] for cells in lines]
    if TWINCAT_INTERVAL not in keys or "Name" not in keys:
        return None
    heads = lines[keys.index("Name")]
    starts = [k for k in range(width) if heads[k] == "Name"]
    names = [cell or f"column {k + 1}" for k, cell in enumerate(heads)]
    for number, k in enumerate(starts, start=1):
        names[k] = "time" if number == 1 else f"time of group {number}"
    _require_different(names)
    stated = lines[keys.index("Unit")] if "Unit" in keys else [""] * width
    units = {names[k]: stated[k] for k in range(width) if k not in starts and stated[k] not in NO_UNIT}
    units |= {names[k]: "ms" for k in starts}
    several = f"the file has {len(starts)} time columns, the first of them is taken for all channels"
    return Heads(names=tuple(names), units=units, notes=(several,) if len(starts) > 1 else ())
