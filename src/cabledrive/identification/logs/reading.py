"""From a file to a checked log: the format by its ending, the channels by their heads or a map; Parquet."""

import re
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs import time_check
from cabledrive.identification.logs.hierarchical import open_matlab, open_netcdf
from cabledrive.identification.logs.log import (
    BLOCK_ROWS,
    LARGEST_UNPACKED,
    Blocks,
    Column,
    ColumnMap,
    Log,
    Table,
    factor_to_si,
    floats_of,
    log_of,
    name_and_unit,
    other_channel,
    recognise,
    recognised_columns,
)
from cabledrive.identification.logs.messages import open_mcap, open_rosbag
from cabledrive.identification.logs.text import open_delimited
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.files import require_regular


def open_parquet(path: Path, reading: ColumnMap) -> Table:
    """Open a Parquet log."""
    from pyarrow import parquet, types

    file = parquet.ParquetFile(path)
    meta = file.metadata
    unpacked = sum(meta.row_group(k).total_byte_size for k in range(meta.num_row_groups))
    if max(unpacked, 8 * meta.num_rows) > LARGEST_UNPACKED:
        size, most = max(unpacked, 8 * meta.num_rows) / 2**30, LARGEST_UNPACKED / 2**30
        raise InputRefused(f"{path.name}: unpacks to {size:.0f} GiB, {most:.0f} GiB the most: split it")
    heads: dict[str, Any] = {}
    for entry in file.schema_arrow:
        name = name_and_unit(entry.name)[0]
        if name in heads:
            raise InputRefused(f'{path.name}: two columns are called "{name}": rename one')
        heads[name] = entry

    def read(names: tuple[str, ...]) -> Blocks:
        starts: dict[str, int] = {}
        rows, kinds = 0, ("floating", "integer", "timestamp", "duration")
        for name in names:
            if not any(getattr(types, f"is_{kind}")(heads[name].type) for kind in kinds):
                held = f'column "{name}" holds {heads[name].type}'
                raise InputRefused(f"{path.name}: {held}, not numbers: choose another column")
        wanted = [heads[name].name for name in names]
        for batch in file.iter_batches(batch_size=BLOCK_ROWS, columns=wanted, use_threads=False):
            rows += batch.num_rows
            yield {name: floats_of(batch.column(heads[name].name), name, starts) for name in names}
        if rows != meta.num_rows:
            raise InputRefused(f"{path.name}: is damaged ({rows} of {meta.num_rows} rows): write it again")

    units = {}
    for name, entry in heads.items():
        own = entry.metadata or {}
        stated = own.get(b"unit") or own.get(b"units")
        if unit := stated.decode(errors="replace") if stated else name_and_unit(entry.name)[1]:
            units[name] = unit
    return Table(source=path.name, names=tuple(heads), units=units, rows=meta.num_rows, read=read)


TEXTS = (".csv", ".tsv", ".txt", ".dat")
FORMATS: dict[str, Callable[[Path, ColumnMap], Table]] = {
    **dict.fromkeys(TEXTS, open_delimited),
    ".parquet": open_parquet,
    ".mat": open_matlab,
    ".nc": open_netcdf,
    ".h5": open_netcdf,
    ".mcap": open_mcap,
    ".db3": open_rosbag,
}
LONGEST_CAUSE = 110
TORQUE = re.compile(r"torq|drehm|moment|tau|trq")
"""What a head has of a torque."""


def open_table(path: str | Path, reading: ColumnMap | None = None, *, text: bool = False) -> Table:
    """Open a log file, as ``text`` whatever its ending is; what a library raises is an `InputRefused`."""
    path, reading = Path(path), reading or ColumnMap()
    require_regular(path, "give the path of a log")
    ending = ".csv" if text else path.suffix.lower()
    if ending not in FORMATS:
        raise InputRefused(f"{path.name}: logs end in {', '.join(FORMATS)}: unpack or rename it")
    if path.stat().st_size == 0:
        raise InputRefused(f"{path.name}: is empty: give a log with a header and rows of numbers")
    if reading.skip_rows and ending not in TEXTS:
        raise InputRefused(f"{path.name}: --skip-rows is for text logs ({', '.join(TEXTS)}): leave it out")
    with readable(path.name):
        table = FORMATS[ending](path, reading)
    if not table.names:
        raise InputRefused(f"{path.name}: holds no column of numbers: save the channels as vectors")

    def read(names: tuple[str, ...]) -> Blocks:
        blocks = iter(table.read(names))
        while True:
            with readable(path.name):
                block = next(blocks, None)
            if block is None:
                return
            yield block

    return replace(table, read=read)


