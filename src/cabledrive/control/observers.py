r"""Observers of a chain, the Kalman filter and speeds by a filtered difference, and of a pair's flanks.

States are angles, speeds, a torque on the motor that walks at random, and the offset of each encoder but the
last, which walks very slowly. Friction and offset torque of the motor are taken off its torque as known.

A filter does not know of a torque at the load. Its error is linear in it and depends neither on the law nor
on the plant's motion, so that both are known along a reference beforehand; B. Friedland, IEEE Trans.
Automatic Control 14, 359-367, 1969, separates the estimation of a bias in this way.

Preload of two motors on one shaft against the backlash of their gears, and the observer of their flanks.

Motor a presses on one flank of its gear, motor b on the opposite flank of its own. With
:math:`\theta_m, \theta_d` half the sum and half the difference of their angles, half the backlash g, the
stiffness k of each joint and the twist :math:`e = \theta_m - \theta_p` against the shaft,

.. math:: \tau_a = k\,[e + \vartheta]_+, \qquad \tau_b = -k\,[\vartheta - e]_+, \qquad
    \vartheta = \theta_d - g ,

as long as neither has crossed its gap. With both closed the sum is a motor of twice the size without
backlash, :math:`\tau_a + \tau_b = 2ke`, and the difference an oscillator of its own, which no motion of the
shaft enters:

.. math:: J\ddot\vartheta + (b + b_m)\dot\vartheta + k\vartheta = u_d + w, \qquad |w| \le c .

So any law of position takes the sum, and the difference keeps the flanks closed: where
:math:`k\vartheta > |ke|`, half the torque of the joint.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, exp, isfinite, log2, pi, sqrt, tanh
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm, solve_discrete_are
from scipy.linalg.lapack import dposv

from cabledrive.control.numbers import KALMAN, ObserverNumbers
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, held, state_space

LONGEST_SCHEDULE, CUT_OFF = 20_000, 200.0  # samples, Hz
SETTLED = 1e-7
"""Change of the gains in a hundred samples, over the largest, at which the recursion ends."""
ROUND_OFF = 1e-7
"""Residual of a Riccati equation over its largest term, above which its solution is none."""
ALIKE = 1e-9  # samples by which times differ that round-off alone parts


@dataclass(frozen=True, slots=True, kw_only=True)
class KalmanTuning:
    """Noise of the filter, as spectral densities."""

    torque: float = 1e-6  # of the motor's torque [(N m)^2 s]
    disturbance: float = 1e-2  # of the rate of the disturbance [(N m)^2 / s]
    load_acceleration: float = 0.0  # at the last inertia [(rad/s^2)^2 s]
    offsets: tuple[float, ...] = (1e-6, 1e-7)
    """Of the rate of each offset from the motor's encoder on [rad^2/s]; the last has none, none if empty."""
    cancels: bool = False  # whether the law subtracts the estimated disturbance
    friction_slope: float = 20.0  # K of c tanh(K w) in the friction taken off the torque, at most [s/rad]


QUIET = KalmanTuning()


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """When the filter sees what."""

    interval: float  # sample time [s]
    delay: float = 0.0  # from sampling to torque [s]
    current_rate: float = 0.0  # bandwidth of the torque loop [rad/s]; 0: none, torque is the command

    @property
    def late(self) -> tuple[int, float]:
        """Whole samples of the delay, and the rest [s]: 1 ms of 0.2 ms are 5 and none, by its digits 4."""
        whole = int(self.delay / self.interval + ALIKE)
        rest = self.delay - whole * self.interval
        return whole, rest if rest > ALIKE * self.interval else 0.0


