r"""What a log does that a rigid axis does not predict, and whether feedback makes its torque.

An observer moves the axis under the measured torque, with set-valued friction, and corrects it at every
sample by the measured angle:

.. math:: e_k = \theta_k - \hat\theta_k, \qquad \hat\theta + g_1 e_k, \quad \hat\omega + g_2 e_k

An autoregression makes the innovations e white. They then have nothing to do with what was known before,
whoever made the torque: a feedback loop does no harm. A disturbing torque that is known up to a factor adds
to the prediction what the linearised observer answers. L. Ljung, System Identification, 2nd ed., Prentice
Hall 1999, sections 7.2 and 13.4.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from scipy.linalg import solve_toeplitz

from cabledrive.identification.axis_case import between_samples
from cabledrive.identification.innovation_kernels import answers, observe
from cabledrive.identification.inverse_dynamics import settling
from cabledrive.identification.regression import Factors, factor
from cabledrive.identification.torque_timing import spectral_lines
from cabledrive.parameters import NotComputed

Array = NDArray[np.float64]


class NotReproduced(NotComputed):
    """An observer with the inertia and friction of the axis does not reproduce the log."""

    def __init__(self) -> None:
        super().__init__("an observer with the inertia and friction of the axis does not reproduce the log")


HELD = 8 / 48
"""Second difference taken off the torque: half-way between the 4/48 of point samples and the 12/48 of means
over the interval of a torque that a controller holds from sample to sample."""
HELD_DOUBT = 4 / 48
"""Distance to both."""
ORDER = 30
"""Of the autoregression."""
SLOWEST, FASTEST, TRIED = 2.0, 200.0, 14
"""Observers that are tried [Hz]."""
SLOWER = 0.4
"""Of the best observer's bandwidth: what the encoder's rounding does to a slow axis is no noise, and a slower
observer believes it less; the autoregression makes up for it."""


LOST = 1e100
"""Size of an innovation from which its square may leave the finite numbers."""
SHORTEST = 60
"""Samples of a segment."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """One log as the observer takes it."""

    torque: Array  # (samples,): mean from each sample to the next
    position: Array  # (samples,)
    start: float  # speed at the first sample
    interval: float  # [s]
    quantum: float  # step of the encoder; 0: none


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction:
    """The observer's run along a track."""

    values: Array  # (4,): Inertia, viscous friction, Coulomb friction, offset
    gains: Array  # (2,)
    # innovation, speed, acceleration, direction, jump: (samples,): of the angle; predicted motion; 0 where
    # the axis sticks; factor of a sensitivity over a turn
    innovation: Array
    speed: Array
    acceleration: Array
    direction: Array
    jump: Array


def held(torque: Array, share: float = HELD) -> Array:
    """Mean torque from each sample to the next.

    ``torque``, shape (samples,): as logged; ``share``: of the second difference that is taken off.
    Returns shape (samples,).
    """
    corners = between_samples(torque, share)
    mean = corners.copy()
    mean[:-1] = 0.5 * (corners[1:] + corners[:-1])
    return mean


def predicted_angles(track: Track, values: Array, bandwidth: float) -> Prediction:
    """Run the observer.

    ``values``, shape (4,); ``bandwidth`` [rad/s].
    """
    gains = observer_gains(bandwidth, track.interval)
    out = np.empty((5, track.position.size))
    start = np.array([track.position[0], track.start])
    observe(np.array(values, dtype=float), gains, track.torque, track.position, start, track.interval, out)
    return Prediction(
        values=values,
        gains=gains,
        innovation=out[0],
        speed=out[1],
        acceleration=out[2],
        direction=out[3],
        jump=out[4],
    )


def observer_gains(bandwidth: float, interval: float) -> Array:
    """Gains of angle and speed, for two poles with the damping 0.7.

    ``bandwidth`` [rad/s]; ``interval`` [s].
    Returns shape (2,).
    """
    return np.array([np.sqrt(2.0) * bandwidth * interval, bandwidth**2 * interval])


def best_bandwidth(track: Track, values: Array) -> float:
    """Bandwidth of the observer whose innovations are smallest.

    ``values``, shape (4,).
    Returns [rad/s].
    Raises `NotComputed` if none follows the log.
    """
    top = min(FASTEST, 0.05 / track.interval)
    tried = 2 * np.pi * np.geomspace(SLOWEST, top, TRIED)
    edge = settling(SLOWEST, track.interval) if track.position.size > 4000 else 0
    sizes = np.array([np.mean(predicted_angles(track, values, w).innovation[edge:] ** 2) for w in tried])
    if not np.isfinite(sizes).any():
        raise NotReproduced
    return float(tried[int(np.nanargmin(sizes))])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Following:
    """The run of the observer that follows a log best."""

    track: Track
    run: Prediction
    bandwidth: float  # of the observer [rad/s]
    # (samples,): torque that it adds to the measured one to follow the angle: what the axis leaves
    # unexplained
    added: Array


