"""The door of the room: from logs, however long, to parameters with intervals and a check."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from cabledrive.identification import estimates
from cabledrive.identification.axis.answer import IdentifyOptions, answer, timed, without_outliers
from cabledrive.identification.axis.axis import AxisOptions, Rows, axis_of, channels_of
from cabledrive.identification.axis.check import NOT_MADE
from cabledrive.identification.axis.equation import FILTERS, FRICTIONS, PRINTED_SLOPE, FrictionModel, settling
from cabledrive.identification.axis.timing import TIMINGS, given_timing, timing_of
from cabledrive.identification.estimates import Factors, Finding, Identification
from cabledrive.identification.logs.log import BLOCK_ROWS, DataReport, Log, column_map
from cabledrive.identification.logs.reading import MOST_VALUES, Recording, checked_log, open_log, read_log
from cabledrive.identification.two_inertia import NAME as TWO_INERTIA
from cabledrive.identification.two_inertia import identify_two_inertia
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import LARGEST, SMALLEST, require_known
from cabledrive.parameters.toml_values import flag_of, quantity_of, read_toml, table_of, text_of

SEGMENTS_PER_BLOCK = 20
MOST_FACTORS = 960
NO_SERVO = 0.5
"""Interval from which a log is refused: its time has another unit [s]."""


def is_long(recording: Recording) -> bool:
    """Whether a log has to be read in blocks."""
    rows = recording.table.rows
    return rows is not None and rows * len(recording.columns) > MOST_VALUES


def identify_long_log(
    recording: Recording,
    options: IdentifyOptions | None = None,
    *,
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """One rigid axis by blocks, memory not growing; the first gives bandwidth, count and torque's instant."""
    options, axis, every, reach = options or IdentifyOptions(), None, 1, [0]
    known = options.torque != "found"
    parts, reports, findings = list[Factors](), list[DataReport](), list[Finding]()
    squares, used, rows, still = np.zeros(1), 0, 0, 0
    for block, fresh in _checked_blocks(recording, reach, progress):
        rows += fresh
        if any(np.ptp(values[-fresh:]) == 0.0 for values in block.channels.values()):
            still += fresh
            continue
        block = without_outliers(block, channels_of(block)[0], findings)
        if axis is None:
            axis = axis_of([block], replace(options.axis, lag=not known))
            timing = given_timing(options.torque, axis.interval) if known else timing_of(axis)
        (block,) = timing.moved(replace(axis, logs=(block,))).logs
        if not parts:
            axis = axis.with_kink(_factors(axis.rows_of(block)))
            bandwidth = axis.equation.bandwidth
            every = max(1, int(0.1 / (bandwidth * block.interval)))
            reach[0] = 2 * settling(bandwidth, block.interval)
        found = axis.rows_of(block, every)
        parts.append(_factors(found))
        squares = squares + (found.regressors**2).sum(axis=0)
        used += found.left.size
        reports.append(block.report)
        if sum(part.triangles.shape[0] for part in parts) > MOST_FACTORS:
            parts = [estimates.merged(estimates.joined(parts), 2)]
    if axis is None:
        raise InputRefused(f"{recording.table.source}: nothing moves in it: a log must move the axis")
    found_all = axis.answer(
        estimates.suited_segments(estimates.joined(parts)), np.sqrt(squares / used), 0.5 * axis.interval
    )
    found_all = timed(replace(found_all, findings=(*findings, *found_all.findings)), timing)
    whole = _whole(reports, rows - still, still)
    return replace(found_all.noting(blocks=len(reports)), reports=(whole,))


def _factors(rows: Rows) -> Factors:
    return estimates.factor(rows.regressors, rows.left, rows.names, SEGMENTS_PER_BLOCK)