@contextmanager
def readable(source: str) -> Iterator[None]:
    """Turn whatever a library raises over a file into one refusal; an interrupt comes through."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the libraries, about files that they read all the same
            yield
    except InputRefused:
        raise
    except MemoryError:
        raise InputRefused(
            f"{source}: is damaged, or holds more than fits into memory: write it again, in smaller parts"
        ) from None
    except Exception as error:  # libraries raise many kinds for a damaged file
        cause = re.sub(r"\s+", " ", getattr(error, "strerror", None) or str(error) or type(error).__name__)
        raise InputRefused(f"{source}: damaged or unreadable ({cause[:LONGEST_CAUSE]}): rewrite it") from None


MOST_VALUES = 60_000_000
"""Numbers that a log may hold in memory; longer ones are read in blocks, see `Recording`."""


@dataclass(frozen=True, slots=True)
class Recording:
    """A log file with its channels chosen, not read yet."""

    table: Table
    columns: dict[str, Column]  # by channel
    factors: dict[str, float]  # to SI
    units: dict[str, str]  # SI
    map: ColumnMap
    findings: tuple[str, ...] = ()

    def blocks(self, channels: tuple[str, ...] = ()) -> Iterator[dict[str, Array]]:
        """Channels in SI, all unless named, block by block, unchecked."""
        wanted = channels or tuple(self.columns)
        names = tuple(dict.fromkeys(self.columns[channel].column for channel in wanted))
        for block in self.table.read(names):
            with np.errstate(all="ignore"):  # what overflows is refused by its size
                scaled = {c: block[self.columns[c].column] * self.factors[c] for c in wanted}
            yield scaled


def open_log(path: str | Path, columns: ColumnMap | None = None) -> Recording:
    """Open a log and choose its channels, by default all that heads name; nothing but the head is read."""
    path = Path(path)
    columns = columns or ColumnMap()
    table = open_table(path, columns)
    chosen = dict(columns.columns)
    times = [name for name in table.names if recognise(name) == "time"]
    if chosen and "time" not in chosen and columns.sample_rate is None and len(times) == 1:
        chosen["time"] = Column(column=times[0])
    chosen = chosen if set(chosen) - {"time"} else recognised_columns(table) | chosen
    if not columns.columns and len(set(chosen) - {"time"}) < 1:
        like = next((name[:30] for name in table.names if TORQUE.search(name.lower())), "COLUMN")
        raise InputRefused(
            f"{path.name}: no column head names a channel (found: {', '.join(table.names)[:90]}): "
            f'write heads like "torque [N m]", or map each, as --column "torque={like}:N m"'
        )
    if "time" not in chosen and columns.sample_rate is None:
        raise InputRefused(f'{path.name}: no column "time [s]": map one, or give the sample rate')
    factors, units, findings = {}, {}, list(table.notes)
    for channel, column in chosen.items():
        table.require(column.column)
        quantity = recognise(channel).rpartition("_")[2]
        unit = column.unit or table.units.get(column.column, "")
        if not unit and channel not in columns.columns:
            findings.append(f'column "{column.column}" states no unit: taken as SI')
        try:
            factor, units[channel] = factor_to_si(quantity, unit, columns.counts_per_revolution)
        except InputRefused as refusal:
            other = other_channel(channel, quantity, unit, chosen)
            raise (other or refusal).at(f'{path.name}: column "{column.column}"') from None
        scale = table.scalars.get(column.scale) if isinstance(column.scale, str) else column.scale
        if scale is None:
            missing = f'no single number "{column.scale}" to scale "{column.column}" by'
            raise InputRefused(f"{table.source}: {missing}")
        factors[channel] = factor * scale
    return Recording(table, chosen, factors, units, columns, tuple(findings))


def read_log(path: str | Path, columns: ColumnMap | None = None) -> Log:
    """Read a log into memory and check it; nothing is resampled unless the map says so.

    Parameters
    ----------
    path : path-like
    columns : ColumnMap, optional

    Returns
    -------
    Log

    Raises
    ------
    InputRefused
        If the log cannot be read, is too long for memory, or has faults that are not repaired.
    """
    recording = open_log(path, columns)
    parts: dict[str, list[Array]] = {channel: [] for channel in recording.columns}
    size, rows = 0, recording.table.rows or 0
    too_long = InputRefused(
        f"{recording.table.source}: more than {MOST_VALUES} numbers, which are not held in memory: choose "
        "fewer channels with --column, or cut the log"
    )
    if rows * len(recording.columns) > 2 * MOST_VALUES:
        raise too_long
    for block in recording.blocks():
        size += sum(values.size for values in block.values())
        if size > MOST_VALUES:
            raise too_long
        for channel, values in block.items():
            parts[channel].append(values)
    if size == 0:
        raise InputRefused(f"{recording.table.source}: holds no row of numbers: record it again")
    return checked_log(recording, {channel: np.concatenate(values) for channel, values in parts.items()})


def checked_log(recording: Recording, channels: dict[str, Array], before: int = 0) -> Log:
    """Check channels in SI and put them onto their even grid; ``before``: rows of the file before these."""
    source, wanted = recording.table.source, recording.map
    time = channels.pop("time", None)
    if wanted.sample_rate is not None:
        rows = next(iter(channels.values())).size
        time = np.arange(before, before + rows) / wanted.sample_rate
    assert time is not None
    check = time_check.check_time(time, source, resample=wanted.resample)
    if check.uneven and not wanted.resample:
        raise InputRefused(
            f"{source}: time stamps are uneven (jitter {check.jitter:.2g} of {check.interval:.4g} s): "
            "add --resample, or give sample_rate in a table [log] if the stamps are wrong"
        )
    findings, repaired = [*recording.findings, *check.findings], check.repaired
    even: dict[str, Array] = {}
    quanta: dict[str, float] = {}
    flat: dict[str, NDArray[np.bool_]] = {}
    for name, values in channels.items():
        values = time_check.fill_holes(values, name, source, repaired)
        time_check.require_size(values, name, recording.units[name], source)
        quantum = time_check.quantum_of(values)
        if name.endswith("angle"):
            values = time_check.unwrap(values, name, quantum, repaired)
        values = even[name] = check.on_grid(values[check.keep])
        if quantum > 0.0:
            quanta[name] = quantum
        quantity = name.rpartition("_")[2]
        if np.ptp(values) == 0.0:
            findings.append(f"{name} is constant")
        elif quantity in ("angle", "position"):
            if jumps := time_check.lost_counts(values, quantum):
                findings.append(f"{name} jumps at {jumps} samples, as an encoder does that loses counts")
        elif quantity in ("torque", "force", "current", "voltage"):
            stands = time_check.saturated(values)
            if stands.any():
                flat[name] = stands
                share = 100 * stands.mean()
                findings.append(f"{name} stands at the end of its range for {share:.2g} % of the samples")
    if check.uneven:
        repaired.append("uneven samples put onto an even grid by straight lines, as asked")
    found = log_of(check.grid, even, {name: recording.units[name] for name in even}, source)
    report = replace(
        found.report,
        rows=int(time.size),
        interval=check.interval,
        jitter=check.jitter,
        quantum=quanta,
        repaired=tuple(repaired),
        findings=tuple(findings),
    )
    log = replace(found, report=report, saturated=flat)
    return log if wanted.start is None and wanted.end is None else log.part(wanted.start, wanted.end)
