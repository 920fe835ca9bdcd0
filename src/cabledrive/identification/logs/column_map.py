"""Which column is which channel: from a small TOML file, from the command line, or from the heads alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

from cabledrive.identification.logs.quantities import UNITS, quantity_with, recognise
from cabledrive.identification.logs.table import Table
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.toml_values import flag_of, quantity_of, table_of, whole_of

KEYS = ("columns", "sample_rate", "counts_per_revolution", "resample", "skip_rows", "start", "end")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Where a channel comes from.

    Attributes
    ----------
    column : str
        Column of the file.
    unit : str
        Its unit; empty: what the file states, else SI.
    scale : float or str
        Factor applied after the unit, or the name of a single number in the file.
    """

    column: str
    unit: str = ""
    scale: float | str = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnMap:
    """How a log is to be read.

    Attributes
    ----------
    columns : mapping of str to Column
        By channel; empty: recognised from the heads.
    sample_rate : float or None
        [Hz]; where the log has no time, or a coarse one.
    counts_per_revolution : int or None
    resample : bool
        Whether uneven samples may be put onto an even grid, and topics onto the times of one of them.
    skip_rows : int
        Lines at the top of a text log that are not part of it.
    start, end : float or None
        Part of the log to use [s].
    """

    columns: Mapping[str, Column] = field(default_factory=dict)
    sample_rate: float | None = None
    counts_per_revolution: int | None = None
    resample: bool = False
    skip_rows: int = 0
    start: float | None = None
    end: float | None = None


def column_map(table: Mapping[str, Any]) -> ColumnMap:
    """Read how a log is to be read from a table of TOML.

    Raises `InputRefused` if a key is unknown.
    """
    return ColumnMap(**_fields(table))


def _fields(table: Mapping[str, Any]) -> dict[str, Any]:
    for key in table:
        if key not in KEYS:
            raise InputRefused(f"log.{key}: unknown key{nearest(key, KEYS)}")
    columns = table_of("log.columns", table.get("columns", {}))
    found: dict[str, Any] = {"columns": {name: _column(name, entry) for name, entry in columns.items()}}
    for key, unit in (("sample_rate", "Hz"), ("start", "s"), ("end", "s")):
        if key in table:
            found[key] = quantity_of(f"log.{key}", table[key], unit)
    if "counts_per_revolution" in table:
        counts = table["counts_per_revolution"]
        found["counts_per_revolution"] = whole_of("log.counts_per_revolution", counts)
    if "resample" in table:
        found["resample"] = flag_of("log.resample", table["resample"])
    if "skip_rows" in table:
        found["skip_rows"] = whole_of("log.skip_rows", table["skip_rows"], least=0)
    if found.get("sample_rate", 1.0) <= 0.0:
        raise InputRefused(f"log.sample_rate = {found['sample_rate']:.4g} Hz must be above 0: give it in Hz")
    return found


def _column(name: str, entry: Any) -> Column:
    _known(name)
    if isinstance(entry, str):
        return Column(column=entry)
    if not isinstance(entry, Mapping) or "column" not in entry or set(entry) - {"column", "unit", "scale"}:
        raise InputRefused(f'log.columns.{name}: write {{column = "...", unit = "...", scale = 1.0}}')
    scale = entry.get("scale", 1.0)
    scale = scale if isinstance(scale, str) else quantity_of(f"log.columns.{name}.scale", scale, "1")
    return Column(column=str(entry["column"]), unit=str(entry.get("unit", "")), scale=scale)


def _known(name: str) -> None:
    if recognise(name) is None:
        raise InputRefused(f'"{name}" is no channel{nearest(name, UNITS)}')


def with_choices(
    base: ColumnMap, choices: Sequence[str], *, skip_rows: int | None = None, resample: bool = False
) -> ColumnMap:
    """Add choices of the command line, ``torque=tau:N mm``.

    ``choices``: ``CHANNEL=COLUMN[:UNIT[*SCALE]]``; ``skip_rows``: lines at the top that are not part of the
    log; default: as the base has it; ``resample``: true: allowed whatever the base has.
    Raises `InputRefused` if a choice has another form.
    """
    columns = dict(base.columns)
    for choice in choices:
        channel, equals, rest = choice.partition("=")
        if not equals or not rest:
            raise InputRefused(
                f'"{choice}" is no choice of a column: write CHANNEL=COLUMN:UNIT, as torque=tau:N mm'
            )
        _known(channel)
        column, _, unit = rest.partition(":")
        unit, _, scale = unit.partition("*")
        columns[channel] = Column(column=column, unit=unit.strip(), scale=_scale(scale))
    return replace(
        base,
        columns=columns,
        skip_rows=base.skip_rows if skip_rows is None else skip_rows,
        resample=base.resample or resample,
    )


def _scale(text: str) -> float | str:
    try:
        factor = float(text) if text else 1.0
    except ValueError:
        return text.strip()
    if not isfinite(factor):
        raise InputRefused(f'scale "{text.strip()}" must be finite: write a factor such as 0.001')
    return factor


def recognised_columns(table: Table) -> dict[str, Column]:
    """Channels that the heads of a file name.

    Raises `InputRefused` if two columns name one channel.
    """
    found: dict[str, Column] = {}
    for name in table.names:
        seen = recognise(name)
        if seen is None:
            continue
        if seen.channel in found:
            first = found[seen.channel].column
            raise InputRefused(
                f'{table.source}: columns "{first}" and "{name}" are both {seen.channel}: choose one'
            )
        found[seen.channel] = Column(column=name)
    return found


def other_channel(channel: str, quantity: str, unit: str, chosen: dict[str, Column]) -> InputRefused | None:
    """How to map a column whose unit is of another quantity than its head says, such as a position in deg.

    ``channel``: as the head or the map has it; ``quantity``: key of `UNITS`, of that channel; ``unit``: of
    the column; ``chosen``: all channels.
    Returns none: no other channel fits.
    """
    fitting = quantity_with(unit, quantity)
    renamed = channel.removesuffix(quantity) + (fitting or "")
    if fitting is None or renamed in chosen:
        return None
    names = [(renamed if name == channel else name, chosen[name].column) for name in chosen if name != "time"]
    mapped = " ".join(f'--column "{name}={column}"' for name, column in names[:3])
    return InputRefused(
        f'"{unit}" is a unit of {fitting}, {quantity} is in {" or ".join(UNITS[quantity])}: '
        f'head it "{renamed} [{unit}]", or map every channel: {mapped}'
    )
