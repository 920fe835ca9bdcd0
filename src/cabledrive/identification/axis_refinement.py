r"""Output error of one rigid axis: the motion is simulated, so no regressor carries the encoder's noise.

Inverse dynamics takes speed and its sign from the encoder; their errors bias it by a fraction of a per cent,
more than its intervals where a log is long. Here the model moves by itself under the measured torque and its
speed is compared with the measured one. The parameters solve :math:`Z^T r = 0`, where :math:`r` is the
filtered difference of speeds and :math:`Z` the exact sensitivities of the model's speed. They are taken along
the motion under the torque's spectral lines alone: noise of the torque must not be in both factors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.axis_equation import AxisEquation
from cabledrive.identification.estimates import Estimate, Identification
from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.inverse_dynamics import quick_speed, settling
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, Fit, factor, joined, solve, suited_segments
from cabledrive.identification.rigid_axis import SHORT_SEGMENTS, AxisOptions, channels_of, equation_for
from cabledrive.parameters import NotComputed
from cabledrive.reduction.friction_march import march_rigid_axis

Array = NDArray[np.float64]

BANDWIDTH = 50.0
"""Of the compared speeds [Hz]."""
PASSES = 12
CONVERGED = 0.02
"""Largest step of a parameter, in standard errors, at which the iteration ends."""
LARGEST_RESIDUAL = 0.5
SPARSE = 0.3
QUANTITIES = ("inertia", "viscous", "coulomb", "offset")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Case:
    """One log, ready to be simulated."""

    torque: Array
    lines: Array
    speed: Array
    start: float
    interval: float
    inner: slice
    bandwidth: float
    slope: float


def refine_rigid_axis(
    logs: Sequence[Log], found: Identification, options: AxisOptions | None = None
) -> Identification:
    """Refine inverse dynamics by output error; several logs share the parameters.

    Parameters
    ----------
    logs : sequence of Log
    found : Identification
        From inverse dynamics, with constant or smooth Coulomb friction.
    options : AxisOptions, optional
        Those it was found with.

    Returns
    -------
    Identification

    Raises
    ------
    NotComputed
        If the model does not follow the log by itself: a feedback loop holds the axis, or the model is wrong.
    """
    options = options or AxisOptions()
    if options.friction.kind not in ("coulomb", "tanh") or not found.identifiable:
        raise NotComputed(
            "output error needs an identifiable rigid axis with one Coulomb friction: fit that first"
        )
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    cases = [_case(log, torque, position, equation) for log in logs]
    values = np.array([estimate.value for estimate in found.parameters.values()])
    speeds = np.array([case.start for case in cases])
    for _ in range(PASSES):
        factors, residual = _linearised(cases, values, speeds)
        fit = solve(suited_segments(factors))
        values = _within(values, fit.values[:4])
        speeds = speeds + fit.values[4:]
        errors = np.sqrt(np.diag(fit.covariance))[:4]
        if np.all(np.abs(fit.values[:4]) <= CONVERGED * errors):
            break
    size = float(np.sqrt(np.mean(np.concatenate([case.speed[case.inner] for case in cases]) ** 2)))
    if residual > LARGEST_RESIDUAL * size:
        raise NotComputed(
            f"the model does not follow the log by itself (residual {100 * residual / size:.0f} % of the "
            "speed): a feedback loop holds the axis, or the model is wrong; take inverse dynamics"
        )
    return _concluded(found, values, fit, residual, size)


def spectral_lines(values: Array) -> Array:
    """A signal without what lies near its noise floor; the signal itself where it is no sum of lines.

    Parameters
    ----------
    values : ndarray, shape (samples,)

    Returns
    -------
    ndarray, shape (samples,)
    """
    spectrum = np.fft.rfft(values)
    size = np.abs(spectrum)
    above = size > 12.0 * np.median(size)
    kept = np.convolve(above, np.ones(3), "same") > 0
    if kept.mean() > SPARSE:
        return values
    return np.fft.irfft(np.where(kept, spectrum, 0.0), values.size)


def _case(log: Log, torque: str, position: str, equation: AxisEquation) -> _Case:
    bandwidth = min(BANDWIDTH, 0.2 * log.sample_rate)
    angle = log.channel(position)
    edge = settling(bandwidth, log.interval)
    slope = equation.friction.slope if equation.friction.kind == "tanh" else 0.0
    return _Case(
        torque=log.channel(torque),
        lines=spectral_lines(log.channel(torque)),
        speed=zero_phase(difference(angle, log.interval), log.interval, bandwidth),
        start=float(quick_speed(angle, equation, log.interval)[0]),
        interval=log.interval,
        inner=slice(edge, len(log) - edge),
        bandwidth=bandwidth,
        slope=slope,
    )


def _linearised(cases: list[_Case], values: Array, speeds: Array) -> tuple[Factors, float]:
    """Residuals and sensitivities of all logs; every log has its own speed at the start."""
    parts, squares, rows = [], 0.0, 0
    count = max(12, SHORT_SEGMENTS // len(cases))
    for number, case in enumerate(cases):
        residual, sensitivities = _simulated(case, values, speeds[number])
        regressors = np.zeros((residual.size, 4 + len(cases)))
        regressors[:, :4] = sensitivities[:, :4]
        regressors[:, 4 + number] = sensitivities[:, 4]
        names = (*QUANTITIES, *(f"start {k}" for k in range(len(cases))))
        parts.append(factor(regressors, residual, names, min(count, residual.size // 20)))
        squares += float(residual @ residual)
        rows += residual.size
    return joined(parts), float(np.sqrt(squares / rows))


def _simulated(case: _Case, values: Array, start: float) -> tuple[Array, Array]:
    moved, _ = march_rigid_axis(values, case.torque, case.interval, start=start, slope=case.slope)
    _, along = march_rigid_axis(values, case.lines, case.interval, start=start, slope=case.slope)
    filtered = zero_phase(np.column_stack([moved, along]), case.interval, case.bandwidth)
    return (case.speed - filtered[:, 0])[case.inner], filtered[case.inner, 1:]


def _within(values: Array, step: Array) -> Array:
    """A step that changes no inertia or friction by more than half."""
    limit = 0.5 * np.abs(values[:3])
    step = step.copy()
    step[:3] = np.clip(step[:3], -limit, limit)
    return values + step


def _concluded(
    found: Identification, values: Array, fit: Fit, residual: float, size: float
) -> Identification:
    half = fit.half_width()
    parameters = {
        name: Estimate(
            value=float(values[k]),
            unit=estimate.unit,
            standard_error=float(np.sqrt(fit.covariance[k, k])),
            low=float(values[k] - half[k]),
            high=float(values[k] + half[k]),
        )
        for k, (name, estimate) in enumerate(found.parameters.items())
    }
    method: dict[str, Any] = dict(found.method)
    method |= {
        "name": "output error on the speed, exact sensitivities, started from inverse dynamics",
        "residual_of": "speed",
        "freedom": fit.freedom,
    }
    return replace(
        found,
        parameters=parameters,
        residual={"rms": residual, "relative": residual / size, "rows": fit.rows},
        method=method,
        covariance=fit.covariance[:4, :4],
        freedom=fit.freedom,
    )
