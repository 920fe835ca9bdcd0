r"""One rigid axis: inertia, viscous and Coulomb friction, offset, with intervals.

.. math:: J\ddot\theta = \tau - b\dot\theta - c\,S(\dot\theta) + d
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cabledrive.identification import estimates
from cabledrive.identification.axis.equation import LAG, AxisEquation, FrictionModel, settling
from cabledrive.identification.estimates import Estimate, Factors, Finding, Fit, Identification
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import chosen_bandwidth
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

BASE = ("inertia", "viscous", "coulomb", "offset")
"""The four parameters, in the order of every vector of values."""
BANDWIDTH_LIMITS = (5.0, 40.0)
"""Bounds of the bandwidth chosen from the data [Hz]: above, an encoder's rounding outweighs the gain."""
SHORT_SEGMENTS = 240
LEAST_KEPT = 0.5
LEAST_DETERMINED = 2.0
"""Standard error of the torque's instant, over its systematic error, above which it is not identifiable."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisOptions:
    """What may be chosen for one rigid axis."""

    friction: FrictionModel = field(default_factory=FrictionModel)
    bandwidth: float | None = None  # of the filter on both sides [Hz]; None: from the data
    filter: str = "zero-phase"  # {"zero-phase", "causal", "ideal"}
    lag: bool = True  # whether the instant at which the torque acts is free, to first order


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Rows of the regression."""

    names: tuple[str, ...]
    regressors: Array  # (rows, p)
    left: Array  # (rows,): filtered torque or force
    speed: Array  # (rows,)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """Logs of one axis with their channels, and the equation that they decide."""

    logs: tuple[Log, ...]
    options: AxisOptions
    torque: str  # channels
    position: str
    equation: AxisEquation

    @property
    def interval(self) -> float:
        """The longest time between samples [s]."""
        return max(log.interval for log in self.logs)

    @property
    def slope(self) -> float:
        """Of a smooth friction [s/rad]; 0 where it jumps."""
        return self.options.friction.slope if self.options.friction.kind == "tanh" else 0.0

    @property
    def saturated(self) -> bool:
        """Whether the torque of any log stands at an end of its range."""
        return any(self.torque in log.saturated and log.saturated[self.torque].any() for log in self.logs)

    @property
    def torques(self) -> list[Array]:
        """Of each log, as it stands in it."""
        return [log.channel(self.torque) for log in self.logs]

    def having(self, channel: str, values: Iterable[Array]) -> "Axis":
        """The axis with other values in one channel of its logs."""
        pairs = zip(self.logs, values, strict=True)
        return replace(self, logs=tuple(log.having(channel, own) for log, own in pairs))

    def start(self, log: Log) -> float:
        """Speed at the first sample of a log."""
        return float(self.equation.quick_speed(log.channel(self.position), log.interval)[0])

    def rows_of(self, log: Log, every: int = 1) -> Rows:
        """Rows of one log, every so many-th, without those that a saturated torque reaches."""
        equation, masked = self.equation, log.saturated.get(self.torque)
        position, torque = log.channel(self.position), log.channel(self.torque)
        columns, left, speed = equation.columns(position, torque, log.interval)
        keep = np.ones(left.size, dtype=bool)
        edge = settling(equation.bandwidth, log.interval)
        keep[:edge] = keep[keep.size - edge :] = False
        if masked is not None and masked.any():
            keep &= ~(np.convolve(masked, np.ones(edge), "same") > 0.5)
        keep &= np.arange(keep.size) % every == 0
        if keep.mean() * every < LEAST_KEPT or keep.sum() < 50:
            why = "the torque saturates or the log is short"
            raise InputRefused(f"{log.source}: {100 * keep.mean():.0f} % is of use ({why}): record again")
        regressors = np.column_stack([column[keep] for column in columns.values()])
        return Rows(names=tuple(columns), regressors=regressors, left=left[keep], speed=speed[keep])

    def with_kink(self, factors: Factors) -> "Axis":
        """The axis with friction over inertia from a first pass; as it is where the friction has no jump."""
        fit = estimates.solve(factors)
        found = dict(zip(fit.names, fit.values, strict=True))
        inertia = found[self.equation.inertia]
        if self.equation.friction.kind in ("tanh", "viscous") or inertia <= 0.0:
            return self
        friction = float(np.mean([found[name] for name in found if name.startswith("coulomb_friction")]))
        kink = max(0.0, friction / float(inertia))
        return replace(self, equation=replace(self.equation, kink=kink))

    def rows(self) -> list[Rows]:
        """Rows of all logs, with the kinks that friction makes in the speed."""
        parts = [self.rows_of(log) for log in self.logs]
        sharp = self.with_kink(factors_of(parts))
        return [sharp.rows_of(log) for log in self.logs] if sharp.equation.kink > 0.0 else parts

    def regressed(self) -> Identification:
        """By inverse dynamics, Eq. (4.16)."""
        parts = self.rows()
        factors = estimates.suited_segments(factors_of(parts))
        sizes = np.sqrt(np.mean(np.vstack([rows.regressors for rows in parts]) ** 2, axis=0))
        found = self.answer(factors, sizes, 0.5 * self.interval)
        speed = np.concatenate([rows.speed for rows in parts])
        size = np.sqrt(np.mean(speed**2))
        if min((speed > 0.05 * size).mean(), (speed < -0.05 * size).mean()) >= 0.01:
            return found
        words = "the axis moves in one direction only: Coulomb friction and offset act alike"
        return replace(found, findings=(Finding("one-direction", words), *found.findings))

    def answer(self, factors: Factors, sizes: Array, doubt: float = 0.0) -> Identification:
        """A solved regression: numbers where there are any, words where there are none.

        ``sizes``, shape (p,): root mean square of each regressor; ``doubt``: about the instant at which the
        torque acts, where the regression leaves that free and cannot find it beside the parameters [s].
        """
        fit, equation = _without_lag(factors, doubt), self.equation
        none = estimates.unidentifiable_parameters(fit)
        weak = estimates.weak_parameters(fit, fit.half_width(), sizes[: len(fit.names)]) - none
        words = estimates.unidentifiable_words(fit) + tuple(
            estimates.weak_words(name) for name in fit.names if name in weak
        )
        parameters = {}
        errors = np.sqrt(np.diag(fit.covariance))
        for name, value, error, half in zip(fit.names, fit.values, errors, fit.half_width(), strict=True):
            one = Estimate.of(value, estimates.unit_of(name, equation.linear), error, half)
            unknown = Estimate.unknown(one.unit, "not identifiable from the log")
            parameters[name] = unknown if name in none | weak else one
        method: dict[str, Any] = {
            "name": "inverse dynamics, least squares by QR",
            "bandwidth_hz": equation.bandwidth,
            "bandwidth_from": "given" if self.options.bandwidth is not None else "data",
            "filter": equation.filter,
            "friction": equation.friction.kind,
            "standard_errors": "scores of segments of time, Student's t",
            "segments": int(factors.triangles.shape[0]),
        }
        relative = float(fit.residual / fit.scale) if fit.scale > 0 else float("nan")
        return Identification(
            model=f"rigid-axis-{equation.friction.kind}",
            parameters=parameters,
            unidentifiable=words,
            residual={"rms": float(fit.residual), "relative": relative, "rows": fit.rows},
            condition_number=fit.condition,
            method=method,
            covariance=fit.covariance,
            freedom=fit.freedom,
            findings=_implausible(parameters),
            reports=tuple(log.report for log in self.logs),
        )


