"""One rigid axis from its logs: inertia, viscous and Coulomb friction, offset, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification import regression as limits
from cabledrive.identification.estimates import Estimate, Finding, Identification, unit_of
from cabledrive.identification.filters import chosen_bandwidth
from cabledrive.identification.inverse_dynamics import (
    LAG,
    AxisEquation,
    FrictionModel,
    Rows,
    factors_of,
    rows_of,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, Fit, joined, only, solve, suited_segments, triangle
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

LEAST_DETERMINED = 2.0
"""Standard error of the torque's instant, over its systematic error, above which it is not identifiable."""


def regression_result(
    factors: Factors,
    equation: AxisEquation,
    sizes: Array,
    method: dict[str, Any],
    findings: tuple[str, ...],
    reports: tuple[Any, ...],
    doubt: float = 0.0,
) -> Identification:
    """The identification from a solved regression: numbers where there are any, words where there are none.

    ``sizes``, shape (p,): root mean square of each regressor; ``doubt``: about the instant at which the
    torque acts, where the regression leaves that free and cannot find it beside the parameters [s].
    """
    fit = _without_lag(factors, doubt)
    sizes = sizes[: len(fit.names)]
    unidentifiable = limits.unidentifiable_parameters(fit)
    weak = set(limits.weak_parameters(fit, sizes)) - unidentifiable
    words = limits.unidentifiable_words(fit) + tuple(
        limits.weak_words(name) for name in fit.names if name in weak
    )
    half = fit.half_width()
    parameters = {
        name: _estimate(fit, k, float(half[k]), unit_of(name, equation.linear), name in unidentifiable | weak)
        for k, name in enumerate(fit.names)
    }
    relative = fit.residual / fit.scale if fit.scale > 0 else float("nan")
    return Identification(
        model=f"rigid-axis-{equation.friction.kind}",
        parameters=parameters,
        identifiable=not words,
        unidentifiable=words,
        residual={"rms": float(fit.residual), "relative": float(relative), "rows": fit.rows},
        condition_number=fit.condition,
        method=method,
        covariance=fit.covariance,
        freedom=fit.freedom,
        findings=findings + implausible(parameters),
        reports=reports,
    )


def _without_lag(factors: Factors, doubt: float) -> Fit:
    """The fit of the parameters, the instant of the torque taken out: estimated beside them, or doubted."""
    if LAG not in factors.names:
        return solve(factors)
    count = len(factors.names) - 1
    kept = factors.names[:count]
    fit = solve(factors)
    error = float(np.sqrt(fit.covariance[-1, -1]))
    plain = solve(only(factors, kept))
    if not (fit.unidentifiable.size or error > LEAST_DETERMINED * doubt):
        covariance = fit.covariance[:count, :count]
        return replace(
            fit, names=kept, values=fit.values[:count], covariance=covariance, condition=plain.condition
        )
    stacked = triangle(factors.triangles.reshape(-1, count + 2))
    moved = doubt * np.linalg.lstsq(stacked[:count, :count], stacked[:count, count], rcond=None)[0]
    return replace(plain, covariance=plain.covariance + np.outer(moved, moved))


def implausible(parameters: dict[str, Estimate]) -> tuple[str, ...]:
    """Numbers that no machine has: findings about the log, not results."""
    found = []
    against = any(parameters[name].value < 0.0 for name in ("inertia", "mass") if name in parameters)
    for name, estimate in parameters.items():
        if not estimate.reason and estimate.high < 0.0 and not name.startswith("offset"):
            hint = "are torque and angle swapped, or is one sign reversed?"
            if name not in ("inertia", "mass") and not against:
                hint = "the friction model does not fit this axis"
            size = f"{estimate.value:.4g} {estimate.unit}"
            found.append(
                Finding("negative", f"{limits.readable(name)} is identified as negative ({size}): {hint}")
            )
    return tuple(found)