def _checked_blocks(
    recording: Recording, reach: list[int], progress: Callable[[str], None] | None
) -> Iterator[tuple[Log, int]]:
    """Blocks of `BLOCK_ROWS` rows, and how many are new; each begins with ``reach`` of the one before."""
    wanted = tuple(c for c in recording.columns if c in ("time", "torque", "angle", "force", "position"))
    held = {name: np.empty(0) for name in wanted}
    start, again = 0, 0  # rows of the file before those held; of these, in the block before as well
    part, whole = recording.map, replace(recording, map=replace(recording.map, start=None, end=None))
    first, last = (-np.inf if part.start is None else part.start), (np.inf if part.end is None else part.end)

    def checked(end: int) -> tuple[Log, int]:
        log = checked_log(whole, {name: values[:end] for name, values in held.items()}, start)
        if progress is not None:
            about = recording.table.rows
            share = f", about {100 * min(1.0, (start + end) / about):.0f} %" if about else ""
            progress(f"{recording.table.source}: {start + end} rows{share}")
        return log, end - again

    for block in recording.blocks(wanted):
        rows, size = held[wanted[0]].size, block[wanted[0]].size
        rate = part.sample_rate
        time = block["time"] if rate is None else (start + rows + np.arange(size)) / rate
        outside = (time < first) | (time >= last)
        if rows == 0:
            start += size if outside.all() else int(outside.argmin())
        held = {name: np.concatenate([held[name], block[name][~outside]]) for name in wanted}
        while held[wanted[0]].size >= again + 2 * BLOCK_ROWS:
            end = again + BLOCK_ROWS
            yield checked(end)
            again = min(reach[0], end)
            held = {name: values[end - again :] for name, values in held.items()}
            start += end - again
    if (size := held[wanted[0]].size) > again:
        yield checked(size)


def _whole(reports: list[DataReport], rows: int, still: int) -> DataReport:
    """The report of a log from those of its blocks; ``still``: rows in blocks in which nothing moves."""
    interval = float(np.mean([r.interval for r in reports]))
    repaired, findings = (
        dict.fromkeys(line for report in reports for line in getattr(report, name))
        for name in ("repaired", "findings")
    )
    rest = (f"{still} rows in blocks in which nothing moves are left out",) if still else ()
    return DataReport(
        rows=rows,
        duration=(rows - 1) * interval,
        interval=interval,
        jitter=max(report.jitter for report in reports),
        quantum=reports[0].quantum,
        repaired=tuple(repaired),
        findings=(*findings, *rest),
    )


MODELS = tuple(f"rigid-axis-{kind}" for kind in FRICTIONS)
METHODS = ("auto", "inverse-dynamics", "output-error", "prediction-error")
KEYS = ("model", "method", "bandwidth", "filter", "slope", "fading", "check", "torque")


def load_options(path: str | Path) -> IdentifyOptions:
    """Read a TOML file with tables ``[identify]`` and ``[log]``."""
    return read_toml(path, "write TOML with tables [identify] and [log]", _options_of)


def _options_of(content: dict[str, Any]) -> IdentifyOptions:
    for key in content:
        require_known(key, ("identify", "log"), f"{key}: unknown table")
    table = table_of("identify", content.get("identify", {}))
    for key in table:
        require_known(key, KEYS, f"identify.{key}: unknown key")
    friction = FrictionModel(
        slope=_above_zero(table, "slope", "s/rad") or PRINTED_SLOPE,
        fading=_above_zero(table, "fading", "rad/s") or 0.0,
    )
    bandwidth, kind = _above_zero(table, "bandwidth", "Hz"), _word(table, "filter", "zero-phase", FILTERS)
    options = IdentifyOptions(
        model=_word(table, "model", "rigid-axis", ("rigid-axis", *MODELS, TWO_INERTIA)),
        method=_word(table, "method", "auto", METHODS),
        axis=AxisOptions(friction=friction, bandwidth=bandwidth, filter=kind),
        columns=column_map(table_of("log", content.get("log", {}))),
        check=flag_of("identify.check", table.get("check", True)),
        torque=_word(table, "torque", "found", TIMINGS),
    )
    return with_model(options, None)


def with_model(options: IdentifyOptions, model: str | None) -> IdentifyOptions:
    """Options with another model, or as they are; refused if there is no such model."""
    name = options.model if model is None else model
    name = "rigid-axis-coulomb" if name == "rigid-axis" else name
    if name == TWO_INERTIA:
        return replace(options, model=name)
    require_known(name, (*MODELS, TWO_INERTIA), f'model "{name}" is unknown')
    friction = replace(options.axis.friction, kind=name.removeprefix("rigid-axis-"))
    if friction.kind == "stribeck" and friction.fading <= 0.0:
        raise InputRefused("model rigid-axis-stribeck needs identify.fading, the speed of its excess")
    return replace(options, model=name, axis=replace(options.axis, friction=friction))


