"""Which column is which channel, what it measures, and in which unit."""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

from cabledrive.identification.logs.log import Table
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.toml_values import flag_of, quantity_of, table_of, whole_of
from cabledrive.parameters.units import to_si

UNITS: dict[str, tuple[str, ...]] = {
    "time": ("s",),
    "torque": ("N m",),
    "force": ("N",),
    "angle": ("rad",),
    "position": ("m",),
    "velocity": ("rad/s", "m/s"),
    "acceleration": ("rad/s^2", "m/s^2"),
    "voltage": ("V",),
    "current": ("A",),
    "tension": ("N",),
}
"""Quantities by the last word of a channel's name, and the SI unit each may have."""

WORDS = {
    "t": "time",
    "timestamp": "time",
    "seconds": "time",
    "tau": "torque",
    "theta": "angle",
    "speed": "velocity",
    "omega": "velocity",
    "command": "voltage",
    "u": "voltage",
}
"""Other words for them."""


_UNIT = re.compile(r"^\s*(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")


def name_and_unit(head: str) -> tuple[str, str]:
    """Part a column head such as "torque [N m]" or "angle (deg)"; an empty unit where it states none."""
    match = _UNIT.match(head)
    return (match[1], match[2]) if match and match[1] else (head.strip(), "")


def recognise(head: str) -> str:
    """Channel, as "load_angle", that a head such as "Load angle (deg)" names; empty where it names none."""
    words = [word for word in re.split(r"[^a-z0-9]+", name_and_unit(head)[0].lower()) if word]
    quantity = WORDS.get(words[-1], words[-1]) if words else ""
    return "_".join([*words[:-1], quantity]) if quantity in UNITS else ""


def factor_to_si(quantity: str, unit: str, counts: int | None = None) -> tuple[float, str]:
    """Factor to SI, and the SI unit, of a column, empty if it is SI; ``counts``: of an encoder per turn."""
    options = UNITS[quantity]
    if not unit:
        return 1.0, options[0]
    if unit.lower() in ("count", "counts", "ticks", "cts"):
        if quantity != "angle" or counts is None:
            raise InputRefused(f"{quantity} in {unit}: give counts_per_revolution, and call it an angle")
        return to_si(f"{1.0 / counts:.17g} turn", "rad"), "rad"
    refusal: InputRefused | None = None
    for option in options:
        try:
            return to_si(f"1 {unit}", option), option
        except InputRefused as error:
            refusal = refusal or error
    raise InputRefused(f'{quantity} in "{unit}": {refusal}')


KEYS = ("columns", "sample_rate", "counts_per_revolution", "resample", "skip_rows", "start", "end")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """Where a channel comes from."""

    column: str  # column of the file
    unit: str = ""  # its unit; empty: what the file states, else SI
    scale: float | str = 1.0  # factor applied after the unit, or the name of a single number in the file


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnMap:
    """How a log is to be read."""

    # by channel; empty: recognised from the heads
    columns: Mapping[str, Column] = field(default_factory=dict)
    sample_rate: float | None = None  # [Hz]; where the log has no time, or a coarse one
    counts_per_revolution: int | None = None
    # whether uneven samples may be put onto an even grid, and topics onto the times of one of them
    resample: bool = False
    skip_rows: int = 0  # lines at the top of a text log that are not part of it
    # start, end: part of the log to use [s]
    start: float | None = None
    end: float | None = None


def column_map(table: Mapping[str, Any]) -> ColumnMap:
    """Read how a log is to be read from a table of TOML."""
    for key in table:
        if key not in KEYS:
            raise InputRefused(f"log.{key}: unknown key{nearest(key, KEYS)}")
    columns = table_of("log.columns", table.get("columns", {}))
    found: dict[str, Any] = {"columns": {name: _column(name, entry) for name, entry in columns.items()}}
    for key, unit in (("sample_rate", "Hz"), ("start", "s"), ("end", "s")):
        if key in table:
            found[key] = quantity_of(f"log.{key}", table[key], unit)
    for key, least in (("counts_per_revolution", 1), ("skip_rows", 0)):
        if key in table:
            found[key] = whole_of(f"log.{key}", table[key], least=least)
    if "resample" in table:
        found["resample"] = flag_of("log.resample", table["resample"])
    if found.get("sample_rate", 1.0) <= 0.0:
        raise InputRefused(f"log.sample_rate = {found['sample_rate']:.4g} Hz must be above 0: give it in Hz")
    return ColumnMap(**found)


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
    if not recognise(name):
        raise InputRefused(f'"{name}" is no channel{nearest(name, UNITS)}')


def with_choices(
    base: ColumnMap, choices: Sequence[str], *, skip_rows: int | None = None, resample: bool = False
) -> ColumnMap:
    """Add choices of the command line, ``CHANNEL=COLUMN[:UNIT[*SCALE]]``, as ``torque=tau:N mm``."""
    columns = dict(base.columns)
    for choice in choices:
        channel, equals, rest = choice.partition("=")
        if not equals or not rest:
            raise InputRefused(f'"{choice}" is no choice of a column: write CHANNEL=COLUMN[:UNIT]')
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
    """Channels that the heads of a file name; refused if two columns name one."""
    found: dict[str, Column] = {}
    for name in table.names:
        channel = recognise(name)
        if channel in found:
            first = found[channel].column
            raise InputRefused(f'{table.source}: columns "{first}" and "{name}" are {channel}: choose one')
        if channel:
            found[channel] = Column(column=name)
    return found


def other_channel(channel: str, quantity: str, unit: str, chosen: dict[str, Column]) -> InputRefused | None:
    """How to map a column whose unit is of another quantity than its head says, such as a position in deg."""
    fitting = ""
    for other in UNITS:
        with suppress(InputRefused):
            if not fitting and other != quantity and factor_to_si(other, unit):
                fitting = other
    renamed = channel.removesuffix(quantity) + fitting
    if not fitting or renamed in chosen:
        return None
    names = [(renamed if name == channel else name, chosen[name].column) for name in chosen if name != "time"]
    mapped = " ".join(f'--column "{name}={column}"' for name, column in names[:3])
    return InputRefused(
        f'"{unit}" is a unit of {fitting}, {quantity} is in {" or ".join(UNITS[quantity])}: '
        f'head it "{renamed} [{unit}]", or map every channel: {mapped}'
    )
