"""Parameters from the innovations of an observer: a feedback loop does them no harm.

Inside a loop the noise of the encoder comes back as torque; a regression of the torque on the motion, and a
simulation of the motion under the torque, are both biased by that. What an observer does not predict has
nothing to do with the past, whoever made the torque: the parameters, and the instant at which the torque
acts, make its whitened innovations smallest (L. Ljung, System Identification, 2nd ed., sections 7.2, 13.4).
The method is then applied to logs of a sound axis that moves alike, and what it misses there is in the
intervals.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Identification, code_of
from cabledrive.identification.innovations import (
    SLOWER,
    NotReproduced,
    Prediction,
    Track,
    autoregression,
    best_bandwidth,
    predicted_angles,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.loop_check import BASE, NUISANCE, design_effect, joint_factors, tracks_of
from cabledrive.identification.method_error import reference_tracks, unseen, widened
from cabledrive.identification.regression import Factors, Fit, only, solve, suited_segments, triangle
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, identify_rigid_axis
from cabledrive.identification.torque_timing import (
    CONVENTIONS,
    FARTHEST,
    NEAR,
    SETTLED,
    TorqueTiming,
    with_torque_moved,
)
from cabledrive.parameters import NotComputed

Array = NDArray[np.float64]

NAME = "prediction error, observer with set-valued friction, started from inverse dynamics"
NOISE_SEED = 4017
SLOWEST = 0.15
"""Of the best observer's bandwidth: a slower one has less of the encoder quantisation in its prediction."""
PASSES = 16
FULL_STEPS, DAMPING = 3, 0.6
"""Steps made whole; later ones are shortened: the sign of a noisy speed makes them overshoot."""
TIMINGS = 5
"""Corrections of the torque's instant."""
CONVERGED = 0.2
"""Largest step of a parameter, in standard errors, at which the iteration ends."""


