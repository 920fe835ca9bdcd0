"""The instant at which a logged torque acts, found from the logs: Gauss-Newton on the filtered equation."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

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

Array = NDArray[np.float64]

UNDETERMINED = TorqueTiming(shift=0.0, error=0.0, determined=False)


def timing_of(logs: Sequence[Log], options: AxisOptions) -> TorqueTiming:
    """Time by which the torque acts later than it is logged, one for all logs.

    Returns undetermined, and zero, where the logs do not determine it beside the parameters.
    """
    torque, position = channels_of(logs[0], options)
    equation = replace(equation_for(logs, torque, position, options), lag=True)
    interval = max(log.interval for log in logs)
    _, parts = rows_of_logs(logs, torque, position, equation)
    if solve(_factors(parts, [(p.left, p.regressors[:, -1]) for p in parts])).unidentifiable.size:
        return UNDETERMINED
    plain = _settled(parts, logs, "shift")
    if plain is None:
        return UNDETERMINED
    if plain[0].shift < -NEAR * interval:
        behind = _settled(parts, logs, "low-pass")
        if behind is not None and behind[1] < plain[1]:
            return behind[0]
    return plain[0]


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
