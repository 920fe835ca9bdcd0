r"""Output error of one rigid axis: the motion is simulated, so no regressor carries the encoder's noise.

Inverse dynamics takes speed and its sign from the encoder, whose errors bias it. Here the model moves by
itself under the measured torque. The parameters solve :math:`Z^T r = 0`, where r is the filtered difference
of speeds and Z the exact sensitivities along the motion under the torque's spectral lines alone: noise of the
torque must not be in both factors. Inside a feedback loop the model does not follow, and that is said.

Rounding and the instants of turns repeat from period to period, so that the spread of the segments' scores
does not contain them. The fitted axis is moved under the measured torque, its angle rounded at a few phases
of the encoder, and what the mean square of the method's misses there has beyond what the scores claim is
added:

.. math:: C' = C + \Big[\frac1K\sum_k (m_k m_k^T - C_k)\Big]_+
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from scipy.integrate import cumulative_trapezoid

from cabledrive.identification.axis.axis import BASE, Axis, stacked, values_of
from cabledrive.identification.axis.equation import LAG, settling
from cabledrive.identification.axis.observer import CORNER_DOUBT, between_samples
from cabledrive.identification.axis.timing import spectral_lines
from cabledrive.identification.estimates import Factors, Fit, Identification, solve, suited_segments
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import difference, rms, zero_phase
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import integrate_rigid_axis

BANDWIDTH = 50.0
"""Of the compared speeds [Hz]."""
LATER = 0.05
"""Step of the torque's instant by which its sensitivity is taken [intervals]."""
PASSES, CONVERGED, HALVINGS, SLACK = 12, 0.1, 5, 1e-3
"""Steps; the largest one, in standard errors, at which they end; halvings of one that raises the residual by
more than a share, for near the end the sensitivities are not quite its gradient."""
LARGEST_RESIDUAL = 0.5
FARTHEST = 1e6
"""Strokes of the log beyond which a motion of the fitted axis counts as diverging."""
PHASES = 4
"""Positions of the encoder that are tried."""
NOT_FOLLOWED = "not-followed"
NAME = "output error on the speed, exact sensitivities, started from inverse dynamics"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """One log, ready to be simulated: torque and its lines, measured speed, where and how it is compared."""

    torque: Array
    lines: Array
    speed: Array
    start: float
    interval: float
    inner: slice
    bandwidth: float
    slope: float
    quantum: float = 0.0
    lag: bool = False

    def filtered(self, values: Array) -> Array:
        """Signals below the bandwidth."""
        return zero_phase(values, self.interval, self.bandwidth)

    def moved(
        self, values: Array, torque: Array, start: float, *, varied: bool = False
    ) -> tuple[Array, Array]:
        """Speed of the model under a torque, and its sensitivities where they are asked for."""
        return integrate_rigid_axis(
            values, torque, self.interval, start=start, slope=self.slope, varied=varied
        )

    def residual(self, values: Array, start: float) -> tuple[Array, Array]:
        """Filtered difference of speeds, and sensitivities alike: of `BASE`, the start, the lag."""
        moved, _ = self.moved(values, self.torque, start)
        before, along = self.moved(values, self.lines, start, varied=True)
        columns = [moved, along]
        if self.lag:
            after, _ = self.moved(values, self.lines - LATER * np.gradient(self.lines), start)
            with np.errstate(invalid="ignore", over="ignore"):  # a motion that runs away: refused below
                columns.append((after - before) / (LATER * self.interval))
        filtered = self.filtered(np.column_stack(columns))
        rows = np.column_stack([self.speed - filtered[:, 0], filtered[:, 1:]])[self.inner]
        if not np.all(np.isfinite(rows)):
            raise NotComputed("the model does not reproduce the log in open loop: its motion diverges")
        return rows[:, 0], rows[:, 1:]


def case_of(axis: Axis, log: Log) -> Case:
    """Prepare one log."""
    torque, bandwidth = log.channel(axis.torque), min(BANDWIDTH, 0.2 * log.sample_rate)
    edge = settling(bandwidth, log.interval)
    return Case(
        torque=between_samples(torque),
        lines=between_samples(spectral_lines(torque)),
        speed=zero_phase(difference(log.channel(axis.position), log.interval), log.interval, bandwidth),
        start=axis.start(log),
        interval=log.interval,
        inner=slice(edge, len(log) - edge),
        bandwidth=bandwidth,
        slope=axis.slope,
        quantum=axis.equation.quantum,
        lag=axis.equation.lag,
    )


def refined(axis: Axis, found: Identification) -> Identification:
    """Refine inverse dynamics by output error; `NotComputed` if the model does not follow the logs."""
    if axis.options.friction.kind not in ("coulomb", "tanh") or not found.identifiable:
        raise NotComputed("output error needs an identifiable rigid axis with one Coulomb friction")
    cases = [case_of(axis, log) for log in axis.logs]
    speeds = np.array([case.start for case in cases])
    values, speeds, fit = _solved(cases, found.values, speeds)
    left = rms(*(case.residual(values, v)[0] for case, v in zip(cases, speeds, strict=True)))
    size = rms(*(case.speed[case.inner] for case in cases))
    if not left <= LARGEST_RESIDUAL * size:
        raise NotComputed(
            f"the model does not reproduce the log in open loop (residual {100 * left / size:.0f} % of the "
            "speed): a feedback loop controls the axis, or the model is wrong"
        )
    residual = {"rms": left, "relative": left / size, "rows": fit.rows}
    covariance, freedom = fit.covariance[:4, :4] + _own_error(cases, values, speeds), fit.freedom
    method = {"name": NAME, "residual_of": "speed", "freedom": freedom}
    return replace(found, residual=residual).refitted(values, covariance, freedom, method)


