"""Logs that do not fit into memory: the same regression, block by block."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Identification
from cabledrive.identification.inverse_dynamics import Rows, factors_of, settling
from cabledrive.identification.logs.log import DataReport, Log
from cabledrive.identification.logs.reading import MOST_VALUES, Recording, checked_log
from cabledrive.identification.logs.table import BLOCK_ROWS
from cabledrive.identification.regression import Factors, joined, merged, suited_segments
from cabledrive.identification.regression_result import regression_result
from cabledrive.identification.rigid_axis import (
    AxisOptions,
    axis_method,
    channels_of,
    equation_for,
    kink_of,
    rows_for,
)
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

SEGMENTS_PER_BLOCK = 20
MOST_FACTORS = 960


def is_long(recording: Recording) -> bool:
    """Whether a log has to be read in blocks."""
    rows = recording.table.rows
    return rows is not None and rows * len(recording.columns) > MOST_VALUES


def identify_long_log(
    recording: Recording,
    options: AxisOptions | None = None,
    *,
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """Identify one rigid axis from a log of any length, in memory that does not grow with it.

    Bandwidth and encoder step come from the first block; every block is checked like a log of its own.

    ``recording``: with torque and angle, or force and position; nothing else is read; ``progress``: called
    with a line after every block.
    Raises `InputRefused` if a block is refused, nothing moves in any, or time jumps between two blocks.
    """
    options = options or AxisOptions()
    still: list[int] = []
    blocks = _moving(_checked_blocks(recording, progress), still)
    first = next(blocks, None)
    if first is None:
        raise InputRefused(f"{recording.table.source}: nothing moves in it: a log must move the axis")
    torque, position = channels_of(first, options)
    equation = equation_for([first], torque, position, options)
    plain = rows_for(first, torque, position, equation)
    equation = replace(equation, kink=kink_of(factors_of(plain, SEGMENTS_PER_BLOCK), equation))
    every = max(1, int(0.1 / (equation.bandwidth * first.interval)))
    reach = settling(equation.bandwidth, first.interval)
    parts: list[Factors] = []
    squares, rows = np.zeros(1), 0
    reports: list[DataReport] = []
    for block in _overlapping(first, blocks, reach):
        found: Rows = rows_for(block, torque, position, equation, every)
        parts.append(factors_of(found, SEGMENTS_PER_BLOCK))
        squares = squares + (found.regressors**2).sum(axis=0)
        rows += found.left.size
        reports.append(block.report)
        if sum(part.triangles.shape[0] for part in parts) > MOST_FACTORS:
            parts = [merged(joined(parts), 2)]
    factors = suited_segments(joined(parts))
    method = axis_method(equation, options, factors) | {"blocks": len(reports)}
    report = _whole(recording, reports, sum(still))
    return regression_result(factors, equation, np.sqrt(squares / rows), method, (), (report,))


def _checked_blocks(recording: Recording, progress: Callable[[str], None] | None) -> Iterator[Log]:
    wanted = tuple(c for c in recording.columns if c in ("time", "torque", "angle", "force", "position"))
    before, about = 0, recording.table.rows
    for block in _even_blocks(recording.blocks(wanted)):
        rows = next(iter(block.values())).size
        yield checked_log(recording, block, before)
        before += rows
        if progress is not None:
            share = f", about {100 * min(1.0, before / about):.0f} %" if about else ""
            progress(f"{recording.table.source}: {before} rows{share}")


def _even_blocks(blocks: Iterator[dict[str, Array]]) -> Iterator[dict[str, Array]]:
    """Blocks of `BLOCK_ROWS` rows, the last of up to twice as many: none is too short to be checked."""
    held: dict[str, Array] = {}
    for block in blocks:
        held = {name: np.concatenate([held[name], block[name]]) if held else block[name] for name in block}
        while next(iter(held.values())).size >= 2 * BLOCK_ROWS:
            yield {name: values[:BLOCK_ROWS] for name, values in held.items()}
            held = {name: values[BLOCK_ROWS:] for name, values in held.items()}
    if held:
        yield held


def _moving(blocks: Iterator[Log], still: list[int]) -> Iterator[Log]:
    """Blocks in which the axis moves and is driven; the rows of the others are counted."""
    for block in blocks:
        if any(np.ptp(values) == 0.0 for values in block.channels.values()):
            still.append(block.time.size)
        else:
            yield block


def _overlapping(first: Log, blocks: Iterator[Log], reach: int) -> Iterator[Log]:
    """Every block with the end of the one before, since the filter's ends are cut off."""
    yield first
    before = first
    for block in blocks:
        step = (block.time[0] - before.time[-1]) / before.interval
        if abs(step - 1.0) > 0.5:
            raise InputRefused(f"{block.source}: time jumps at {before.time[-1]:.6g} s: cut the log there")
        joint = {
            name: np.concatenate([before.channels[name][-2 * reach :], values])
            for name, values in block.channels.items()
        }
        time = np.concatenate([before.time[-2 * reach :], block.time])
        flat = {
            name: np.concatenate([_flat(before, name)[-2 * reach :], _flat(block, name)]) for name in joint
        }
        yield replace(block, time=time, channels=joint, saturated=flat)
        before = block


def _flat(block: Log, channel: str) -> NDArray[np.bool_]:
    """Samples at which a channel saturates."""
    return block.saturated.get(channel, np.zeros(block.time.size, dtype=bool))


def _whole(recording: Recording, reports: list[DataReport], still: int) -> DataReport:
    rows = sum(report.rows for report in reports)
    rest = (f"{still} rows in blocks in which nothing moves are left out",) if still else ()
    interval = float(np.mean([report.interval for report in reports]))
    return DataReport(
        rows=rows,
        duration=(rows - 1) * interval,
        interval=interval,
        jitter=max(report.jitter for report in reports),
        quantum=reports[0].quantum,
        repaired=tuple(dict.fromkeys(line for report in reports for line in report.repaired)),
        findings=tuple(dict.fromkeys(line for report in reports for line in report.findings)) + rest,
    )
