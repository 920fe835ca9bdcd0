r"""What the logs of an axis do that a rigid axis does not predict from the past.

An observer moves the axis under the measured torque, with set-valued friction, and corrects it at every
sample by the measured angle:

.. math:: e_k = \theta_k - \hat\theta_k, \qquad \hat\theta + g_1 e_k, \quad \hat\omega + g_2 e_k

An autoregression makes the innovations e white. They then have nothing to do with what was known before,
whoever made the torque: a feedback loop does no harm. A disturbing torque that is known up to a factor adds
to the prediction what the linearised observer answers (L. Ljung, System Identification, 2nd ed., Prentice
Hall 1999, sections 7.2, 13.4). What a method finds in logs of a sound axis that moves as the measured one
did, its angle rounded and its torque noisy (`Observed.twins`), is its own error.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import fft, signal
from scipy.linalg import solve_discrete_lyapunov, solve_toeplitz

from cabledrive.identification import estimates
from cabledrive.identification.axis.axis import BASE, Axis
from cabledrive.identification.axis.equation import answers, observe, settling, shadow
from cabledrive.identification.estimates import Factors, Fit
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array

NUISANCE = (*BASE, "lag")
HOLD = "hold"
HELD, HELD_DOUBT = 8 / 48, 4 / 48
"""Second difference off the torque, half-way from point samples to means of a held one; distance to both."""
CORNER, CORNER_DOUBT = 6 / 48, 2 / 48
"""The same between point samples and means of a smooth torque."""
ORDER = 30
"""Of the autoregression."""
SLOWEST, FASTEST, TRIED = 2.0, 200.0, 14
"""Observers that are tried [Hz]."""
SLOWER = 0.4
"""Of the best observer's bandwidth: what the encoder's rounding does to a slow axis is no noise, and a slower
observer believes it less; the autoregression makes up for it."""
LOST = 1e100
"""Size of an innovation from which its square may leave the finite numbers."""
SHORTEST, SEGMENT = 60, 80
"""Samples of a segment at least, and in a log that is long enough for few of them."""
TWINS, SERVO, SMOOTH = 4, 1.0, 20.0
"""Places of the encoder; bandwidths of the servo and of the motion that it keeps a sound axis along [Hz]."""
SHORTEST_PERIOD, ALIKE = 0.3, 0.9
"""Period that is looked for [s], and correlation from which a torque counts as periodic."""


class NotReproduced(NotComputed):
    """An observer with the inertia and friction of the axis does not reproduce the log."""

    def __init__(self) -> None:
        super().__init__("an observer with the inertia and friction of the axis does not reproduce the log")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """One log as the observer takes it: mean torque to the next sample, angle, first speed, encoder count.

    ``slope``: of a smooth friction [s/rad], 0 where it jumps.
    """

    torque: Array
    position: Array
    start: float
    interval: float
    quantum: float
    slope: float

    def numbers(self, values: Array) -> Array:
        """Values of the axis as the kernels take them, shape (5,)."""
        return np.append(values, self.slope)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Prediction:
    """The observer's run along a track with values of the axis; ``bandwidth`` [rad/s]."""

    track: Track
    values: Array
    bandwidth: float
    innovation: Array
    speed: Array
    acceleration: Array
    direction: Array
    jump: Array

    @property
    def gains(self) -> Array:
        """Of angle and speed, and the interval."""
        return observer_gains(self.bandwidth, self.track.interval)

    @property
    def added(self) -> Array:
        """Torque that the observer adds to follow the angle."""
        return self.values[0] * self.gains[1] / self.track.interval * self.innovation

    def regression(self, torques: Mapping[str, Array], segments: int) -> Factors:
        """Whitened innovations against what each disturbance would add, by segments of time."""
        size, columns = self.innovation.size, np.array(list(torques.values()))
        rows = np.vstack([columns, self.innovation])
        answers(self.track.numbers(self.values), self.gains, columns, self.jump, rows[:-1])
        if not np.all(np.abs(rows) < LOST):
            raise NotReproduced
        forgotten = int(np.ceil(8.0 * self.gains[0] / (self.gains[1] * self.track.interval)))
        edge = min(size // 10, forgotten)
        white = signal.oaconvolve(rows, autoregression(self.innovation[edge:])[None, :], axes=1)
        white = white[:, edge + ORDER : size]
        if white.shape[1] < SHORTEST * segments:
            raise NotComputed(f"{white.shape[1]} samples are too few for {segments} segments: record longer")
        return estimates.factor(white[:-1].T, white[-1], tuple(torques), segments)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Observed:
    """The logs of an axis with the bandwidth of each one's observer."""

    tracks: tuple[Track, ...]
    bandwidths: tuple[float, ...]

    def runs(self, values: Array) -> list[Prediction]:
        """The observers' runs with values of the axis."""
        return [run_of(t, values, w) for t, w in zip(self.tracks, self.bandwidths, strict=True)]

    def factors(
        self,
        values: Array,
        faults: Callable[["Prediction"], dict[str, Array]] | None = None,
        hold: float = 0.0,
    ) -> Factors:
        """Innovations of all logs against what disturbances add; ``hold``: doubt about the torque's mean."""
        parts = []
        for run in self.runs(values):
            most = min(estimates.MOST_SEGMENTS // len(self.tracks), run.track.position.size // SEGMENT)
            lag = np.gradient(run.track.torque, run.track.interval)
            columns = (-run.acceleration, -run.speed, -run.direction, np.ones_like(run.speed), lag)
            torques = dict(zip(NUISANCE, columns, strict=True)) | (faults(run) if faults else {})
            if hold > 0.0:
                torques[HOLD] = hold * np.diff(run.track.torque, 2, prepend=0.0, append=0.0)
            parts.append(run.regression(torques, max(estimates.FEWEST_SEGMENTS, most)))
        return estimates.joined(parts)

    def fit(self, values: Array, lag: bool) -> Fit:
        """Corrections of the parameters, and of the torque's instant where that is free."""
        factors = self.factors(values)
        if not np.all(np.isfinite(factors.triangles)):
            raise NotReproduced
        asked = factors if lag else estimates.only(factors, BASE)
        return estimates.solve(estimates.suited_segments(asked, each=True))

    def twins(self, values: Array, seed: int) -> Iterator["Observed"]:
        """Logs of a rigid axis with friction of the same law that moves beside the measured one."""
        rng = np.random.default_rng(seed)
        cases = [(run.track, *_beside(run.track, values), *_noises(run)) for run in self.runs(values)]
        for k in range(TWINS):
            made = []
            for track, angle, torque, rough, noisy in cases:
                if (q := track.quantum) > 0:
                    seen = q * np.floor(angle / q + k / TWINS)
                else:
                    seen = angle + rough * rng.normal(size=angle.size)
                white = noisy * rng.normal(size=angle.size + 1)
                made.append(replace(track, position=seen, torque=torque + 0.5 * (white[1:] + white[:-1])))
            yield replace(self, tracks=tuple(made))

    def repetition(self, values: Array) -> float:
        r"""Factor of the variances of a log that repeats: :math:`1 + (n - 1)\rho` over its n periods."""
        found = [1.0]
        for run in self.runs(values):
            period = period_of(run.track.torque, run.track.interval)
            if period:
                white = np.convolve(run.innovation, autoregression(run.innovation), "valid")[ORDER:]
                count = white.size / period
                alike = float(white[period:] @ white[:-period]) / float(white @ white) / (1.0 - 1.0 / count)
                found.append(1.0 + (count - 1.0) * max(alike, 0.0))
        return max(found)


def observed(axis: Axis, values: Array, share: float, hold: float = HELD) -> Observed:
    """The logs of an axis, each with an observer at a share of the bandwidth that follows it best."""
    tracks = tuple(
        Track(
            torque=held(log.channel(axis.torque), hold),
            position=log.channel(axis.position),
            start=axis.start(log),
            interval=log.interval,
            quantum=log.report.quantum.get(axis.position, 0.0),
            slope=axis.slope,
        )
        for log in axis.logs
    )
    return Observed(tracks=tracks, bandwidths=tuple(share * best_bandwidth(t, values) for t in tracks))


def twin_axes(axis: Axis, values: Array, seed: int) -> Iterator[Axis]:
    """The axis with logs of a sound one that moves beside it; `NotReproduced` if no observer follows it."""
    for twin in observed(axis, values, SLOWER).twins(values, seed):
        torques = (0.5 * (np.append(t.torque[:1], t.torque[:-1]) + t.torque) for t in twin.tracks)
        yield axis.having(axis.position, (t.position for t in twin.tracks)).having(axis.torque, torques)


def unseen(misses: Sequence[Array], claimed: Sequence[Array]) -> Array:
    """Mean products of misses beyond the covariance that was claimed for them."""
    off = np.array(misses)
    excess = off.T @ off / len(off) - np.mean(claimed, axis=0)
    size = np.sqrt(np.maximum(np.mean(off**2, axis=0), 1e-300))
    level, direction = np.linalg.eigh(excess / size[:, None] / size)
    kept = size[:, None] * direction * np.sqrt(np.maximum(level, 0.0))
    return np.asarray(kept @ kept.T)


def between_samples(values: Array, share: float = CORNER) -> Array:
    r"""Corners of a polygon that runs through the band of a signal without loss.

    One through point samples loses :math:`(\omega T)^2/12` of every sine, through means over the interval
    :math:`(\omega T)^2/24` more, and that again where a command stands from sample to sample.
    """
    moved = values.copy()
    moved[1:-1] -= share * np.diff(values, 2)
    return moved


def held(torque: Array, share: float = HELD) -> Array:
    """Mean torque from each sample to the next."""
    corners = between_samples(torque, share)
    return np.append(0.5 * (corners[1:] + corners[:-1]), corners[-1])


def run_of(track: Track, values: Array, bandwidth: float) -> Prediction:
    """Run the observer."""
    out = np.empty((5, track.position.size))
    start, gains = np.array([track.position[0], track.start]), observer_gains(bandwidth, track.interval)
    observe(track.numbers(values), gains, track.torque, track.position, start, out)
    names = ("innovation", "speed", "acceleration", "direction", "jump")
    return Prediction(track=track, values=values, bandwidth=bandwidth, **dict(zip(names, out, strict=True)))


def observer_gains(bandwidth: float, interval: float) -> Array:
    """Gains of angle and speed for two poles of damping 0.7, and the interval; ``bandwidth`` [rad/s]."""
    return np.array([np.sqrt(2.0) * bandwidth * interval, bandwidth**2 * interval, interval])


def best_bandwidth(track: Track, values: Array) -> float:
    """Bandwidth of the observer whose innovations are smallest [rad/s]."""
    tried = 2 * np.pi * np.geomspace(SLOWEST, min(FASTEST, 0.05 / track.interval), TRIED)
    edge = settling(SLOWEST, track.interval) if track.position.size > 4000 else 0
    sizes = np.array([np.mean(run_of(track, values, w).innovation[edge:] ** 2) for w in tried])
    if not np.isfinite(sizes).any():
        raise NotReproduced
    return float(tried[int(np.nanargmin(sizes))])


def autoregression(values: Array, order: int = ORDER) -> Array:
    """Filter that makes a stationary signal white and of deviation 1, by Yule and Walker."""
    products = np.array([values[k:] @ values[: values.size - k] for k in range(order + 1)]) / values.size
    products[0] *= 1.0 + 1e-9
    weights = np.concatenate([[1.0], -solve_toeplitz(products[:-1], products[1:])])
    return weights / np.sqrt(max(float(weights @ products), 1e-300))


def whitened_power(runs: Sequence[Prediction]) -> float:
    """Power of the innovations that no past foretells."""
    return float(np.mean([autoregression(r.innovation[r.innovation.size // 20 :])[0] ** -2.0 for r in runs]))


def period_of(values: Array, interval: float) -> int:
    """Period of a signal [samples], the shortest of the multiples that are as good; 0 where it has none."""
    centred, size = values - values.mean(), values.size
    power = np.abs(fft.rfft(centred, fft.next_fast_len(2 * size))) ** 2
    products, energy = fft.irfft(power)[:size], np.cumsum(centred**2)
    lags = np.arange(round(SHORTEST_PERIOD / interval), size // 2)
    if lags.size == 0 or energy[-1] == 0.0:
        return 0
    heads, tails = energy[size - 1 - lags], energy[-1] - energy[lags - 1]
    alike = products[lags] / np.sqrt(np.maximum(heads * tails, 1e-300))
    if alike.max() < ALIKE:
        return 0
    first = int(np.flatnonzero(alike > alike.max() - 0.02)[0])
    return int(lags[first + int(np.argmax(alike[first : first + 20]))])


def _beside(track: Track, values: Array) -> tuple[Array, Array]:
    """Angle of a sound axis that a soft servo keeps along the motion, and the torque that acts on it."""
    along = zero_phase(track.position, track.interval, min(SMOOTH, 0.2 / track.interval))
    omega = 2 * np.pi * SERVO
    gains = np.array([values[0] * omega**2, 2 * values[0] * omega, track.interval])
    out, speed = np.empty((2, along.size)), difference(along, track.interval)
    shadow(track.numbers(values), gains, track.torque, along, speed, out)
    return out[0], out[1]


def _noises(run: Prediction) -> tuple[float, float]:
    """Deviations of the noise of angle and torque, from the power that innovations usually have."""
    track, h = run.track, run.track.interval
    parts = np.array_split(run.innovation**2, estimates.MOST_SEGMENTS)
    power = float(np.median([part.mean() for part in parts]))
    # of the innovation for white noise of power 1 in the angle, and in the torque
    forward = np.array([[1.0, h], [0.0, 1.0]])
    corrected = forward @ (np.eye(2) - np.outer(run.gains[:2], [1.0, 0.0]))
    noise = forward @ run.gains[:2], np.array([0.5 * h**2, h]) / run.values[0]
    angle, by_torque = (float(solve_discrete_lyapunov(corrected, np.outer(b, b))[0, 0]) for b in noise)
    by_angle = 1.0 + angle
    rough = track.quantum**2 / 12.0 if track.quantum > 0.0 else 0.5 * power / by_angle
    return float(np.sqrt(rough)), float(np.sqrt(max(power - by_angle * rough, 0.0) / by_torque))