def _solved(cases: list[Case], values: Array, speeds: Array) -> tuple[Array, Array, Fit]:
    """Gauss-Newton steps until they are small; halved where one beyond its errors raised the residual."""
    factors, residual = _linearised(cases, values, speeds)
    for _ in range(PASSES):
        fit = solve(suited_segments(factors, each=True))
        step, errors = fit.values, np.sqrt(np.diag(fit.covariance))[:4]
        near = bool(np.all(np.abs(step[:4]) <= errors))
        for _ in range(HALVINGS):
            limit = np.append(0.5 * np.abs(values[:3]), np.inf)  # no inertia or friction by more than half
            tried = values + np.clip(step[:4], -limit, limit), speeds + step[4 : 4 + len(cases)]
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
    rows = [case.residual(values, v) for case, v in zip(cases, speeds, strict=True)]
    left = rms(*(residual for residual, _ in rows))
    if not left < inf:
        raise NotComputed(
            "the motion of the fitted axis diverges: a feedback loop controls it, or the model is wrong"
        )
    names = (*BASE, *(f"start {k}" for k in range(len(cases))), *((LAG,) if cases[0].lag else ()))
    parts = [(_apart(slopes, k, len(cases)), residual) for k, (residual, slopes) in enumerate(rows)]
    return stacked(names, parts), left


def _apart(slopes: Array, number: int, count: int) -> Array:
    """Sensitivities of one of several logs: each has its own speed at the start."""
    starts = np.zeros((len(slopes), count))
    starts[:, number] = slopes[:, 4]
    return np.hstack([slopes[:, :4], starts, slopes[:, 5:]])


def _own_error(cases: list[Case], values: Array, speeds: Array) -> Array:
    """What scores do not show, from motions of its own making, and two doubts about the torque, (4, 4)."""
    lefts, rights, doubts = [], [], []
    for number, (case, start) in enumerate(zip(cases, speeds, strict=True)):
        moved, _ = case.moved(values, case.torque, start)
        shown = rounded_angles(moved, case.interval, case.quantum)
        seen = np.column_stack([case.filtered(difference(angle, case.interval)) for angle in shown.T])
        rights.append((seen - case.filtered(moved)[:, None])[case.inner])
        between, _ = case.moved(values, between_samples(case.torque, CORNER_DOUBT), start)
        # Noise of the torque channel blurs turns, as a smaller friction does. How much of it the axis feels
        # is not known: all of it once more, backwards and with either sign, so that only its square is left.
        noise = (case.torque - case.lines)[::-1]
        more, less = (case.moved(values, case.torque + sign * noise, start)[0] for sign in (1.0, -1.0))
        changes = np.column_stack([between - moved, 0.5 * (more + less) - moved])
        doubts.append(case.filtered(changes)[case.inner])
        lefts.append(_apart(case.residual(values, start)[1], number, len(cases)))
    names = tuple(str(k) for k in range(lefts[0].shape[1]))
    fits = []
    for k in range(PHASES):
        parts = [(left, right[:, k]) for left, right in zip(lefts, rights, strict=True)]
        fits.append(solve(suited_segments(stacked(names, parts), each=True)))
    doubt = np.linalg.lstsq(np.vstack(lefts), np.vstack(doubts), rcond=None)[0][:4]
    return unseen([f.values[:4] for f in fits], [f.covariance[:4, :4] for f in fits]) + doubt @ doubt.T


def rounded_angles(speed: Array, interval: float, quantum: float) -> Array:
    """Angle of a motion as an encoder at several phases shows it, shape (samples, phases)."""
    angle = cumulative_trapezoid(speed, dx=interval, initial=0.0)[:, None]
    phases = np.arange(PHASES) / PHASES
    return quantum * np.floor(angle / quantum + phases) if quantum > 0.0 else angle + 0.0 * phases


def unseen(misses: Sequence[Array], claimed: Sequence[Array]) -> Array:
    """Mean products of misses beyond the covariance that was claimed for them."""
    off = np.array(misses)
    excess = off.T @ off / len(off) - np.mean(claimed, axis=0)
    size = np.sqrt(np.maximum(np.mean(off**2, axis=0), 1e-300))
    level, direction = np.linalg.eigh(excess / size[:, None] / size)
    kept = size[:, None] * direction * np.sqrt(np.maximum(level, 0.0))
    return np.asarray(kept @ kept.T)


def with_own_error(axis: Axis, found: Identification) -> Identification:
    """Inverse dynamics with its own errors in its intervals; as it was, and said, where they are unknown."""
    angles, values = [], values_of(found)
    for log in axis.logs:
        driven, farthest = (
            between_samples(log.channel(axis.torque)),
            FARTHEST * np.ptp(log.channel(axis.position)),
        )
        try:
            start = axis.start(log)
            speed, _ = integrate_rigid_axis(values, driven, log.interval, start=start, slope=axis.slope)
            stays = np.abs(speed).max() * log.interval < farthest  # before sums of it overflow
        except NotComputed:
            stays = False
        if stays:
            angles.append(rounded_angles(speed, log.interval, log.report.quantum.get(axis.position, 0.0)))
        if not (stays and np.abs(angles[-1]).max() < farthest):
            diverges = "the motion of the fitted axis diverges under the measured torque"
            return found.noting(own_error=f"not known: {diverges}")
    fits = [axis.having(axis.position, (a[:, k] for a in angles)).regressed() for k in range(PHASES)]
    misses = [fit.values - found.values for fit in fits]
    if not np.all(np.isfinite(misses)):
        return found.noting(own_error="not known: not identifiable")
    return found.widened(unseen(misses, [fit.covariance for fit in fits]))