def refine_by_prediction(
    logs: Sequence[Log], found: Identification, options: AxisOptions, timing: TorqueTiming
) -> "Predicted":
    """Refine inverse dynamics by prediction error; several logs share the parameters.

    ``logs``: as they were read; ``found``: by inverse dynamics, with Coulomb friction; ``options``: those it
    was found with; ``timing``: where the torque was moved for it.
    Raises `NotComputed` if the observer does not follow the logs.
    """
    best, other = _refined(logs, found, options, timing), None
    if options.lag and best.timing.shift < -NEAR * logs[0].interval:
        law = "low-pass" if best.timing.law == "shift" else "shift"
        try:
            other = _refined(logs, found, options, replace(best.timing, law=law))
        except NotComputed:
            other = None
        if other is not None and other.power < best.power:
            best, other = other, best
    doubts = [_doubt_of_hold(best, logs[0].interval), _doubt_of_observer(best, options.lag)]
    if options.lag:
        doubts.append(_doubt_of_instant(best, logs[0].interval))
    if other is not None:
        doubts.append(other.values - best.values)
    extra = _own_error(best.tracks, best.values, best.bandwidths, options.lag)
    extra += sum(np.outer(doubt, doubt) for doubt in doubts)
    repeated = design_effect(best.tracks, best.runs)
    extra += (repeated - 1.0) * best.fit.covariance[: len(BASE), : len(BASE)]
    return Predicted(
        identification=_concluded(found, best.values, best.fit, extra),
        timing=best.timing,
        tracks=best.tracks,
        runs=best.runs,
        values=best.values,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Predicted:
    """An identification by prediction error, with the observer's runs."""

    identification: Identification
    timing: TorqueTiming  # as the innovations have it
    tracks: list[Track]
    runs: list[Prediction]
    values: Array  # (4,): Inertia, viscous friction, Coulomb friction, offset


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Refined:
    """Parameters under one law of the torque's instant, and the power of the whitened innovations."""

    timing: TorqueTiming
    tracks: list[Track]
    bandwidths: list[float]
    values: Array
    fit: Fit
    runs: list[Prediction]
    power: float


def _refined(
    logs: Sequence[Log], found: Identification, options: AxisOptions, timing: TorqueTiming
) -> _Refined:
    torque, _ = channels_of(logs[0], options)
    values = np.array([estimate.value for estimate in found.parameters.values()])
    values[1] = np.nan_to_num(values[1])
    interval = max(log.interval for log in logs)
    for number in range(TIMINGS):
        share, _ = timing.hold(interval)
        tracks = tracks_of(with_torque_moved(logs, torque, timing), options, share)
        bandwidths = [SLOWEST * best_bandwidth(track, values) for track in tracks]
        values, fit = settled(tracks, values, bandwidths, options.lag)
        if not options.lag or number + 1 == TIMINGS:
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
    runs = [predicted_angles(*one) for one in zip(tracks, [values] * len(tracks), bandwidths, strict=True)]
    white = [autoregression(run.innovation[run.innovation.size // 20 :])[0] for run in runs]
    power = float(np.mean([1.0 / one**2 for one in white]))
    return _Refined(
        timing=timing, tracks=tracks, bandwidths=bandwidths, values=values, fit=fit, runs=runs, power=power
    )


def _doubt_of_instant(refined: _Refined, interval: float) -> Array:
    """What the instant of the convention that the torque's agrees with would change in the parameters."""
    name = refined.timing.convention(interval)
    if name is None:
        return np.zeros(len(BASE))
    moved = CONVENTIONS[name] * interval - refined.timing.shift
    along = refined.fit.covariance[: len(BASE), -1] / refined.fit.covariance[-1, -1]
    return np.asarray(moved * along)


def _doubt_of_observer(refined: _Refined, lag: bool) -> Array:
    """What a quicker observer, which believes more of the encoder's rounding, would change."""
    quicker = [SLOWER / SLOWEST * width for width in refined.bandwidths]
    return np.asarray(_fitted(refined.tracks, refined.values, quicker, lag).values[: len(BASE)])


def _doubt_of_hold(refined: _Refined, interval: float) -> Array:
    """What it changes in the parameters how the torque runs between its samples."""
    _, doubt = refined.timing.hold(interval)
    factors = joint_factors(refined.tracks, refined.values, refined.bandwidths, hold=doubt)
    whole = triangle(factors.triangles.reshape(-1, factors.triangles.shape[2]))
    count = len(NUISANCE)
    return np.asarray(
        np.linalg.lstsq(whole[:count, :count], whole[:count, count], rcond=None)[0][: len(BASE)]
    )


def settled(
    tracks: Sequence[Track], values: Array, bandwidths: Sequence[float], lag: bool
) -> tuple[Array, Fit]:
    """Parameters that leave the smallest innovations, and the last fit of what is left.

    ``values``, shape (4,): to begin with; ``bandwidths``: of the observers [rad/s]; ``lag``: whether the
    instant of the torque is free.
    Returns shape (4,).
    Raises `NotComputed` if the steps do not come to an end, or the parameters are no machine's.
    """
    damped = 1.0
    for number in range(PASSES):
        fit = _fitted(tracks, values, bandwidths, lag)
        step = fit.values[: len(BASE)]
        limit = 0.5 * np.abs(values[[0, 2]])
        step[[0, 2]] = np.clip(step[[0, 2]], -limit, limit)
        values = values + damped * step
        if not np.all(np.isfinite(values)) or values[0] <= 0.0 or values[2] < 0.0:
            break
        if np.all(np.abs(step) <= CONVERGED * np.sqrt(np.diag(fit.covariance))[: len(BASE)]):
            return values, fit
        if number >= FULL_STEPS:
            damped = DAMPING
    raise NotReproduced


def _fitted(tracks: Sequence[Track], values: Array, bandwidths: Sequence[float], lag: bool) -> Fit:
    factors: Factors = joint_factors(tracks, values, bandwidths)
    if not np.all(np.isfinite(factors.triangles)):
        raise NotReproduced
    return solve(suited_segments(factors if lag else only(factors, BASE), each=True))


def _own_error(tracks: Sequence[Track], values: Array, bandwidths: Sequence[float], lag: bool) -> Array:
    """What scores do not show of the errors, from logs of a sound axis."""
    misses, claimed = [], []
    for made in reference_tracks(tracks, values, bandwidths, np.random.default_rng(NOISE_SEED)):
        fit = _fitted(made, values, bandwidths, lag)
        misses.append(fit.values[: len(BASE)])
        claimed.append(fit.covariance[: len(BASE), : len(BASE)])
    return unseen(np.array(misses), np.array(claimed))


def _concluded(found: Identification, values: Array, fit: Fit, extra: Array) -> Identification:
    count = len(BASE)
    parameters = {
        name: replace(estimate, value=float(values[k]), reason="")
        for k, (name, estimate) in enumerate(found.parameters.items())
    }
    method = dict(found.method) | {"name": NAME, "freedom": fit.freedom}
    refined = replace(
        found,
        parameters=parameters,
        method=method,
        covariance=fit.covariance[:count, :count],
        freedom=fit.freedom,
        identifiable=True,
        unidentifiable=(),
        findings=tuple(one for one in found.findings if code_of(one) != "negative"),
    )
    return widened(refined, extra)


def predict_from_some_instant(
    logs: Sequence[Log], found: Identification, options: AxisOptions, timing: TorqueTiming
) -> Predicted:
    """Prediction error from the torque's instant as found; where that loses the log, from a convention's.

    Inside a feedback loop the regression's instant can be off by more than the observer finds back from.
    """
    try:
        return refine_by_prediction(logs, found, options, timing)
    except NotReproduced:
        if timing.known or not options.lag:
            raise
    torque, _ = channels_of(logs[0], options)
    interval = max(log.interval for log in logs)
    for name in sorted(CONVENTIONS, key=lambda name: abs(CONVENTIONS[name] * interval - timing.shift)):
        start = replace(timing, shift=CONVENTIONS[name] * interval, law="shift")
        begun = identify_rigid_axis(with_torque_moved(logs, torque, start), options)
        if begun.identifiable:
            with suppress(NotReproduced):
                return refine_by_prediction(logs, begun, options, start)
    raise NotReproduced