def axis_of(logs: Sequence[Log], options: AxisOptions) -> Axis:
    """The axis of some logs, with what the data decide of its equation; refused if a channel stands still."""
    if not logs:
        raise InputRefused("no log given: name at least one")
    torque, position = channels_of(logs[0])
    bandwidth, chosen = options.bandwidth, []
    for log in logs:
        for name in (torque, position):
            if np.ptp(log.channel(name)) == 0.0:
                raise InputRefused(f"{log.source}: {name} is constant: a log must move the axis")
        try:
            chosen.append(chosen_bandwidth(log.channel(position), log.interval) if bandwidth is None else 0.0)
        except InputRefused as refusal:
            raise refusal.at(log.source) from None
    if bandwidth is None:
        bandwidth = float(np.clip(max(chosen), *BANDWIDTH_LIMITS))
        bandwidth = min(bandwidth, *(0.2 * log.sample_rate for log in logs))
    longest = max(float(log.time[-1] - log.time[0]) for log in logs)
    if bandwidth * longest < 1.0:
        said = f"bandwidth = {bandwidth:.4g} Hz has no whole period in a log of {longest:.4g} s"
        raise InputRefused(f"{said}: raise it to {1.0 / longest:.4g} Hz or more")
    equation = AxisEquation(
        linear=logs[0].units[torque] == "N",
        bandwidth=bandwidth,
        filter=options.filter,
        friction=options.friction,
        quantum=max(log.report.quantum.get(position, 0.0) for log in logs),
        lag=options.lag,
    )
    return Axis(logs=tuple(logs), options=options, torque=torque, position=position, equation=equation)