def kalman_filter(
    chain: LumpedChain,
    encoders: Sequence[tuple[int, float]],
    sampling: Sampling,
    *,
    chosen: Sequence[int],
    tuning: KalmanTuning = QUIET,
    settled: bool = False,
) -> ObserverNumbers:
    """Design the filter; refused where the encoders there are do not make the drive observable.

    ``encoders``: inertia that each reads, and its count [rad]; the last is the datum of all angles;
    ``chosen``: inertias of which the law takes angle and speed; ``settled``: only the gain on which the
    recursion settles, for a filter that goes on from another's states.
    """
    if not encoders:
        raise InputRefused("encoders: 0 given, the filter needs at least 1: fit the load encoder")
    n, walks = chain.size, np.array(tuning.offsets, dtype=float)[: len(encoders) - 1]
    size, (a, b) = 2 * n + 1 + len(walks), state_space(chain)
    column = np.zeros(size)  # of a torque on the motor, to the rates of angles, speeds, disturbance, offsets
    column[: 2 * n] = b[:, 0]
    system = np.zeros((size, size))
    system[: 2 * n, : 2 * n], system[:, 2 * n] = a, column
    transition, inputs, shaft = between_samples(system, column, sampling)
    density = np.zeros(size)
    density[n] = tuning.torque / chain.inertias[0] ** 2
    density[2 * n - 1] += tuning.load_acceleration
    density[2 * n] = tuning.disturbance
    density[2 * n + 1 :] = walks
    noise = gathered_noise(system, density, sampling.interval)
    output = np.zeros((len(encoders), size))
    for j, (inertia, _) in enumerate(encoders):
        output[j, inertia] = 1.0
        if j < len(walks):
            output[j, 2 * n + 1 + j] = 1.0
    variance = np.array([count for _, count in encoders]) ** 2 / 12.0
    if settled:
        gains = settled_gain(transition, noise, output, np.diag(variance))
    else:  # from rest: angles within the last encoder's count, offsets within both counts
        diagonal = np.zeros(size)
        diagonal[2 * n] = (chain.coulomb[0] + abs(chain.offsets[0])) ** 2
        diagonal[2 * n + 1 :] = variance[: len(walks)] + variance[-1]
        start = np.diag(diagonal)
        start[:n, :n] = variance[-1]
        parts = (transition, noise, output, np.diag(variance), start)
        gains = _recursion(output.shape, *(part.tobytes() for part in parts)).copy()
        if not np.all(np.isfinite(gains)):
            raise InputRefused(f"{len(encoders)} encoders do not show the whole drive: fit the load encoder")
    # no steeper than what takes a speed away within a sample: friction would reverse it each time
    slope = min(tuning.friction_slope, 1.0 / max(chain.coulomb[0] * abs(inputs[n, 3]), 1e-300))
    friction = chain.coulomb[0], slope, chain.offsets[0]
    return ObserverNumbers(
        kind=KALMAN,
        chosen=np.array([*chosen, *(n + i for i in chosen)], dtype=np.int64),
        places=np.array([n, 2 * n], dtype=np.int64),
        model=np.ascontiguousarray(np.hstack((transition, inputs))),
        output=output,
        gains=np.ascontiguousarray(gains),
        scalars=np.array([sampling.interval, 0.0, *shaft, *friction, tuning.cancels]),
    )


def between_samples(system: Array, column: Array, sampling: Sampling) -> tuple[Array, Array, Array]:
    """Transition, inputs by torque, older and newer command, load, and the current loop's factors."""
    n, w, late = system.shape[0], sampling.current_rate, sampling.late[1]
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
    """Covariance gathered over a sample from densities of the rates, by Van Loan's exponential of a part."""
    size, fastest = system.shape[0], np.abs(np.linalg.eigvals(system)).max(initial=0.0)
    doublings = ceil(log2(max(1.0, fastest * interval)))
    block = np.zeros((2 * size, 2 * size))
    block[:size, :size], block[:size, size:], block[size:, size:] = -system, np.diag(density), system.T
    power = expm(block * (interval / 2**doublings))
    step = power[size:, size:].T
    noise = step @ power[:size, size:]
    for _ in range(doublings):
        noise, step = noise + step @ noise @ step.T, step @ step
    return 0.5 * (noise + noise.T)


@lru_cache(maxsize=16)
def _recursion(shape: tuple[int, int], *parts: bytes) -> Array:
    """Gain of each sample, (samples, n, m), kept; from the output's shape and its matrices in binary."""
    m, n = shape
    shapes = ((n, n), (n, n), (m, n), (m, m), (n, n))
    return gain_schedule(*(np.frombuffer(part).reshape(of) for part, of in zip(parts, shapes, strict=True)))


def gain_schedule(transition: Array, noise: Array, output: Array, reading: Array, start: Array) -> Array:
    """Gain of each sample until it has settled, (samples, n, m), by the covariance in Joseph's form."""
    covariance, gains = start, np.zeros((LONGEST_SCHEDULE, *output.T.shape))
    for k in range(LONGEST_SCHEDULE):
        seen = output @ covariance
        _, solved, failed = dposv(seen @ output.T + reading, seen)
        if failed:
            raise NotComputed("the gains of the filter: errors of the readings are not positive definite")
        gain = gains[k] = solved.T
        carried = transition @ gain
        kept = transition - carried @ output
        covariance = kept @ covariance @ kept.T + carried @ reading @ carried.T + noise
        if k > 100 and k % 10 == 0:  # in deviations of readings and states, of which each has another unit
            size = np.sqrt(np.diag(reading) / np.maximum(np.diag(covariance), 1e-300)[:, None])
            if (size * np.abs(gain - gains[k - 100])).max() <= SETTLED * (size * np.abs(gain)).max():
                return gains[: k + 1].copy()
    return gains


