"""From a file to a checked log: the format by its ending, the channels by their heads or a map."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs import time_check as channel_check
from cabledrive.identification.logs.column_map import (
    Column,
    ColumnMap,
    factor_to_si,
    other_channel,
    recognise,
    recognised_columns,
)
from cabledrive.identification.logs.log import DataReport, Log
from cabledrive.identification.logs.opening import open_table
from cabledrive.identification.logs.table import Reading, Table
from cabledrive.identification.logs.time_check import TimeCheck, check_time
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

MOST_VALUES = 60_000_000
"""Numbers that a log may hold in memory; longer ones are read in blocks, see `Recording`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """A log file with its channels chosen, not read yet.

    Attributes
    ----------
    table : Table
    columns : dict of str to Column
        By channel.
    factors : dict of str to float
        To SI.
    units : dict of str to str
        SI.
    map : ColumnMap
    findings : tuple of str
    """

    table: Table
    columns: dict[str, Column]
    factors: dict[str, float]
    units: dict[str, str]
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
    table = open_table(path, Reading(skip_rows=columns.skip_rows, resample=columns.resample))
    chosen = _with_time(dict(columns.columns), columns, table) or recognised_columns(table)
    if not columns.columns and len(set(chosen) - {"time"}) < 1:
        raise InputRefused(
            f"{path.name}: no column head names a channel (found: {', '.join(table.names)[:90]}): "
            f'write heads like "torque [N m]", or map each, as --column "torque={table.names[-1][:30]}:N m"'
        )
    if "time" not in chosen and columns.sample_rate is None:
        raise InputRefused(f'{path.name}: no column "time [s]": map one, or give the sample rate')
    factors, units, findings = {}, {}, list(table.notes)
    for channel, column in chosen.items():
        table.require(column.column)
        seen = recognise(channel)
        assert seen is not None
        unit = column.unit or table.units.get(column.column, "")
        if not unit and channel not in columns.columns:
            findings.append(f'column "{column.column}" states no unit: taken as SI')
        try:
            factors[channel], units[channel] = factor_to_si(
                seen.quantity, unit, columns.counts_per_revolution
            )
        except InputRefused as refusal:
            other = other_channel(channel, seen.quantity, unit, chosen)
            raise (other or refusal).at(f'{path.name}: column "{column.column}"') from None
        factors[channel] *= _scale(column, table)
    return Recording(
        table=table, columns=chosen, factors=factors, units=units, map=columns, findings=tuple(findings)
    )


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
    size = 0
    if (recording.table.rows or 0) * len(recording.columns) > 2 * MOST_VALUES:
        raise _too_long(recording)
    for block in recording.blocks():
        size += sum(values.size for values in block.values())
        if size > MOST_VALUES:
            raise _too_long(recording)
        for channel, values in block.items():
            parts[channel].append(values)
    if size == 0:
        raise InputRefused(f"{recording.table.source}: holds no row of numbers: record it again")
    channels = {channel: np.concatenate(values) for channel, values in parts.items()}
    return checked_log(recording, channels)


def _too_long(recording: Recording) -> InputRefused:
    return InputRefused(
        f"{recording.table.source}: more than {MOST_VALUES} numbers, which are not held in memory: choose "
        "fewer channels with --column, or cut the log"
    )


def checked_log(recording: Recording, channels: dict[str, Array], before: int = 0) -> Log:
    """Check channels in SI and put them onto their even grid.

    ``before``: rows of the file before these, where time is counted from the sample rate. Refused if a fault
    is found that is not repaired.
    """
    source = recording.table.source
    time = channels.pop("time", None)
    rate = recording.map.sample_rate
    if rate is not None:
        rows = next(iter(channels.values())).size
        time = np.arange(before, before + rows) / rate
    assert time is not None
    check = check_time(time, source, resample=recording.map.resample)
    if check.uneven and not recording.map.resample:
        raise InputRefused(
            f"{source}: time stamps are uneven (jitter {check.jitter:.2g} of {check.interval:.4g} s): "
            "add --resample, or give sample_rate in a table [log] if the stamps are wrong"
        )
    findings = [*recording.findings, *check.findings]
    repaired = check.repaired
    even: dict[str, Array] = {}
    quanta: dict[str, float] = {}
    flat: dict[str, NDArray[np.bool_]] = {}
    for name, values in channels.items():
        values = channel_check.fill_holes(values, name, source, repaired)
        channel_check.require_size(values, name, recording.units[name], source)
        quantum = channel_check.quantum_of(values)
        if name.endswith("angle"):
            values = channel_check.unwrap(values, name, quantum, repaired)
        even[name] = _on_grid(values[check.keep], check)
        _inspect(name, even[name], quantum, quanta, flat, findings)
    if check.uneven:
        repaired.append("uneven samples put onto an even grid by straight lines, as asked")
    grid = check.grid
    report = DataReport(
        rows=int(time.size),
        duration=float(grid[-1] - grid[0]),
        interval=check.interval,
        jitter=check.jitter,
        quantum=quanta,
        repaired=tuple(repaired),
        findings=tuple(findings),
    )
    units = {name: recording.units[name] for name in even}
    log = Log(source=source, time=grid, channels=even, units=units, report=report, saturated=flat)
    wanted = recording.map
    return log if wanted.start is None and wanted.end is None else log.part(wanted.start, wanted.end)


def _inspect(
    name: str,
    values: Array,
    quantum: float,
    quanta: dict[str, float],
    flat: dict[str, NDArray[np.bool_]],
    findings: list[str],
) -> None:
    if quantum > 0.0:
        quanta[name] = quantum
    if np.ptp(values) == 0.0:
        findings.append(f"{name} is constant")
        return
    quantity = name.rpartition("_")[2]
    if quantity in ("angle", "position"):
        jumps = channel_check.lost_counts(values, quantum)
        if jumps:
            findings.append(f"{name} jumps at {jumps} samples, as an encoder does that loses counts")
        return
    if quantity in ("torque", "force", "current", "voltage"):
        stands = channel_check.saturated(values)
        if stands.any():
            flat[name] = stands
            findings.append(
                f"{name} stands at the end of its range for {100 * stands.mean():.2g} % of the samples"
            )


def _on_grid(values: Array, check: TimeCheck) -> Array:
    if check.uneven:
        return np.interp(check.grid, check.stamps, values)
    if check.place.size == check.place[-1] + 1:
        return values
    return np.interp(np.arange(check.place[-1] + 1, dtype=float), check.place.astype(float), values)


def _with_time(chosen: dict[str, Column], columns: ColumnMap, table: Table) -> dict[str, Column]:
    """The mapped channels, with the time where the map does not name it and one head does."""
    times = [name for name in table.names if (seen := recognise(name)) and seen.channel == "time"]
    if chosen and "time" not in chosen and columns.sample_rate is None and len(times) == 1:
        chosen["time"] = Column(column=times[0])
    return chosen


def _scale(column: Column, table: Table) -> float:
    if not isinstance(column.scale, str):
        return float(column.scale)
    if column.scale not in table.scalars:
        raise InputRefused(f'{table.source}: no single number "{column.scale}" to scale "{column.column}" by')
    return table.scalars[column.scale]