def follow(track: Track, values: Array) -> Following:
    """Run the observer that follows a log best.

    ``values``, shape (4,): inertia, viscous friction, Coulomb friction, offset.
    Raises `NotComputed` if none follows the log.
    """
    bandwidth = best_bandwidth(track, values)
    run = predicted_angles(track, values, bandwidth)
    added = values[0] * run.gains[1] / track.interval * run.innovation
    return Following(track=track, run=run, bandwidth=bandwidth, added=added)


def answered(track: Track, run: Prediction, torques: Mapping[str, Array]) -> Array:
    """What disturbing torques add to the innovation, shape (disturbances, samples)."""
    out = np.empty((len(torques), track.position.size))
    columns = np.array(list(torques.values()))
    answers(run.values, run.gains, columns, run.direction, run.jump, track.interval, out)
    return out


def autoregression(values: Array, order: int = ORDER) -> Array:
    """Filter that makes a stationary signal white and of deviation 1, by Yule and Walker.

    ``values``, shape (samples,).
    Returns shape (order + 1,).
    """
    products = np.array([values[k:] @ values[: values.size - k] for k in range(order + 1)]) / values.size
    products[0] *= 1.0 + 1e-9
    past = solve_toeplitz(products[:-1], products[1:])
    weights = np.concatenate([[1.0], -past])
    return weights / np.sqrt(max(float(weights @ products), 1e-300))


def regression(track: Track, run: Prediction, torques: Mapping[str, Array], segments: int) -> Factors:
    """Whitened innovations against what each disturbance would add, by segments of time.

    Raises `NotComputed` if the log is too short, or the observer leaves the finite numbers.
    """
    rows = np.vstack([answered(track, run, torques), run.innovation])
    if not np.all(np.abs(rows) < LOST):
        raise NotReproduced
    edge = min(track.position.size // 10, settled(run, track.interval))
    white = signal.oaconvolve(rows, autoregression(run.innovation[edge:])[None, :], axes=1)
    white = white[:, edge + ORDER : track.position.size]
    if white.shape[1] < SHORTEST * segments:
        raise NotComputed(f"{white.shape[1]} samples are too few for {segments} segments: record longer")
    return factor(white[:-1].T, white[-1], tuple(torques), segments)


def settled(run: Prediction, interval: float) -> int:
    """Samples after which the observer has forgotten its start.

    ``interval`` [s].
    """
    return int(np.ceil(8.0 * run.gains[0] / (run.gains[1] * interval)))


REACH = 20
"""Samples after an innovation in which the torque is looked at."""
BEYOND = 6.0
"""Standard errors of a correlation that are beyond chance."""


def feedback_significance(torque: Array, run: Prediction, late: int) -> float:
    """Largest correlation of the torque with innovations before it, in standard errors.

    ``torque``, shape (samples,): as logged; ``run``: of an observer along the same samples; ``late``: samples
    by which the torque channel is logged late: their correlations are no feedback.
    """
    lines = spectral_lines(torque)
    noise = torque if lines is torque else torque - lines
    cause = np.convolve(run.innovation, autoregression(run.innovation), "valid")
    effect = np.convolve(noise, autoregression(noise), "valid")
    size = effect.size
    norm = float(np.linalg.norm(cause) * np.linalg.norm(effect))
    if norm == 0.0:
        return 0.0
    lags = range(1 + late, REACH + late)
    return float(np.sqrt(size) / norm * max(abs(float(cause[: size - k] @ effect[k:])) for k in lags))


def inside_a_loop(
    torques: Sequence[Array], tracks: Sequence[Track], runs: Sequence[Prediction], shift: float
) -> bool:
    """Whether the torque of any log answers to the angle.

    ``torques``: as logged; ``shift``: time by which the torque acts later than it is logged [s].
    """
    late = [max(0, int(np.ceil(-shift / track.interval + 0.5))) for track in tracks]
    cases = zip(torques, runs, late, strict=True)
    return any(feedback_significance(*one) > BEYOND for one in cases)