def settled_gain(transition: Array, noise: Array, output: Array, reading: Array) -> Array:
    """Gain of the stationary filter, (1, states, m), by the algebraic Riccati equation."""
    covariance = riccati(transition.T, output.T, noise, reading)
    spread = output @ covariance @ output.T + reading
    return np.asarray(np.linalg.solve(spread, output @ covariance).T[None])


def riccati(a: Array, b: Array, weight: Array, cost: Array) -> Array:
    """Least sum of x' weight x + u' cost u as x' X x, X of (states, states), or `NotComputed`.

    In units in which ``cost`` and the largest weight are 1, else the first alone: in others round-off leaves
    no solution, or a wrong one.
    """
    one = np.eye(b.shape[1])
    for size in (float(np.abs(weight).max()), 1.0):
        inputs = sqrt(size) * np.linalg.solve(np.linalg.cholesky(cost), b.T).T
        try:
            x = np.asarray(solve_discrete_are(a, inputs, weight / size, one))
            left = a.T @ x @ (a - inputs @ np.linalg.solve(one + inputs.T @ x @ inputs, inputs.T @ x @ a))
        except (np.linalg.LinAlgError, ValueError):
            continue
        if np.abs(left + weight / size - x).max() < ROUND_OFF * np.abs(x).max():
            return size * x
    raise NotComputed("round-off leaves the Riccati equation no solution: take another model or law")


def plain_observer(kind: int, count: int, interval: float, chosen: Sequence[int]) -> ObserverNumbers:
    """Some ``chosen`` of a ``count`` of true angles and speeds, or speeds by differences of readings.

    These differences go through a first-order filter at `CUT_OFF`.
    """
    square, share = np.zeros((0, 0)), 1.0 - exp(-2.0 * pi * CUT_OFF * interval)
    return ObserverNumbers(
        kind=kind,
        chosen=np.array([*chosen, *(count + i for i in chosen)], dtype=np.int64),
        places=np.zeros(2, dtype=np.int64),
        model=square,
        output=square,
        gains=np.zeros((0, 0, 0)),
        scalars=np.array([interval, share, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
    )


@njit_part
def correct(
    observer: ObserverNumbers, place: float, estimate: Array, readings: Array, states: Array, scratch: Array
) -> None:
    """Take in the readings of a sample; writes angles and speeds for the law into ``states``.

    These are NaN where a reading is none. ``place``: in the table of gains, of which the last one stays:
    number of the sample, or place of the announced load among the points of a schedule.
    """
    chosen, output, gains, scalars = observer.chosen, observer.output, observer.gains, observer.scalars
    m = readings.size
    for j in range(m):
        if not isfinite(readings[j]):
            for i in range(states.size):
                states[i] = readings[j]
            return
    if observer.kind == 1:
        for j in range(m):
            if place > 0.0:
                slope = (readings[j] - estimate[j]) / scalars[0]
                estimate[m + j] += scalars[1] * (slope - estimate[m + j])
            estimate[j] = readings[j]
    else:
        cell = min(int(place), gains.shape[0] - 1)
        after, share = min(cell + 1, gains.shape[0] - 1), place - cell
        for j in range(m):
            predicted = 0.0
            for i in range(estimate.size):
                predicted += output[j, i] * estimate[i]
            scratch[j] = readings[j] - predicted
        for i in range(estimate.size):
            for j in range(m):
                gain = gains[cell, i, j]
                if observer.kind == 3:
                    gain = (1.0 - share) * gain + share * gains[after, i, j]
                estimate[i] += gain * scratch[j]
    for i in range(states.size):
        states[i] = estimate[chosen[i]]


@njit_part
def predict(
    observer: ObserverNumbers, place: float, estimate: Array, held: Array, commands: Array, fresh: Array
) -> None:
    """Carry the Kalman filter to the next sample: until the delay has passed the first of two commands acts.

    ``place`` as of `correct`; ``held[0]``: torque at the motor's shaft, which is carried along.
    """
    model, scalars, n = observer.model, observer.scalars, estimate.size
    torque, before, after = held[0], commands[0], commands[1]
    load = scalars[7] - scalars[5] * tanh(scalars[6] * estimate[observer.places[0]])
    cell = int(place)
    share = place - cell
    for i in range(n):
        value = 0.0
        for part in range(2 if share > 0.0 else 1):
            row = (cell + part) * n + i
            one = model[row, n] * torque + model[row, n + 1] * before
            one += model[row, n + 2] * after + model[row, n + 3] * load
            for j in range(n):
                one += model[row, j] * estimate[j]
            value += one * (share if part == 1 else 1.0 - share)
        fresh[i] = value
    for i in range(n):
        estimate[i] = fresh[i]
    held[0] = scalars[2] * torque + scalars[3] * before + scalars[4] * after


def torque_push(chain: LumpedChain, states: int, interval: float) -> Array:
    """What a unit of torque against the load does in a sample to a filter's states, shape (states,)."""
    a, b = state_space(chain)
    push = np.zeros(states)
    push[: len(a)] = held(a, -b[:, -1], interval)[1]
    return push


def whitening(observer: ObserverNumbers, counts: Array) -> Array:
    """Matrix, (m, m), that makes the settled filter's innovations white and of variance 1."""
    left = np.eye(len(counts)) - observer.output @ observer.gains[-1]
    spread = np.linalg.solve(left, np.diag(counts**2 / 12.0))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(0.5 * (spread + spread.T))))


