"""Output error of one rigid axis, and the instant at which a logged torque acts.

Inverse dynamics takes speed and its sign from the encoder; their errors bias it by a fraction of a per cent,
more than its intervals where a log is long. Here the model moves by itself under the measured torque and its
speed is compared with the measured one. The parameters solve :math:`Z^T r = 0`, where :math:`r` is the
filtered difference of speeds and :math:`Z` the exact sensitivities of the model's speed. They are taken along
the motion under the torque's spectral lines alone: noise of the torque must not be in both factors.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cabledrive.identification.axis_case import Case, case_of, columns_of, simulated, weighed
from cabledrive.identification.estimates import Finding, Identification
from cabledrive.identification.filters import difference
from cabledrive.identification.inverse_dynamics import LAG, Rows
from cabledrive.identification.logs.log import Log
from cabledrive.identification.method_error import error_of_refinement, widened
from cabledrive.identification.regression import Factors, Fit, factor, joined, solve, suited_segments
from cabledrive.identification.rigid_axis import (
    SHORT_SEGMENTS,
    AxisOptions,
    channels_of,
    equation_for,
    rows_of_logs,
)
from cabledrive.identification.torque_timing import FARTHEST, NEAR, ROUNDS, SETTLED, TorqueTiming, shifted
from cabledrive.parameters import InputRefused, NotComputed

Array = NDArray[np.float64]

PASSES = 12
CONVERGED = 0.1
"""Largest step of a parameter, in standard errors, at which the iteration ends."""
HALVINGS = 5
SLACK = 1e-3
"""Growth of the residual that a step may make: near the end the sensitivities are not quite its gradient."""
LARGEST_RESIDUAL = 0.5
NOT_FOLLOWING = (
    "the model does not reproduce the log in open loop (residual {share:.0f} % of the speed): a feedback "
    "loop controls the axis, or the model is wrong"
)
NOT_FOLLOWED = "not-followed"
QUANTITIES = ("inertia", "viscous", "coulomb", "offset")


def refine_rigid_axis(
    logs: Sequence[Log], found: Identification, options: AxisOptions | None = None
) -> Identification:
    """Refine inverse dynamics by output error; several logs share the parameters.

    ``found``: from inverse dynamics, with constant or smooth Coulomb friction; ``options``: those it was
    found with.
    Returns with a finding where the model does not follow the log by itself.
    Raises `NotComputed` if what was found before is not identifiable, or has another friction.
    """
    options = options or AxisOptions()
    if options.friction.kind not in ("coulomb", "tanh") or not found.identifiable:
        raise NotComputed(
            "output error needs an identifiable rigid axis with one Coulomb friction: fit that first"
        )
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    cases = [case_of(log, torque, position, equation) for log in logs]
    values = np.array([estimate.value for estimate in found.parameters.values()])
    speeds = np.array([case.start for case in cases])
    values, speeds, _ = _solved(cases, values, speeds, PASSES // 4)
    cases = weighed(cases, values, speeds)
    values, speeds, fit = _solved(cases, values, speeds, PASSES)
    plain = [simulated(replace(c, weights=None), values, v)[0] for c, v in zip(cases, speeds, strict=True)]
    residual = float(np.sqrt(np.mean(np.concatenate(plain) ** 2)))
    size = float(np.sqrt(np.mean(np.concatenate([case.speed[case.inner] for case in cases]) ** 2)))
    extra = error_of_refinement(cases, values, speeds)
    return _concluded(found, values, fit, extra, residual, size)


def _solved(cases: list[Case], values: Array, speeds: Array, passes: int) -> tuple[Array, Array, Fit]:
    """Gauss-Newton steps until they are small; halved where one beyond its errors raised the residual."""
    factors, residual = _linearised(cases, values, speeds)
    for _ in range(passes):
        fit = solve(suited_segments(factors, each=True))
        step, errors = fit.values, np.sqrt(np.diag(fit.covariance))[:4]
        near = bool(np.all(np.abs(step[:4]) <= errors))
        for _ in range(HALVINGS):
            tried = _within(values, step[:4]), speeds + step[4 : 4 + len(cases)]
            new_factors, new_residual = _linearised(cases, *tried)
            if near or new_residual <= (1.0 + SLACK) * residual:
                break
            step = 0.5 * step
        (values, speeds), factors, residual = tried, new_factors, new_residual
        if np.all(np.abs(step[:4]) <= CONVERGED * errors):
            break
    return values, speeds, solve(suited_segments(factors, each=True))


def _linearised(cases: list[Case], values: Array, speeds: Array) -> tuple[Factors, float]:
    """Residuals and sensitivities of all logs; every log has its own speed at the start."""
    parts, squares, rows = [], 0.0, 0
    count = max(12, SHORT_SEGMENTS // len(cases))
    for number, case in enumerate(cases):
        residual, sensitivities = simulated(case, values, speeds[number])
        regressors = columns_of(sensitivities, number, len(cases))
        names = (*QUANTITIES, *(f"start {k}" for k in range(len(cases))), *((LAG,) if case.lag else ()))
        parts.append(factor(regressors, residual, names, min(count, residual.size // 20)))
        squares += float(residual @ residual)
        rows += residual.size
    return joined(parts), float(np.sqrt(squares / rows))


def _within(values: Array, step: Array) -> Array:
    """A step that changes no inertia or friction by more than half."""
    limit = 0.5 * np.abs(values[:3])
    step = step.copy()
    step[:3] = np.clip(step[:3], -limit, limit)
    return values + step


def _concluded(
    found: Identification, values: Array, fit: Fit, extra: Array, residual: float, size: float
) -> Identification:
    parameters = {
        name: replace(estimate, value=float(values[k]))
        for k, (name, estimate) in enumerate(found.parameters.items())
    }
    method: dict[str, Any] = dict(found.method)
    method |= {
        "name": "output error on the speed, exact sensitivities, started from inverse dynamics",
        "residual_of": "speed",
        "freedom": fit.freedom,
    }
    findings = found.findings
    if residual > LARGEST_RESIDUAL * size:
        findings += (Finding(NOT_FOLLOWED, NOT_FOLLOWING.format(share=100 * residual / size)),)
    refined = replace(
        found,
        findings=findings,
        parameters=parameters,
        residual={"rms": residual, "relative": residual / size, "rows": fit.rows},
        method=method,
        covariance=fit.covariance[:4, :4],
        freedom=fit.freedom,
    )
    return widened(refined, extra)


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
