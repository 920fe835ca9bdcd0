"""The instant at which a logged torque acts, found from the logs: Gauss-Newton on the filtered equation."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cabledrive.identification.filters import difference
from cabledrive.identification.inverse_dynamics import Rows
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, Fit, factor, joined, solve, suited_segments
from cabledrive.identification.rigid_axis import (
    SHORT_SEGMENTS,
    AxisOptions,
    channels_of,
    equation_for,
    rows_of_logs,
)
from cabledrive.identification.torque_timing import (
    FARTHEST,
    NEAR,
    ROUNDS,
    SETTLED,
    TorqueTiming,
    shifted,
)
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

DRIFT_PARTS, DRIFT_SURE = 4, 8.0
"""Parts of a log whose instants are compared, and standard errors from which they drift."""
UNDETERMINED = TorqueTiming(shift=0.0, error=0.0, determined=False)


def timing_of(logs: Sequence[Log], options: AxisOptions) -> TorqueTiming:
    """Time by which the torque acts later than it is logged, one for all logs.

    Returns undetermined, and zero, where the logs do not determine it beside the parameters.
    """
    parts = _parts(logs, options)
    plain = None if parts is None else _settled(parts, logs, "shift")
    if parts is None or plain is None:
        return UNDETERMINED
    if plain[0].shift < -NEAR * max(log.interval for log in logs):
        behind = _settled(parts, logs, "low-pass")
        if behind is not None and behind[1] < plain[1]:
            return behind[0]
    return plain[0]


def clock_drift(logs: Sequence[Log], options: AxisOptions) -> float:
    """Rate at which the torque's instant moves along every log, as by two clocks, beyond chance; else 0.

    The slope of a line through the instants of `DRIFT_PARTS` parts of a log.
    """
    rates = []
    for log in logs:
        edges = log.time[np.linspace(0, len(log) - 1, DRIFT_PARTS + 1).astype(int)]
        found = []
        for start, end in pairwise(edges.tolist()):
            piece = [log.part(start, end)]
            try:
                parts = _parts(piece, options)
            except InputRefused:
                return 0.0
            one = None if parts is None else _settled(parts, piece, "shift")
            if one is None:
                return 0.0
            found.append(one[0])
        shifts, errors = (np.array([getattr(one, name) for one in found]) for name in ("shift", "error"))
        middle = 0.5 * (edges[1:] + edges[:-1])
        line, square = np.polyfit(middle, shifts, 1, w=1.0 / errors, cov="unscaled")
        left = (shifts - np.polyval(line, middle)) / errors
        error = float(np.sqrt(square[0, 0] * max(1.0, float(left @ left) / (DRIFT_PARTS - 2))))
        if abs(line[0]) < DRIFT_SURE * error or abs(line[0]) * log.report.duration < log.interval:
            return 0.0
        rates.append(float(line[0]))
    return float(np.mean(rates))


def with_clock(log: Log, torque: str, rate: float) -> Log:
    """A log whose torque channel, with a clock of its own, is at the time stamps of the others."""
    samples = np.arange(len(log)) * (1.0 - rate)
    moved = ndimage.map_coordinates(log.channel(torque), [samples], order=3, mode="nearest")
    return replace(log, channels={**log.channels, torque: moved})


def _parts(logs: Sequence[Log], options: AxisOptions) -> list[Rows] | None:
    """Rows of the logs with the torque's rate; None where that is no column of its own."""
    torque, position = channels_of(logs[0], options)
    equation = replace(equation_for(logs, torque, position, options), lag=True)
    _, parts = rows_of_logs(logs, torque, position, equation)
    single = solve(_factors(parts, [(p.left, p.regressors[:, -1]) for p in parts])).unidentifiable.size
    return None if single else parts


def _settled(parts: list[Rows], logs: Sequence[Log], law: str) -> tuple[TorqueTiming, float] | None:
    """The timing under one law and its residual; None where the steps do not come to an end."""
    shift, interval = 0.0, max(log.interval for log in logs)
    for number in range(ROUNDS):
        moved = [_moved(p, log.interval, shift, law) for p, log in zip(parts, logs, strict=True)]
        factors = _factors(parts, moved)
        fit: Fit = solve(suited_segments(factors) if number else factors)
        error, step = float(np.sqrt(fit.covariance[-1, -1])), float(fit.values[-1])
        if not np.isfinite(step) or error > interval:
            return None
        shift += step
        if abs(shift) > FARTHEST * interval:
            return None
        if number and abs(step) < max(SETTLED * interval, 0.2 * error):
            return TorqueTiming(shift=shift, error=error, law=law), fit.residual
    return None


def _moved(rows: Rows, interval: float, shift: float, law: str) -> tuple[Array, Array]:
    """Left side and column of the torque's instant, at a shift."""
    if law == "low-pass":
        return rows.left - shift * rows.regressors[:, -1], rows.regressors[:, -1]
    left = shifted(rows.left, shift / interval)
    return left, difference(left, interval)


def _factors(parts: list[Rows], moved: list[tuple[Array, Array]]) -> Factors:
    count = max(12, SHORT_SEGMENTS // len(parts))
    found = []
    for rows, (left, column) in zip(parts, moved, strict=True):
        regressors = np.column_stack([rows.regressors[:, :-1], column])
        segments = max(2, min(count, left.size // 20))
        found.append(factor(regressors, left, rows.names, segments))
    return joined(found)
