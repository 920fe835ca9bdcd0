"""A log in memory: evenly sampled channels in SI, and what was found in them.

What every log format looks like from inside, how much a packed one may unpack to; which column is which
channel, what it measures, and in which unit.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.answers.result import Result
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest, require_known
from cabledrive.parameters.toml_values import flag_of, quantity_of, table_of, whole_of
from cabledrive.parameters.units import to_si


@dataclass(frozen=True, slots=True, kw_only=True)
class DataReport:
    """What was found in a log, and what was repaired."""

    rows: int
    duration: float  # [s]
    interval: float  # time between samples [s]
    jitter: float = 0.0  # standard deviation of the time stamps about an even grid, in intervals
    # smallest step of each channel that has one, in SI
    quantum: Mapping[str, float] = field(default_factory=dict)
    repaired: tuple[str, ...] = ()  # what was changed, in words
    findings: tuple[str, ...] = ()  # what else a reader should know, in words


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Log(Result):
    """Channels at even intervals."""

    _table, _heading = "time: channels", "{0.source}"

    source: str  # name of the file, or what made it
    time: Array  # (samples,): [s]
    channels: Mapping[str, Array]  # in SI; every one as long as the time
    units: Mapping[str, str]  # SI units
    report: DataReport
    # samples at which a channel stands at the end of its range, where that was found
    saturated: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)

    @property
    def interval(self) -> float:
        """Time between samples [s]."""
        return self.report.interval

    @property
    def sample_rate(self) -> float:
        """Samples per second [Hz]."""
        return 1.0 / self.report.interval

    def __len__(self) -> int:
        return self.time.size

    def channel(self, name: str) -> Array:
        """One channel, shape (samples,); refused if the log has none of that name."""
        require_known(name, self.channels, f'{self.source}: no channel "{name}"')
        return self.channels[name]

    def having(self, channel: str, values: Array) -> "Log":
        """The log with other values (samples,) in one channel."""
        return replace(self, channels={**self.channels, channel: values})

    def part(self, start: float | None = None, end: float | None = None) -> "Log":
        """The log from one time [s] to before another; refused if nothing is left."""
        keep = np.ones(self.time.size, dtype=bool)
        if start is not None:
            keep &= self.time >= start - 0.5 * self.interval
        if end is not None:
            keep &= self.time < end - 0.5 * self.interval
        if keep.sum() < 2:
            first, last = 0.0 if start is None else start, self.time[-1] if end is None else end
            said = f"{self.source}: nothing between {first:.6g} s and {last:.6g} s"
            raise InputRefused(f"{said}, the log ends at {self.time[-1]:.6g} s: choose a part of it")
        return replace(
            self,
            time=self.time[keep],
            channels={name: values[keep] for name, values in self.channels.items()},
            saturated={name: values[keep] for name, values in self.saturated.items()},
            report=replace(self.report, rows=int(keep.sum()), duration=float(np.ptp(self.time[keep]))),
        )


def log_of(time: Array, channels: Mapping[str, Array], units: Mapping[str, str], source: str = "log") -> Log:
    """Put channels (samples,) that are in memory, and known to be even over time [s], together."""
    if any(np.shape(values) != np.shape(time) for values in channels.values()) or time.size < 3:
        raise InputRefused(f"{source}: needs at least 3 samples and channels as long as the time")
    interval = float(time[-1] - time[0]) / (time.size - 1)
    report = DataReport(rows=time.size, duration=float(time[-1] - time[0]), interval=interval)
    return Log(source=source, time=time, channels=dict(channels), units=dict(units), report=report)


Blocks = Iterator[dict[str, Array]]

BLOCK_ROWS = 1 << 20
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in a tick of a calendar time."""
LARGEST_UNPACKED = 16 * 2**30
"""Bytes that the columns of one compressed file may unpack to; more is refused as a possible bomb."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Columns of a log file."""

    source: str  # name of the file
    names: tuple[str, ...]  # Columns, as the file calls them
    units: dict[str, str]  # units that the file states, by column
    # number of rows; of a text log an estimate from its first lines; None where only reading shows it
    rows: int | None
    # ``read(names)`` yields blocks of equal columns; a missing value is NaN
    read: Callable[[tuple[str, ...]], Blocks]
    # single numbers in the file, such as a drive gain
    scalars: dict[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # what a reader of the log has to know about the file, in words

    def whole(self, names: tuple[str, ...], most: int) -> list[Array]:
        """Whole columns; refused before they fill the memory."""
        parts = [[np.empty(0)] * len(names)]
        for block in self.read(names):
            parts.append([block[name] for name in names])
            if sum(columns[0].size for columns in parts) > most:
                raise InputRefused(f"{self.source}: more than {most} rows: cut the file to one test")
        return [np.concatenate(columns) for columns in zip(*parts, strict=True)]

    def require(self, name: str) -> str:
        """A column's name; refused, with the nearest, if it is not there."""
        require_known(name, self.names, f'{self.source}: no column "{name}"')
        return name


def sliced(columns: dict[str, Array], rows: int = BLOCK_ROWS) -> Blocks:
    """Equally long columns in memory as blocks."""
    length = len(next(iter(columns.values()), ()))
    for start in range(0, length, rows):
        yield {
            name: np.asarray(values[start : start + rows], dtype=float) for name, values in columns.items()
        }


def floats_of(column: Any, name: str, starts: dict[str, int]) -> Array:
    """A column of Arrow or NumPy as doubles, NaN where missing; calendar times in seconds from the first.

    ``starts``: first of each column, in ticks, kept from block to block, subtracted before it is rounded.
    """
    if isinstance(column, np.ndarray):
        return np.asarray(column, dtype=float)
    import pyarrow as pa

    if not (pa.types.is_timestamp(column.type) or pa.types.is_duration(column.type)):
        return np.asarray(column.to_numpy(zero_copy_only=False), dtype=float)
    ticks = column.cast(pa.int64())
    missing = np.asarray(ticks.is_null().to_numpy(zero_copy_only=False), dtype=bool)
    whole = np.asarray(ticks.fill_null(0).to_numpy(zero_copy_only=False), dtype=np.int64)
    if name not in starts and not missing.all():
        starts[name] = int(whole[~missing][0])
    return np.where(missing, np.nan, (whole - starts.get(name, 0)) * TICKS[column.type.unit])


LARGEST_IN_MEMORY = 2**30
"""Bytes that a container may unpack to which its library can only read whole (MATLAB 5 to 7, MCAP)."""
LARGEST_CHUNK = 256 * 2**20
"""Bytes of one packed chunk of an HDF5 file, which is unpacked at once."""


def require_fitting(path: Path, size: int) -> None:
    """Refuse a container that its library reads whole and that holds too much for that [bytes]."""
    if size > LARGEST_IN_MEMORY:
        raise too_large(path)


def too_large(path: Path) -> InputRefused:
    """Refusal of a container that unpacks to more than is read whole."""
    most = LARGEST_IN_MEMORY / 2**30
    return InputRefused(f"{path.name}: unpacks to more than {most:.0f} GiB: cut it into parts")


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
        require_known(key, KEYS, f"log.{key}: unknown key")
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