ESTIMATE, LAG, HELD, COMMANDS = 0, 3, 5, 7
"""Places of the memory: observer (3), lags of the preload (2), torque loop (2), commands on their way."""


class FlankLaw(NamedTuple):
    """Observer of the difference and numbers of the law."""

    observer: ObserverNumbers  # of twist, speed and disturbing torque of the difference
    stiffness: float  # k of one joint [N m/rad]
    play: float  # g, half the backlash [rad]
    limit: float  # of one motor [N m]
    preload: float  # least torque of a flank where nothing else is asked of it [N m]
    margin: float  # by which the preload exceeds half the joint's torque [N m]
    remaining: float  # part of each lag of the preload that remains after a sample
    damper: float  # torque per speed of the difference [N m s/rad]
    coulomb: float  # largest disturbing torque that is believed [N m]


def first_memory(law: FlankLaw, late_samples: int) -> Array:
    """Memory at rest with the preload on; ``late_samples``: whole samples of the delay."""
    memory = np.full(COMMANDS + late_samples + 2, law.preload)
    memory[ESTIMATE:LAG] = law.preload / law.stiffness, 0.0, 0.0
    return memory


@njit_in_place
def preload_step(
    law: FlankLaw, memory: Array, seen: tuple[float, float, float], work: Array, flanks: Array
) -> float:
    """One sample: the torque of the difference, which motor a gets on top of half the total and b less.

    ``seen``: ϑ by the encoders [rad], NaN: not read; e by the position's filter [rad]; torque of both motors
    [N m]. ``work``, (>= 6,); ``flanks``, (2,): takes the torques observed.
    """
    observer, estimate, (reading, twist, total) = law.observer, memory[ESTIMATE:LAG], seen
    if isfinite(reading):
        work[0] = reading
        correct(observer, 0.0, estimate, work[:1], work[1:3], work[3:4])
    estimate[2] = min(max(estimate[2], -law.coulomb), law.coulomb)
    for i in range(2):  # in the sense of the preload; below zero a gap is crossed
        closed = estimate[0] + twist if i == 0 else estimate[0] - twist
        flanks[i] = law.stiffness * (max(closed, 0.0) + min(closed + 2.0 * law.play, 0.0))
    # What one motor can give beside the position's half is left for the preload: the position goes first.
    room = max(law.limit - 0.5 * abs(total), 0.0)
    wanted = min(max(law.preload, law.stiffness * abs(twist) + law.margin), room)
    for i in range(2):
        memory[LAG + i] = wanted + law.remaining * (memory[LAG + i] - wanted)
        wanted = memory[LAG + i]
    asked = wanted - estimate[2] - law.damper * estimate[1]
    command = min(max(asked, -room), room)
    last = memory.size - 1
    for i in range(COMMANDS, last):
        memory[i] = memory[i + 1]
    memory[last] = command
    # The model of the observer has both flanks closed; where one is open it gets what is missing.
    missing = 0.5 * (flanks[0] + flanks[1]) - law.stiffness * estimate[0]
    predict(observer, 0.0, estimate, memory[HELD:COMMANDS], memory[COMMANDS:], work)
    for i in range(2):
        estimate[i] -= observer.model[i, 6] * missing
    return command
