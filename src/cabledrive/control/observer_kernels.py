r"""Compiled steps of observers, the covariance recursion, and what a torque at the load makes of a filter.

The filter does not know of the torque. Its error is linear in it and depends neither on the law nor on the
plant's motion, so that both are known along a reference beforehand; B. Friedland, IEEE Trans. Automatic
Control 14, 359-367, 1969, separates the estimation of a bias in this way.

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

from math import isfinite, tanh
from typing import NamedTuple

import numpy as np

from cabledrive.control.numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit, njit_in_place, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, held, state_space


@njit_part
def correct(
    observer: ObserverNumbers, place: float, estimate: Array, readings: Array, states: Array, scratch: Array
) -> None:
    """Take in the readings of a sample; writes angles and speeds for the law into ``states``.

    ``place``: in the table of gains, of which the last one stays: number of the sample, or place of the
    announced load among the points of a schedule. A reading that is not a number leaves the law without
    states: they become NaN. ``estimate`` is kept.
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

    ``place``: of an announced load among the points of a schedule; ``held[0]`` is the torque at the motor's
    shaft as the current loop leaves it; it is carried along.
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


SETTLED = 1e-7
"""Change of the gains in a hundred samples, over the largest, at which the recursion ends."""


@njit
def _product(one: Array, other: Array, into: Array) -> None:
    for i in range(one.shape[0]):
        for j in range(other.shape[1]):
            total = 0.0
            for k in range(other.shape[0]):
                total += one[i, k] * other[k, j]
            into[i, j] = total


@njit
def _product_of_transposed(one: Array, other: Array, into: Array) -> None:
    """One times the transposed other."""
    for i in range(one.shape[0]):
        for j in range(other.shape[0]):
            total = 0.0
            for k in range(other.shape[1]):
                total += one[i, k] * other[j, k]
            into[i, j] = total


@njit
def _solve_positive(matrix: Array, sides: Array) -> None:
    """Solve by elimination; a covariance needs no pivot. ``sides``, shape (m, n), becomes the answer."""
    m, n = sides.shape
    for i in range(m):
        for row in range(i + 1, m):
            factor = matrix[row, i] / matrix[i, i]
            for j in range(i, m):
                matrix[row, j] -= factor * matrix[i, j]
            for j in range(n):
                sides[row, j] -= factor * sides[i, j]
    for i in range(m - 1, -1, -1):
        for j in range(n):
            for row in range(i + 1, m):
                sides[i, j] -= matrix[i, row] * sides[row, j]
            sides[i, j] /= matrix[i, i]


@njit
def gain_schedule(
    transition: Array, noise: Array, output: Array, reading: Array, start: Array, gains: Array
) -> int:
    """Covariance recursion in Joseph's form; writes each sample's gain, returns the number of the last.

    Products by `_product`: those of numba's own call a library and take five times as long to compile.
    """
    n, m = output.shape[1], output.shape[0]
    covariance, seen, spread, gain = start.copy(), np.zeros((m, n)), np.zeros((m, m)), np.zeros((m, n))
    kept, part, other = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for k in range(gains.shape[0]):
        _product(output, covariance, seen)
        for i in range(m):
            for j in range(m):
                spread[i, j] = reading[i, j]
                for a in range(n):
                    spread[i, j] += seen[i, a] * output[j, a]
            for a in range(n):
                gain[i, a] = seen[i, a]
        _solve_positive(spread, gain)
        largest, change = 0.0, 0.0
        for a in range(n):
            for i in range(m):
                gains[k, a, i] = gain[i, a]
                largest = max(largest, abs(gain[i, a]))
                if k > 100:
                    change = max(change, abs(gain[i, a] - gains[k - 100, a, i]))
            for b in range(n):
                kept[a, b] = 1.0 if a == b else 0.0
                for i in range(m):
                    kept[a, b] -= gain[i, a] * output[i, b]
        _product(kept, covariance, part)
        _product_of_transposed(part, kept, other)
        for a in range(n):
            for b in range(n):
                for i in range(m):
                    for j in range(m):
                        other[a, b] += gain[i, a] * reading[i, j] * gain[j, b]
        _product(transition, other, part)
        _product_of_transposed(part, transition, covariance)
        for a in range(n):
            for b in range(n):
                covariance[a, b] += noise[a, b]
        if k > 100 and change <= SETTLED * largest:
            return k
    return gains.shape[0] - 1


def missed_by_filter(
    observer: ObserverNumbers, chain: LumpedChain, torque: Array, interval: float
) -> tuple[Array, Array]:
    """States, true less estimated, (samples, 2n), and innovations, (samples, m), by a torque at the load."""
    states = observer.model.shape[0]
    push = torque_push(chain, states, interval)
    mean = 0.5 * (torque + np.append(torque[1:], torque[-1]))
    missed, innovations = np.zeros((len(torque), states)), np.zeros((len(torque), len(observer.output)))
    transition = np.column_stack((observer.model[:, :states], push))
    filter_error(transition, observer.output, observer.gains, mean, missed, innovations)
    return missed[:, observer.chosen], innovations


def torque_push(chain: LumpedChain, states: int, interval: float) -> Array:
    """What a unit of torque against the load does in a sample to a filter's states, shape (states,)."""
    a, b = state_space(chain)
    push = np.zeros(states)
    push[: len(a)] = held(a, -b[:, -1], interval)[1]
    return push


@njit
def filter_error(
    transition: Array, output: Array, gains: Array, torque: Array, missed: Array, seen: Array
) -> None:
    """Recursion of the filter's error under a torque; writes errors after the readings, and innovations."""
    states = transition.shape[0]
    model, push, error = np.ascontiguousarray(transition[:, :states]), transition[:, states], np.zeros(states)
    for k in range(torque.size):
        seen[k] = output @ error
        error = error - gains[min(k, gains.shape[0] - 1)] @ seen[k]
        missed[k] = error
        error = model @ error + push * torque[k]


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
def closing_torques(stiffness: float, play: float, twist: float, pressed: float, found: Array) -> None:
    """Write the torques of both flanks in the sense of the preload [N m]; below zero a gap is crossed."""
    for i in range(2):
        closed = pressed + twist if i == 0 else pressed - twist
        found[i] = stiffness * (max(closed, 0.0) + min(closed + 2.0 * play, 0.0))


@njit_in_place
def preload_step(
    law: FlankLaw, memory: Array, reading: float, twist: float, total: float, work: Array, flanks: Array
) -> float:
    """One sample: the torque of the difference, which motor a gets on top of half the total and b less.

    ``memory``: moved on; ``reading``: ϑ by the encoders [rad], not a number: not read; ``twist``: e as the
    filter of the position has it [rad]; ``total``: torque of both motors together [N m]; ``work``, shape
    (>= 6,); ``flanks``, shape (2,): takes the torques observed.
    """
    observer, estimate = law.observer, memory[ESTIMATE:LAG]
    if isfinite(reading):
        work[0] = reading
        correct(observer, 0.0, estimate, work[:1], work[1:3], work[3:4])
    estimate[2] = min(max(estimate[2], -law.coulomb), law.coulomb)
    closing_torques(law.stiffness, law.play, twist, estimate[0], flanks)
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
    # The model of the observer has both flanks closed; where one is open it is told what is missing.
    missing = 0.5 * (flanks[0] + flanks[1]) - law.stiffness * estimate[0]
    predict(observer, 0.0, estimate, memory[HELD:COMMANDS], memory[COMMANDS:], work)
    for i in range(2):
        estimate[i] -= observer.model[i, 6] * missing
    return command
