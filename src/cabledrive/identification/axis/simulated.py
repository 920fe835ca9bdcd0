r"""Output error of one rigid axis: the motion is simulated, so no regressor carries the encoder's noise.

Inverse dynamics takes speed and its sign from the encoder, whose errors bias it. Here the model moves by
itself under the measured torque. The parameters solve :math:`Z^T r = 0`, where r is the filtered difference
of speeds and Z the exact sensitivities along the motion under the torque's spectral lines alone: noise of the
torque must not be in both factors. Inside a feedback loop the model does not follow, and that is said.

Rounding and the instants of turns repeat from period to period, so that the spread of the segments' scores
does not contain them. The method is applied to logs of a sound axis that moves alike, and what the mean
square of its misses there has beyond what the scores claim is added:

.. math:: C' = C + \Big[\frac1K\sum_k (m_k m_k^T - C_k)\Big]_+
"""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from cabledrive.identification.axis.axis import BASE, Axis, stacked
from cabledrive.identification.axis.equation import LAG, settling
from cabledrive.identification.axis.observer import between_samples, twin_axes, unseen
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
SEED = 4018
"""Of the noise in logs of a sound axis: the same log gives the same result."""
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
    covariance, freedom = fit.covariance[:4, :4] + _own_error(axis, values), fit.freedom
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
    parts = []
    for number, (residual, slopes) in enumerate(rows):
        starts = np.zeros((len(slopes), len(cases)))
        starts[:, number] = slopes[:, 4]
        parts.append((np.hstack([slopes[:, :4], starts, slopes[:, 5:]]), residual))
    return stacked(names, parts), left


def _own_error(axis: Axis, values: Array) -> Array:
    """What scores do not show, from logs of a sound axis that moves alike, (4, 4)."""
    misses, claimed = [], []
    for twin in twin_axes(axis, values, SEED):
        cases = [case_of(twin, log) for log in twin.logs]
        found, _, fit = _solved(cases, values, np.array([case.start for case in cases]))
        misses.append(found - values)
        claimed.append(fit.covariance[:4, :4])
    return unseen(misses, claimed)