def channels_of(log: Log) -> tuple[str, str]:
    """Channels of torque and angle, or force and position; refused if the log has neither pair."""
    for torque, position in (("torque", "angle"), ("force", "position")):
        if torque in log.channels and position in log.channels:
            return torque, position
    driven = "torque" in log.channels or "force" in log.channels
    example = "angle=my column:deg" if driven else "torque=my column:N m"
    raise InputRefused(
        f'{log.source}: needs "torque [N m]" and "angle [rad]", or "force [N]" and "position [m]"; '
        f'has {", ".join(log.channels)}: map the others as well, as --column "{example}"'
    )


def values_of(found: Identification) -> Array:
    """Values of the parameters in their order; a viscous friction that is not known counts as none."""
    values = found.values
    values[1] = np.nan_to_num(values[1])
    return values


def stacked(names: tuple[str, ...], parts: Sequence[tuple[Array, Array]], shortest: int = 20) -> Factors:
    """Regressors and left sides of several logs as one regression, in segments of so many rows at least."""
    count = max(12, SHORT_SEGMENTS // len(parts))
    return estimates.joined(
        [estimates.factor(x, y, names, max(2, min(count, y.size // shortest))) for x, y in parts]
    )


def factors_of(parts: Sequence[Rows]) -> Factors:
    """Rows of several logs as one regression."""
    return stacked(parts[0].names, [(rows.regressors, rows.left) for rows in parts])


def _without_lag(factors: Factors, doubt: float) -> Fit:
    """The fit of the parameters, the instant of the torque taken out: estimated beside them, or doubted."""
    fit = estimates.solve(factors)
    if LAG not in factors.names:
        return fit
    count = len(factors.names) - 1
    plain = estimates.solve(estimates.only(factors, factors.names[:count]))
    if not (fit.unidentifiable.size or np.sqrt(fit.covariance[-1, -1]) > LEAST_DETERMINED * doubt):
        values, covariance = fit.values[:count], fit.covariance[:count, :count]
        kept = replace(fit, names=plain.names, values=values, covariance=covariance)
        return replace(kept, condition=plain.condition)
    whole = estimates.triangle(factors.triangles.reshape(-1, count + 2))
    moved = doubt * np.linalg.lstsq(whole[:count, :count], whole[:count, count], rcond=None)[0]
    return replace(plain, covariance=plain.covariance + np.outer(moved, moved))


def _implausible(parameters: dict[str, Estimate]) -> tuple[Finding, ...]:
    """Numbers that no machine has: findings about the log, not results."""
    found = []
    against = next(iter(parameters.values())).value < 0.0  # the inertia
    for name, estimate in parameters.items():
        if not estimate.reason and estimate.high < 0.0 and not name.startswith("offset"):
            hint = "are torque and angle swapped, or is one sign reversed?"
            if not against:
                hint = "the friction model does not fit this axis"
            words = f"is identified as negative ({estimate.value:.4g} {estimate.unit})"
            found.append(Finding("negative", f"{estimates.readable(name)} {words}: {hint}"))
    return tuple(found)
