r"""What a method misses on logs of its own making, and logs of a sound axis.

The rounding of an encoder and the instants of turns repeat from period to period; every segment of a log then
errs alike, and the spread of the segments' scores does not contain it. So the fitted axis is moved under the
measured torque, its angle is rounded at a few phases of the encoder, and the method is applied to that. What
the mean square of its misses has beyond the covariance that the scores claim there is added:

.. math:: C' = C + \Big[\frac1K\sum_k (m_k m_k^T - C_k)\Big]_+

Output error has two doubts more, each added by the product of its shift of the parameters with itself: what
the torque does between its samples, and how much of its noise the axis does not feel.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.integrate import cumulative_trapezoid
from scipy.linalg import solve_discrete_lyapunov

from cabledrive.identification.axis_case import (
    CORNER_DOUBT,
    Case,
    between_samples,
    case_of,
    columns_of,
    observed,
    simulated,
)
from cabledrive.identification.estimates import Estimate, Identification
from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.innovation_kernels import shadow
from cabledrive.identification.innovations import Track, observer_gains, predicted_angles
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import MOST_SEGMENTS, factor, joined, solve, suited_segments
from cabledrive.identification.rigid_axis import (
    SHORT_SEGMENTS,
    AxisOptions,
    channels_of,
    equation_for,
    identify_rigid_axis,
)
from cabledrive.parameters import NotComputed
from cabledrive.reduction.friction_integration import integrate_rigid_axis

Array = NDArray[np.float64]

FARTHEST = 1e6
"""Strokes of the log beyond which a motion of the fitted axis counts as diverging."""
RUNS_AWAY = "the motion of the fitted axis diverges under the measured torque"
PHASES = 4
"""Positions of the encoder that are tried."""


def rounded_angles(speed: Array, interval: float, quantum: float) -> Array:
    """Angle of a motion as an encoder at several phases shows it.

    ``speed``, shape (samples,) [rad/s]; ``interval`` [s]; ``quantum`` [rad]; 0: not rounded.
    Returns shape (samples, `PHASES`).
    """
    angle = cumulative_trapezoid(speed, dx=interval, initial=0.0)[:, None]
    phases = np.arange(PHASES) / PHASES
    return quantum * np.floor(angle / quantum + phases) if quantum > 0.0 else angle + 0.0 * phases


def error_of_refinement(cases: Sequence[Case], values: Array, speeds: Array) -> Array:
    """What scores do not show of the errors of output error, from motions of its own making.

    ``values``, shape (4,); ``speeds``, shape (cases,): at the start.
    Returns shape (4, 4).
    """
    lefts, rights, doubts = [], [], []
    for number, case in enumerate(cases):
        _, sensitivities = simulated(case, values, speeds[number])
        moved, _ = integrate_rigid_axis(
            values, case.torque, case.interval, start=speeds[number], slope=case.slope
        )
        shown = rounded_angles(moved, case.interval, case.quantum)
        seen = np.column_stack([observed(case, shown[:, k]) for k in range(PHASES)])
        off = case.compared(seen - case.filtered(moved)[:, None])
        changes = np.column_stack(
            [_between(case, values, speeds[number], moved), _noisier(case, values, speeds[number], moved)]
        )
        doubts.append(case.compared(case.filtered(changes)))
        lefts.append(columns_of(sensitivities, number, len(cases)))
        rights.append(off)
    names = tuple(str(k) for k in range(lefts[0].shape[1]))
    count = max(12, SHORT_SEGMENTS // len(cases))
    fits = []
    for k in range(PHASES):
        parts = [
            factor(left, right[:, k], names, min(count, left.shape[0] // 20))
            for left, right in zip(lefts, rights, strict=True)
        ]
        fits.append(solve(suited_segments(joined(parts), each=True)))
    doubt = np.linalg.lstsq(np.vstack(lefts), np.vstack(doubts), rcond=None)[0][:4]
    seen_not = unseen(np.array([f.values[:4] for f in fits]), np.array([f.covariance[:4, :4] for f in fits]))
    return seen_not + doubt @ doubt.T


def _between(case: Case, values: Array, start: float, moved: Array) -> Array:
    """What it changes in the speed whether the torque channel holds samples, means or means of steps."""
    changed = between_samples(case.torque, CORNER_DOUBT)
    return integrate_rigid_axis(values, changed, case.interval, start=start, slope=case.slope)[0] - moved


def _noisier(case: Case, values: Array, start: float, moved: Array) -> Array:
    """What noise of the torque channel changes in the mean: it blurs every turn, as a smaller friction does.

    How much of the noise the axis feels too, and how much is the channel's own, is not known: all of it is
    put on the torque once more, backwards in time and with either sign, so that only its square is left.
    """
    noise = (case.torque - case.lines)[::-1]
    either = [
        integrate_rigid_axis(
            values, case.torque + sign * noise, case.interval, start=start, slope=case.slope
        )[0]
        for sign in (1.0, -1.0)
    ]
    return 0.5 * (either[0] + either[1]) - moved


def unseen(misses: Array, claimed: Array) -> Array:
    """Mean products of misses beyond the covariance that was claimed for them.

    ``misses``, shape (repeats, p); ``claimed``, shape (repeats, p, p).
    Returns shape (p, p): without its negative directions.
    """
    excess = misses.T @ misses / len(misses) - claimed.mean(axis=0)
    size = np.sqrt(np.maximum(np.mean(misses**2, axis=0), 1e-300))
    level, direction = np.linalg.eigh(excess / size[:, None] / size)
    kept = size[:, None] * direction * np.sqrt(np.maximum(level, 0.0))
    return np.asarray(kept @ kept.T)


def with_own_error(
    found: Identification, logs: Sequence[Log], options: AxisOptions | None = None
) -> Identification:
    """Inverse dynamics with the errors that it makes on logs of its own making in its intervals.

    ``found``: by inverse dynamics, with constant or smooth Coulomb friction; ``options``: those it was found
    with.
    Returns as it was, and said, where the fitted axis cannot be moved or its own log is not identifiable.
    """
    options = options or AxisOptions()
    torque, position = channels_of(logs[0], options)
    equation = equation_for(logs, torque, position, options)
    values = np.array([estimate.value for estimate in found.parameters.values()])
    own = replace(options, bandwidth=equation.bandwidth)
    slope = options.friction.slope if options.friction.kind == "tanh" else 0.0
    try:
        angles = []
        for log in logs:
            start = case_of(log, torque, position, equation).start
            driven = between_samples(log.channel(torque))
            speed, _ = integrate_rigid_axis(values, driven, log.interval, start=start, slope=slope)
            farthest = FARTHEST * np.ptp(log.channel(position))
            if not np.abs(speed).max() * log.interval < farthest:  # before sums of it overflow
                raise NotComputed(RUNS_AWAY)
            angle = rounded_angles(speed, log.interval, log.report.quantum.get(position, 0.0))
            if not np.abs(angle).max() < farthest:
                raise NotComputed(RUNS_AWAY)
            angles.append(angle)
    except NotComputed as failure:
        return replace(found, method=dict(found.method) | {"own_error": f"not known: {failure}"})
    misses, claimed = [], []
    for k in range(PHASES):
        made = [
            replace(log, channels={**log.channels, position: angle[:, k]})
            for log, angle in zip(logs, angles, strict=True)
        ]
        again = identify_rigid_axis(made, own)
        misses.append([again[name] - found[name] for name in found.parameters])
        claimed.append(again.covariance)
    off = np.array(misses)
    if not np.all(np.isfinite(off)):
        return replace(found, method=dict(found.method) | {"own_error": "not known: not identifiable"})
    return widened(found, unseen(off, np.array(claimed)))


def widened(found: Identification, extra: Array) -> Identification:
    """An identification with more covariance.

    ``extra``, shape (p, p).
    """
    covariance = found.covariance + extra
    errors = np.sqrt(np.diag(covariance))
    factor = float(stats.t.ppf(0.975, found.freedom))
    parameters: dict[str, Estimate] = {
        name: replace(
            estimate,
            standard_error=float(error),
            low=float(estimate.value - factor * error),
            high=float(estimate.value + factor * error),
        )
        for (name, estimate), error in zip(found.parameters.items(), errors, strict=True)
    }
    words = "with the method's own error on logs of its own making"
    method = dict(found.method) | {"standard_errors": f"{found.method['standard_errors']}, {words}"}
    return replace(found, parameters=parameters, covariance=covariance, method=method)


COUNT = 4
"""Places of the encoder that are tried."""
SERVO = 1.0
"""Bandwidth of the servo that keeps the sound axis along the measured motion [Hz]."""
SMOOTH = 20.0
"""Bandwidth of the motion that it is kept along [Hz]."""


def reference_tracks(
    tracks: Sequence[Track], values: Array, bandwidths: Sequence[float], rng: np.random.Generator
) -> Iterator[list[Track]]:
    """Logs of a rigid axis with Coulomb friction beside the measured ones.

    A soft servo adds to the measured torque what keeps the axis near the measured motion; that torque is
    known. The angle is rounded as the encoder does, and the torque is as noisy as the innovations call for.

    ``values``, shape (4,); ``bandwidths``: of the observers [rad/s].
    Returns one for each track, `COUNT` times.
    """
    moved = [_beside(track, values) for track in tracks]
    noises = [_noises(track, values, width) for track, width in zip(tracks, bandwidths, strict=True)]
    for k in range(COUNT):
        made = []
        for track, (angle, torque), (rough, noisy) in zip(tracks, moved, noises, strict=True):
            q = track.quantum
            seen = (
                q * np.floor(angle / q + k / COUNT) if q > 0 else angle + rough * rng.normal(size=angle.size)
            )
            white = noisy * rng.normal(size=angle.size + 1)
            made.append(replace(track, position=seen, torque=torque + 0.5 * (white[1:] + white[:-1])))
        yield made


def _beside(track: Track, values: Array) -> tuple[Array, Array]:
    """Angle of the sound axis and the torque that acts on it."""
    smooth = min(SMOOTH, 0.2 / track.interval)
    along = zero_phase(track.position, track.interval, smooth)
    speed = difference(along, track.interval)
    omega = 2 * np.pi * SERVO
    gains = np.array([values[0] * omega**2, 2 * values[0] * omega])
    moved, acting = np.empty_like(along), np.empty_like(along)
    shadow(values, gains, track.torque, along, speed, track.interval, moved, acting)
    return moved, acting


def _noises(track: Track, values: Array, bandwidth: float) -> tuple[float, float]:
    """Deviations of the noise of angle and torque, from the power that innovations usually have."""
    parts = np.array_split(predicted_angles(track, values, bandwidth).innovation ** 2, MOST_SEGMENTS)
    power = float(np.median([part.mean() for part in parts]))
    by_angle, by_torque = innovation_powers(values[0], bandwidth, track.interval)
    rough = track.quantum**2 / 12.0 if track.quantum > 0.0 else 0.5 * power / by_angle
    return float(np.sqrt(rough)), float(np.sqrt(max(power - by_angle * rough, 0.0) / by_torque))


def innovation_powers(inertia: float, bandwidth: float, interval: float) -> tuple[float, float]:
    """Power of the innovation for white noise of power 1 in the angle, and in the torque.

    ``bandwidth``: of the observer [rad/s]; ``interval`` [s].
    Returns ``by_angle, by_torque``: of the second the unit is [rad^2/(N m)^2].
    """
    gains = observer_gains(bandwidth, interval)
    forward = np.array([[1.0, interval], [0.0, 1.0]])
    corrected = forward @ (np.eye(2) - np.outer(gains, [1.0, 0.0]))
    noise = forward @ gains, np.array([0.5 * interval**2, interval]) / inertia
    angle, torque = (solve_discrete_lyapunov(corrected, np.outer(b, b))[0, 0] for b in noise)
    return 1.0 + float(angle), float(torque)