def identify(
    logs: str | Path | Log | Sequence[str | Path | Log],
    options: IdentifyOptions | None = None,
    *,
    model: str | None = None,
    method: str | None = None,
    progress: Callable[[str], None] | None = None,
) -> Identification:
    """Identify one axis from one log or several, with intervals, and say where the model does not fit.

    Parameters
    ----------
    logs : path, Log, or sequence of them
    options : IdentifyOptions, optional
    model : str, optional
        One of `MODELS`, or "two-inertia".
    method : str, optional
        "inverse-dynamics": least squares on the torque, its own errors in the intervals; "output-error":
        refined by simulating the motion, without the bias of the encoder's noise; "prediction-error": from
        what an observer does not predict, also inside a feedback loop; "auto", the default: prediction
        error, or inverse dynamics where an observer loses the log or the model is refused.
    progress : callable, optional
        Called with a line now and then while a log is read that does not fit into memory.

    Returns
    -------
    Identification

    Raises
    ------
    InputRefused
        If a log or an option is refused.
    NotComputed
        If output error is asked for and the model does not follow the log by itself.
    """
    options = with_model(options or IdentifyOptions(), model)
    method = options.method if method is None else method
    require_known(method, METHODS, f'method "{method}" is unknown')
    settings = (method, options.torque, options.axis)
    if options.model == TWO_INERTIA and settings != ("auto", "found", AxisOptions()):
        said = "the channels decide method, filters and instant of the torque of model two-inertia"
        raise InputRefused(f"{said}: leave --method, --torque, bandwidth, filter, slope and fading out")
    single = isinstance(logs, (str, Path, Log))
    given: Sequence[Any] = [logs] if single else list(logs)  # type: ignore[arg-type]
    if single and not isinstance(logs, Log):
        recording = open_log(given[0], options.columns)
        if is_long(recording) and options.model != TWO_INERTIA:
            if method in ("output-error", "prediction-error"):
                raise InputRefused(
                    f"{recording.table.source}: method {method} needs the log in memory, which is too long "
                    "for that: leave the method out, or cut the log"
                )
            found = identify_long_log(recording, options, progress=progress)
            own_error = "not known: the log is read in blocks"
            found = found.noting(model_check=NOT_MADE["long"], own_error=own_error)
            return replace(found, check_reason=NOT_MADE["long"])
    read = [log if isinstance(log, Log) else read_log(log, options.columns) for log in given]
    for log in (log for log in read if log.interval >= NO_SERVO):
        said = f"{log.source}: median step {log.interval:.4g} s is of no servo log, {NO_SERVO:g} s is too"
        raise InputRefused(f'{said} long: head it "time [ms]", or name the unit, as --column "time=time:ms"')
    # Many small decompositions: a second thread gains nothing, and on a busy machine it mostly waits.
    with threadpool_limits(limits=1, user_api="blas"):
        if options.model == TWO_INERTIA:
            return identify_two_inertia(read, progress=progress)
        return answer(read, replace(options, method=method))


def _above_zero(table: Mapping[str, Any], key: str, unit: str) -> float | None:
    """A quantity above 0, None where the table does not say it."""
    if key not in table:
        return None
    value = quantity_of(f"identify.{key}", table[key], unit)
    if value <= 0.0:
        raise InputRefused(f"identify.{key} = {value:.4g} {unit} must be above 0: correct it")
    if not SMALLEST <= value <= LARGEST:
        raise InputRefused(f"identify.{key} = {value:.4g} {unit} is of no machine: check its unit")
    return value


def _word(table: Mapping[str, Any], key: str, default: str, known: Sequence[str]) -> str:
    """One of a few words."""
    word = text_of(f"identify.{key}", table.get(key, default))
    require_known(word, known, f'identify.{key} = "{word}" is unknown')
    return word
