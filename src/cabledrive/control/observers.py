"""Observers of a lumped chain: the Kalman filter, and speeds by a filtered difference.

States are angles, speeds, a torque on the motor that walks at random, and the offset of each encoder but the
last, which walks very slowly. Friction and offset torque of the motor are taken off its torque as known.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import exp, pi

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from cabledrive.control.numbers import DIFFERENCE, IDEAL, KALMAN, ObserverNumbers
from cabledrive.control.observer_kernels import gain_schedule
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, held, state_space

LONGEST_SCHEDULE = 20_000


@dataclass(frozen=True, slots=True, kw_only=True)
class KalmanTuning:
    """Noise of the filter, as spectral densities."""

    torque: float = 1e-6  # of the motor's torque [(N m)^2 s]
    disturbance: float = 1e-2  # of the rate of the disturbance [(N m)^2 / s]
    load_acceleration: float = 0.0  # at the last inertia [(rad/s^2)^2 s]
    offsets: tuple[float, ...] = (1e-6, 1e-7)
    """Of the rate of each offset, from the motor's encoder on; the last encoder has none [rad^2/s]. None at
    all where empty."""
    cancels: bool = False  # whether the law subtracts the estimated disturbance
    friction_slope: float = 20.0  # K of c tanh(K w) in the friction taken off the torque [s/rad]


QUIET = KalmanTuning()


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """When the filter sees what."""

    interval: float  # sample time [s]
    delay: float = 0.0  # from sampling to torque [s]
    current_rate: float = 0.0  # bandwidth of the torque loop [rad/s]; 0: none, torque is the command


def kalman_filter(
    chain: LumpedChain,
    encoders: Sequence[int],
    counts: Sequence[float],
    sampling: Sampling,
    *,
    chosen: Sequence[int],
    tuning: KalmanTuning = QUIET,
    settled: bool = False,
) -> ObserverNumbers:
    """Design the filter; refused where the encoders there are do not make the drive observable.

    ``chain``: links between equal angles; ``encoders``: inertia that each reads; the last one is the datum of
    all angles; ``chosen``: inertias of which the law takes angle and speed; ``settled``: only the gain on
    which the recursion settles, for a filter that goes on from another's states.
    """
    if not encoders:
        raise InputRefused("encoders: 0 given, the filter needs at least 1: fit the load encoder")
    n, walks = chain.size, np.array(tuning.offsets, dtype=float)[: len(encoders) - 1]
    size, (a, b) = 2 * n + 1 + len(walks), state_space(chain)
    column = np.zeros(size)  # of a torque on the motor, to the rates of angles, speeds, disturbance, offsets
    column[: 2 * n] = b[:, 0]
    system = np.zeros((size, size))
    system[: 2 * n, : 2 * n], system[:, 2 * n] = a, column
    transition, inputs, shaft = _sampled(system, column, sampling)
    density = np.zeros(size)
    density[n] = tuning.torque / chain.inertias[0] ** 2
    density[2 * n - 1] += tuning.load_acceleration
    density[2 * n] = tuning.disturbance
    density[2 * n + 1 :] = walks
    noise = gathered_noise(system, density, sampling.interval)
    output = np.zeros((len(encoders), size))
    for j, inertia in enumerate(encoders):
        output[j, inertia] = 1.0
        if j < len(walks):
            output[j, 2 * n + 1 + j] = 1.0
    variance = np.array(counts, dtype=float) ** 2 / 12.0
    if settled:
        gains = settled_gain(transition, noise, output, np.diag(variance))
    else:  # from rest: angles within the last encoder's count, offsets within both counts
        diagonal = np.zeros(size)
        diagonal[2 * n] = (chain.coulomb[0] + abs(chain.offsets[0])) ** 2 + 1e-12
        diagonal[2 * n + 1 :] = variance[: len(walks)] + variance[-1]
        start = np.diag(diagonal)
        start[:n, :n] = variance[-1]
        # One layout, one compiled version: matrix exponentials come in either order of rows and columns.
        parts = [np.ascontiguousarray(p) for p in (transition, noise, output, np.diag(variance), start)]
        gains = _recursion(output.shape, *(part.tobytes() for part in parts)).copy()
        if not np.all(np.isfinite(gains)):
            raise InputRefused(f"{len(encoders)} encoders do not show the whole drive: fit the load encoder")
    friction = chain.coulomb[0], tuning.friction_slope, chain.offsets[0]
    return ObserverNumbers(
        kind=KALMAN,
        chosen=np.array([*chosen, *(n + i for i in chosen)], dtype=np.int64),
        places=np.array([n, 2 * n], dtype=np.int64),
        model=np.ascontiguousarray(np.hstack((transition, inputs))),
        output=output,
        gains=np.ascontiguousarray(gains),
        scalars=np.array([sampling.interval, 0.0, *shaft, *friction, tuning.cancels]),
    )


def _sampled(system: Array, column: Array, sampling: Sampling) -> tuple[Array, Array, Array]:
    """Transition, inputs by torque, older and newer command, load, and the current loop's factors."""
    n, w = system.shape[0], sampling.current_rate
    late = sampling.delay % sampling.interval
    full = np.zeros((n + 2, n + 2))  # states, shaft torque, command
    full[:n, :n], full[:n, n] = system, column
    if w > 0.0:
        full[n, n], full[n, n + 1] = -w, w
    else:
        full[:n, n], full[:n, n + 1] = 0.0, column
    first, second = expm(full * late), expm(full * (sampling.interval - late))
    for step in (first, second):
        if w == 0.0:
            step[n, :] = 0.0
            step[n, n + 1] = 1.0
    older, newer = np.zeros(n + 2), np.zeros(n + 2)
    older[n + 1] = newer[n + 1] = 1.0
    by_before = second[:, : n + 1] @ (first @ older)[: n + 1] if late > 0.0 else np.zeros(n + 2)
    by_after = second @ newer
    initial = np.zeros(n + 2)
    initial[n] = 1.0
    by_torque = second[:, : n + 1] @ (first @ initial if late > 0.0 else initial)[: n + 1]
    by_load = held(system, column, sampling.interval)[1]
    inputs = np.column_stack((by_torque[:n], by_before[:n], by_after[:n], by_load))
    return expm(system * sampling.interval), inputs, np.array([by_torque[n], by_before[n], by_after[n]])


