"""Compiled steps of observers, the covariance recursion, and what a torque at the load makes of a filter.

The filter does not know of the torque. Its error is linear in it and depends neither on the law nor on the
plant's motion, so that both are known along a reference beforehand; B. Friedland, IEEE Trans. Automatic
Control 14, 359-367, 1969, separates the estimation of a bias in this way.
"""

from math import isfinite, tanh

import numpy as np
from scipy.linalg import expm

from cabledrive.control.numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, state_space


@njit_part
def correct(
    observer: ObserverNumbers, sample: int, estimate: Array, readings: Array, states: Array, scratch: Array
) -> None:
    """Take in the readings of a sample; writes angles and speeds for the law into ``states``.

    A reading that is not a number leaves the law without states: they become NaN. ``estimate`` is kept.
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
            if sample > 0:
                slope = (readings[j] - estimate[j]) / scalars[0]
                estimate[m + j] += scalars[1] * (slope - estimate[m + j])
            estimate[j] = readings[j]
    else:
        k = min(sample, gains.shape[0] - 1)
        for j in range(m):
            predicted = 0.0
            for i in range(estimate.size):
                predicted += output[j, i] * estimate[i]
            scratch[j] = readings[j] - predicted
        for i in range(estimate.size):
            for j in range(m):
                estimate[i] += gains[k, i, j] * scratch[j]
    for i in range(states.size):
        states[i] = estimate[chosen[i]]


@njit_part
def predict(
    observer: ObserverNumbers, estimate: Array, held: Array, before: float, after: float, fresh: Array
) -> None:
    """Carry the Kalman filter to the next sample: until the delay has passed ``before`` acts, then ``after``.

    ``held[0]`` is the torque at the motor's shaft as the current loop leaves it; it is carried along.
    """
    model, scalars, n = observer.model, observer.scalars, estimate.size
    torque = held[0]
    load = scalars[7] - scalars[5] * tanh(scalars[6] * estimate[observer.places[0]])
    for i in range(n):
        value = model[i, n] * torque + model[i, n + 1] * before
        value += model[i, n + 2] * after + model[i, n + 3] * load
        for j in range(n):
            value += model[i, j] * estimate[j]
        fresh[i] = value
    for i in range(n):
        estimate[i] = fresh[i]
    held[0] = scalars[2] * torque + scalars[3] * before + scalars[4] * after


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
    transition: Array,
    noise: Array,
    output: Array,
    reading: Array,
    start: Array,
    gains: Array,
    settled: float,
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
        if k > 100 and change <= settled * largest:
            return k
    return gains.shape[0] - 1


def missed_by_filter(
    observer: ObserverNumbers, chain: LumpedChain, torque: Array, interval: float
) -> tuple[Array, Array]:
    """States, true less estimated, (samples, 2n), that a Kalman filter misses, and innovations, (samples, m).

    A torque [N m] of some samples acts against the load of ``chain``, which is the filter's.
    """
    states = observer.model.shape[0]
    push = torque_push(chain, states, interval)
    mean = 0.5 * (torque + np.append(torque[1:], torque[-1]))
    missed, innovations = np.zeros((len(torque), states)), np.zeros((len(torque), len(observer.output)))
    transition = np.ascontiguousarray(observer.model[:, :states])
    filter_error(transition, observer.output, observer.gains, push, mean, missed, innovations)
    return missed[:, observer.chosen], innovations


def torque_push(chain: LumpedChain, states: int, interval: float) -> Array:
    """What a unit of torque against the load does in a sample to a filter's states, shape (states,)."""
    n = chain.size
    a, b = state_space(chain)
    block = np.zeros((2 * n + 1, 2 * n + 1))
    block[: 2 * n, : 2 * n], block[: 2 * n, 2 * n] = a, -b[:, -1]
    push = np.zeros(states)
    push[: 2 * n] = expm(block * interval)[: 2 * n, 2 * n]
    return push


@njit
def filter_error(
    transition: Array, output: Array, gains: Array, push: Array, torque: Array, missed: Array, seen: Array
) -> None:
    """Recursion of the filter's error under a torque; writes errors after the readings, and innovations."""
    error = np.zeros(push.size)
    for k in range(torque.size):
        seen[k] = output @ error
        error = error - gains[min(k, gains.shape[0] - 1)] @ seen[k]
        missed[k] = error
        error = transition @ error + push * torque[k]


def whitening(observer: ObserverNumbers, counts: Array) -> Array:
    """Matrix, (m, m), that makes the settled filter's innovations white and of variance 1."""
    left = np.eye(len(counts)) - observer.output @ observer.gains[-1]
    spread = np.linalg.solve(left, np.diag(counts**2 / 12.0))
    return np.asarray(np.linalg.inv(np.linalg.cholesky(0.5 * (spread + spread.T))))
