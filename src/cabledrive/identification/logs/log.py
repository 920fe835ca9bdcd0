"""A log in memory: evenly sampled channels in SI, and what was found in them.

What every log format looks like from inside, and how much a packed one unpacks to.
"""

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest


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

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON has it."""
        return {
            "rows": self.rows,
            "duration": self.duration,
            "interval": self.interval,
            "jitter": self.jitter,
            "quantum": dict(self.quantum),
            "repaired": list(self.repaired),
            "findings": list(self.findings),
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Log:
    """Channels at even intervals."""

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
        if name not in self.channels:
            raise InputRefused(f'{self.source}: no channel "{name}"{nearest(name, self.channels)}')
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
            raise InputRefused(
                f"{self.source}: nothing between {first:.6g} s and {last:.6g} s, the log ends at "
                f"{self.time[-1]:.6g} s: choose a part of it"
            )
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
class Reading:
    """What a format has to know before it opens a file."""

    skip_rows: int = 0  # lines at the top of a text log that are not part of it
    # whether topics sampled at different times may be put onto the times of one of them
    resample: bool = False


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

    def require(self, name: str) -> str:
        """A column's name; refused, with the nearest, if it is not there."""
        if name not in self.names:
            raise InputRefused(f'{self.source}: no column "{name}"{nearest(name, self.names)}')
        return name


def check_lengths(lengths: Mapping[str, int], source: str) -> None:
    """Refuse columns of different lengths."""
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise InputRefused(f"{source}: channels differ in length ({found}): choose channels of one length")


def sliced(columns: dict[str, Array], rows: int = BLOCK_ROWS) -> Blocks:
    """Equally long columns in memory as blocks."""
    length = len(next(iter(columns.values()), ()))
    for start in range(0, length, rows):
        yield {
            name: np.asarray(values[start : start + rows], dtype=float) for name, values in columns.items()
        }


def floats_of(column: Any, name: str, starts: dict[str, int]) -> Array:
    """A column of Arrow or NumPy as doubles; times of a calendar in seconds from the first of the file.

    That is subtracted before a double rounds them. ``starts``: first of each column, in ticks, kept from
    block to block; a missing value is NaN.
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

CHUNK = 6
"""Opcode of a chunk of an MCAP file."""
LZ4_RATIO = 255
"""Bytes that one byte of LZ4 can unpack to."""


def require_fitting(path: Path, size: int) -> None:
    """Refuse a container that its library reads whole and that holds too much for that [bytes]."""
    if size > LARGEST_IN_MEMORY:
        raise too_large(path)


def too_large(path: Path) -> InputRefused:
    """Refusal of a container that unpacks to more than is read whole."""
    most = LARGEST_IN_MEMORY / 2**30
    return InputRefused(f"{path.name}: unpacks to more than {most:.0f} GiB: cut it into parts")


def unpacked_mcap(path: Path, limit: int = LARGEST_IN_MEMORY) -> int:
    """Bytes of the chunks of an MCAP file unpacked, as heads state them and LZ4 allows, to a limit."""
    total, end = 0, path.stat().st_size
    with path.open("rb") as file:
        file.seek(8)
        while total <= limit and len(head := file.read(9)) == 9:
            code, size = struct.unpack("<BQ", head)
            after = min(file.tell() + size, end)
            if code == CHUNK and len(start := file.read(32)) == 32:
                stated = struct.unpack("<QQQII", start)
                scheme = file.read(min(stated[4], 16))
                total += max(stated[2], size if scheme == b"" else 0)
                if scheme == b"lz4" and stated[2] > LZ4_RATIO * size:
                    return limit + 1
            file.seek(after)
    return total