def _estimate(fit: Fit, k: int, half: float, unit: str, unknown: bool) -> Estimate:
    if unknown:
        infinite = float("inf")
        return Estimate(
            value=float("nan"),
            unit=unit,
            standard_error=infinite,
            low=-infinite,
            high=infinite,
            reason="not identifiable from the log",
        )
    value = float(fit.values[k])
    error = float(np.sqrt(fit.covariance[k, k]))
    return Estimate(value=value, unit=unit, standard_error=error, low=value - half, high=value + half)


BANDWIDTH_LIMITS = (5.0, 40.0)
"""Bounds of the bandwidth chosen from the data [Hz]: above, an encoder's rounding outweighs the gain."""
SHORT_SEGMENTS = 240
LEAST_KEPT = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisOptions:
    """What may be chosen for one rigid axis."""

    friction: FrictionModel = field(default_factory=FrictionModel)
    bandwidth: float | None = None  # of the filter on both sides [Hz]; None: from the data
    filter: str = "zero-phase"  # {"zero-phase", "causal", "ideal"}
    # torque, position: Channels; None: "torque" and "angle", or "force" and "position"
    torque: str | None = None
    position: str | None = None
    lag: bool = True  # whether the instant at which the torque acts is free, to first order


def identify_rigid_axis(logs: Sequence[Log], options: AxisOptions | None = None) -> Identification:
    r"""Identify one rigid axis by inverse dynamics, Eq. (4.16).

    .. math:: J\ddot\theta = \tau - b\dot\theta - c\,S(\dot\theta) + d

    ``logs``: each with torque and angle, or force and position.
    Raises `InputRefused` if a log lacks a channel, or one that stands still.
    """
    options = options or AxisOptions()
    if not logs:
        raise InputRefused("no log given: name at least one")
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    equation, parts = rows_of_logs(logs, torque, position, equation)
    count = max(12, SHORT_SEGMENTS // len(parts))
    factors = suited_segments(joined([factors_of(rows, _segments(rows, count)) for rows in parts]))
    sizes = np.sqrt(np.mean(np.vstack([rows.regressors for rows in parts]) ** 2, axis=0))
    reports = tuple(log.report for log in logs)
    doubt = 0.5 * max(log.interval for log in logs)
    method = axis_method(equation, options, factors)
    return regression_result(factors, equation, sizes, method, _findings(parts), reports, doubt)


def rows_of_logs(
    logs: Sequence[Log], torque: str, position: str, equation: AxisEquation
) -> tuple[AxisEquation, list[Rows]]:
    """Rows of all logs, with the kinks that friction makes in the speed.

    ``torque``, ``position``: channels.
    Returns ``equation``: with the kink that a first pass found.
    """
    parts = [rows_for(log, torque, position, equation) for log in logs]
    count = max(12, SHORT_SEGMENTS // len(parts))
    kink = kink_of(joined([factors_of(rows, _segments(rows, count)) for rows in parts]), equation)
    if kink > 0.0:
        equation = replace(equation, kink=kink)
        parts = [rows_for(log, torque, position, equation) for log in logs]
    return equation, parts


def channels_of(log: Log, options: AxisOptions) -> tuple[str, str]:
    """Channels of torque and angle, or force and position.

    Raises `InputRefused` if the log has neither pair.
    """
    for torque, position in (("torque", "angle"), ("force", "position")):
        torque, position = options.torque or torque, options.position or position
        if torque in log.channels and position in log.channels:
            return torque, position
    driven = "torque" in log.channels or "force" in log.channels
    example = "angle=my column:deg" if driven else "torque=my column:N m"
    raise InputRefused(
        f'{log.source}: needs "torque [N m]" and "angle [rad]", or "force [N]" and "position [m]"; '
        f'has {", ".join(log.channels)}: map the others as well, as --column "{example}"'
    )


def _bandwidth_of(log: Log, position: str) -> float:
    try:
        return chosen_bandwidth(log.channel(position), log.interval)
    except InputRefused as refusal:
        raise refusal.at(log.source) from None


def equation_for(logs: Sequence[Log], torque: str, position: str, options: AxisOptions) -> AxisEquation:
    """The regression's equation, with what the data decide.

    ``torque``, ``position``: channels.
    Raises `InputRefused` if a channel stands still, or the bandwidth asks for a longer log.
    """
    for log in logs:
        for name in (torque, position):
            if np.ptp(log.channel(name)) == 0.0:
                raise InputRefused(f"{log.source}: {name} is constant: a log must move the axis")
    bandwidth = options.bandwidth
    if bandwidth is None:
        bandwidth = float(np.clip(max(_bandwidth_of(log, position) for log in logs), *BANDWIDTH_LIMITS))
        bandwidth = min(bandwidth, *(0.2 * log.sample_rate for log in logs))
    longest = max(float(log.time[-1] - log.time[0]) for log in logs)
    if bandwidth * longest < 1.0:
        raise InputRefused(
            f"bandwidth = {bandwidth:.4g} Hz has no whole period in a log of {longest:.4g} s: raise it to "
            f"{1.0 / longest:.4g} Hz or more"
        )
    return AxisEquation(
        linear=logs[0].units[torque] == "N",
        bandwidth=bandwidth,
        filter=options.filter,
        friction=options.friction,
        quantum=max(log.report.quantum.get(position, 0.0) for log in logs),
        lag=options.lag,
    )


def rows_for(log: Log, torque: str, position: str, equation: AxisEquation, every: int = 1) -> Rows:
    """Rows of one log, without the samples at which the torque saturates.

    ``every``: take every so many-th row.
    Raises `InputRefused` if too little of the log is left.
    """
    masked = log.saturated.get(torque)
    rows = rows_of(log.channel(position), log.channel(torque), equation, log.interval, masked, every)
    if rows.keep.mean() * every < LEAST_KEPT or rows.left.size < 50:
        why = "the torque saturates or the log is short"
        raise InputRefused(
            f"{log.source}: {100 * rows.keep.mean():.0f} % of it can be used ({why}): record again"
        )
    return rows


def kink_of(factors: Factors, equation: AxisEquation) -> float:
    """Friction over inertia from a first pass.

    Returns [rad/s^2 or m/s^2]; 0 where the friction has no jump.
    """
    fit = solve(factors)
    found = dict(zip(fit.names, fit.values, strict=True))
    inertia = found[equation.inertia]
    if equation.friction.kind in ("tanh", "viscous") or inertia <= 0.0:
        return 0.0
    frictions = [found[name] for name in found if name.startswith("coulomb_friction")]
    return max(0.0, float(np.mean(frictions)) / float(inertia))


def _segments(rows: Rows, count: int) -> int:
    return max(2, min(count, rows.left.size // 20))


def axis_method(equation: AxisEquation, options: AxisOptions, factors: Factors) -> dict[str, Any]:
    """How an axis was identified, with every choice that was made from the data."""
    return {
        "name": "inverse dynamics, least squares by QR",
        "bandwidth_hz": equation.bandwidth,
        "bandwidth_from": "given" if options.bandwidth is not None else "data",
        "filter": equation.filter,
        "friction": equation.friction.kind,
        "standard_errors": "scores of segments of time, Student's t",
        "segments": int(factors.triangles.shape[0]),
    }


def _findings(parts: list[Rows]) -> tuple[str, ...]:
    speeds = np.concatenate([rows.speed for rows in parts])
    size = np.sqrt(np.mean(speeds**2))
    if min((speeds > 0.05 * size).mean(), (speeds < -0.05 * size).mean()) < 0.01:
        words = "the axis moves in one direction only: Coulomb friction and offset act alike"
        return (Finding("one-direction", words),)
    return ()
