"""What a torque at the load makes of the filter: the states that it misses and the innovations that it makes.

The filter does not know of the torque. Its error is linear in it and depends neither on the law nor on the
plant's motion, so that both are known along a reference beforehand; B. Friedland, IEEE Trans. Automatic
Control 14, 359-367, 1969, separates the estimation of a bias in this way.
"""

import numpy as np
from scipy.linalg import expm

from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, state_space


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