def gathered_noise(system: Array, density: Array, interval: float) -> Array:
    """Covariance gathered over one sample from densities of the rates, by Van Loan's block exponential."""
    size = system.shape[0]
    block = np.zeros((2 * size, 2 * size))
    block[:size, :size], block[:size, size:], block[size:, size:] = -system, np.diag(density), system.T
    power = expm(block * interval)
    noise = power[size:, size:].T @ power[:size, size:]
    return 0.5 * (noise + noise.T)


@lru_cache(maxsize=16)
def _recursion(shape: tuple[int, int], *parts: bytes) -> Array:
    """Gain of each sample, (samples, n, m), kept; from the output's shape and its matrices in binary."""
    m, n = shape
    shapes = ((n, n), (n, n), (m, n), (m, m), (n, n))
    transition, noise, output, reading, start = (
        np.frombuffer(part).reshape(of).copy() for part, of in zip(parts, shapes, strict=True)
    )
    gains = np.zeros((LONGEST_SCHEDULE, n, m))
    used = gain_schedule(transition, noise, output, reading, start, gains)
    return gains[: used + 1].copy()


def settled_gain(transition: Array, noise: Array, output: Array, reading: Array) -> Array:
    """Gain of the stationary filter, (1, states, m), by the algebraic Riccati equation."""
    covariance = solve_discrete_are(transition.T, output.T, noise, reading)
    spread = output @ covariance @ output.T + reading
    return np.asarray(np.linalg.solve(spread, output @ covariance).T[None])


def filtered_difference(
    encoders: Sequence[int], interval: float, *, chosen: Sequence[int], cut_off: float = 200.0
) -> ObserverNumbers:
    r"""Speeds by differences of successive readings through a first-order filter.

    .. math::
        \hat\omega_k = \hat\omega_{k-1} + (1 - e^{-2\pi f h})\,\big((y_k - y_{k-1})/h - \hat\omega_{k-1}\big)

    ``encoders``: inertia that each reads, all of the ``chosen`` ones; ``cut_off``: f [Hz].
    """
    places = list(encoders)
    missing = [inertia for inertia in chosen if inertia not in places]
    if missing:
        raise InputRefused(f"inertia {missing[0] + 1} of the chain has no encoder: take the Kalman filter")
    numbers = [places.index(inertia) for inertia in chosen]
    m = len(places)
    share = 1.0 - exp(-2.0 * pi * cut_off * interval)
    return _plain(DIFFERENCE, interval, [*numbers, *(m + i for i in numbers)], share)


def ideal_states(n: int, interval: float, *, chosen: Sequence[int]) -> ObserverNumbers:
    """No observer: the law sees the true angles and speeds of ``chosen`` ones of n inertias."""
    return _plain(IDEAL, interval, [*chosen, *(n + i for i in chosen)])


def _plain(kind: int, interval: float, chosen: Sequence[int], share: float = 1.0) -> ObserverNumbers:
    square = np.zeros((0, 0))
    return ObserverNumbers(
        kind=kind,
        chosen=np.array(chosen, dtype=np.int64),
        places=np.zeros(2, dtype=np.int64),
        model=square,
        output=square,
        gains=np.zeros((0, 0, 0)),
        scalars=np.array([interval, share, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
    )
