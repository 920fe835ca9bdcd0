r"""Parameters from the innovations of an observer: a feedback loop does them no harm.

Inside a loop the noise of the encoder comes back as torque; a regression of the torque on the motion, and a
simulation of the motion under the torque, are both biased by that. What an observer does not predict has
nothing to do with the past, whoever made the torque: the parameters, and the instant at which the torque
acts, make its whitened innovations smallest (L. Ljung, System Identification, 2nd ed., sections 7.2, 13.4).
The method is then applied to logs of a sound axis that moves alike, and what it misses there is in the
intervals, as is what each doubt would change in the parameters.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.identification.axis import observer
from cabledrive.identification.axis.axis import BASE, Axis, values_of
from cabledrive.identification.axis.observer import NotReproduced, Observed, Prediction, unseen
from cabledrive.identification.axis.timing import CONVENTIONS, FARTHEST, NEAR, SETTLED, TorqueTiming
from cabledrive.identification.estimates import Fit, Identification, triangle
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array

NAME = "prediction error, observer with set-valued friction, started from inverse dynamics"
COUNT = len(BASE)
SEED = 4017
"""Of the noise in logs of a sound axis: the same log gives the same result."""
SLOWEST = 0.15
"""Of the best observer's bandwidth: a slower one has less of the encoder quantisation in its prediction."""
PASSES, FULL_STEPS, DAMPING = 16, 3, 0.6
"""Steps, those made whole, and the share of later ones: the sign of a noisy speed makes them overshoot."""
CONVERGED = 0.2
"""Largest step of a parameter, in standard errors, at which the iteration ends."""
TIMINGS = 5
"""Corrections of the torque's instant."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Predicted:
    """Parameters under one law of the torque's instant, the last correction of them, and the observers."""

    timing: TorqueTiming  # as the innovations have it
    observed: Observed
    values: Array  # (4,), as `BASE`
    fit: Fit
    runs: list[Prediction]


def predict(axis: Axis, found: Identification, timing: TorqueTiming) -> tuple[Predicted, Identification]:
    """Prediction error from the torque's instant as found; where that loses the log, from a convention's."""
    if axis.saturated:
        raise NotComputed("the torque saturates")
    if found.parameters[axis.equation.inertia].high < 0.0:
        raise NotComputed("the inertia is negative: torque and angle are swapped, or one sign is reversed")
    try:
        return _refined(axis, found, timing)
    except NotReproduced:
        if timing.stated or not axis.options.lag:
            raise
    for name in sorted(CONVENTIONS, key=lambda name: abs(timing.off(name))):
        start = timing.at(name)
        begun = start.moved(axis).regressed()
        if np.all(np.isfinite(values_of(begun))):
            with suppress(NotReproduced):
                return _refined(axis, begun, start)
    raise NotReproduced


def _refined(axis: Axis, found: Identification, timing: TorqueTiming) -> tuple[Predicted, Identification]:
    """Under the better law of the torque's instant; several logs share the parameters."""
    best, other, lag = _under(axis, found, timing), None, axis.options.lag
    if lag and best.timing.shift < -NEAR * axis.interval:
        law = "low-pass" if best.timing.law == "shift" else "shift"
        with suppress(NotComputed):
            other = _under(axis, found, replace(best.timing, law=law))
        if other is not None and observer.whitened_power(other.runs) < observer.whitened_power(best.runs):
            best, other = other, best
    doubts = _doubts(best, lag)
    if other is not None:
        doubts.append(other.values - best.values)
    fits = [twin.fit(best.values, lag) for twin in best.observed.twins(best.values, SEED)]
    own = best.fit.covariance[:COUNT, :COUNT]
    extra = unseen([fit.values[:COUNT] for fit in fits], [fit.covariance[:COUNT, :COUNT] for fit in fits])
    extra += sum(np.outer(doubt, doubt) for doubt in doubts)
    extra += (best.observed.repetition(best.values) - 1.0) * own
    freedom = best.fit.freedom
    sound = replace(found.without("negative"), unidentifiable=())
    return best, sound.refitted(best.values, own + extra, freedom, {"name": NAME, "freedom": freedom})


def _under(axis: Axis, found: Identification, timing: TorqueTiming) -> Predicted:
    """Parameters and instant in turn, under one law of the instant."""
    values, lag, interval = values_of(found), axis.options.lag, axis.interval
    for number in range(TIMINGS):
        seen = observer.observed(timing.moved(axis), values, SLOWEST, timing.hold[0])
        values, fit = _settled(seen, values, lag)
        if not lag or number + 1 == TIMINGS:
            break
        late, error = float(fit.values[-1]), float(np.sqrt(fit.covariance[-1, -1]))
        if number and abs(late) < max(SETTLED * interval, 0.3 * error):
            break
        timing = replace(timing, shift=timing.shift - late, error=error, determined=True)
        if abs(timing.shift) > FARTHEST * interval:
            raise NotComputed(
                "the time shift of the torque found from the innovations is too large for an "
                "error of time stamps"
            )
    return Predicted(timing=timing, observed=seen, values=values, fit=fit, runs=seen.runs(values))


def _settled(seen: Observed, values: Array, lag: bool) -> tuple[Array, Fit]:
    """Parameters that leave the smallest innovations, and the last fit of what is left."""
    for number in range(PASSES):
        fit = seen.fit(values, lag)
        step, limit = fit.values[:COUNT], 0.5 * np.abs(values[[0, 2]])
        step[[0, 2]] = np.clip(step[[0, 2]], -limit, limit)
        values = values + (1.0 if number <= FULL_STEPS else DAMPING) * step
        if not np.all(np.isfinite(values)) or values[0] <= 0.0 or values[2] < 0.0:
            break
        if np.all(np.abs(step) <= CONVERGED * np.sqrt(np.diag(fit.covariance))[:COUNT]):
            return values, fit
    raise NotReproduced


def _doubts(best: Predicted, lag: bool) -> list[Array]:
    """What would change in the parameters, each (4,): the torque between samples, rounding, its instant."""
    every = len(observer.NUISANCE)
    factors = best.observed.factors(best.values, hold=best.timing.hold[1])
    whole = triangle(factors.triangles.reshape(-1, every + 2))
    doubts = [np.asarray(np.linalg.lstsq(whole[:every, :every], whole[:every, every], rcond=None)[0][:COUNT])]
    # a quicker observer believes more of the encoder's rounding
    quicker = tuple(observer.SLOWER / SLOWEST * width for width in best.observed.bandwidths)
    doubts.append(replace(best.observed, bandwidths=quicker).fit(best.values, lag).values[:COUNT])
    convention = best.timing.convention
    if lag and convention is not None:
        along = best.fit.covariance[:COUNT, -1] / best.fit.covariance[-1, -1]
        doubts.append(np.asarray(best.timing.off(convention) * along))
    return doubts
