"""Transitions of many lumped chains at once, as the module `plant` beside it makes them one by one."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop_numbers import Array

TERMS = 14


def free_transitions(chains: Sequence[LumpedChain], interval: float, current_rate: float) -> Array:
    """States of free rows after one sample, from states, command, torques, and a torque that rises.

    ``chains``: all of n inertias, links between equal angles; ``interval``: sample time [s];
    ``current_rate``: bandwidth of the torque loop [rad/s]; 0: none.
    Returns shape (rows, 2n + 1, 2n + 5): as the second table of
    `cabledrive.rig.closed_loop.plant_kernels.PlantNumbers`.
    """
    n = chains[0].size
    m = 2 * n + 1
    inverse = 1.0 / np.array([chain.inertias for chain in chains])
    links = np.diff(np.eye(n), axis=0)
    stiffness = _across(links, np.array([chain.stiffness for chain in chains]))
    damping = _across(links, np.array([chain.damping for chain in chains]))
    damping += np.array([np.diag(chain.viscous) for chain in chains])
    block = np.zeros((len(chains), m + 4, m + 4))
    block[:, :n, n : 2 * n] = np.eye(n)
    block[:, n : 2 * n, :n] = -inverse[:, :, None] * stiffness
    block[:, n : 2 * n, n : 2 * n] = -inverse[:, :, None] * damping
    block[:, n, [2 * n, m + 1]] = inverse[:, :1]
    block[:, 2 * n - 1, m + 2] = inverse[:, -1]
    block[:, 2 * n, 2 * n : m + 1] = -current_rate, current_rate
    block[:, m + 1, m + 3] = 1.0 / interval  # the motor's torque, rising
    return apart(block * interval)[:, :m]


def _across(links: Array, values: Array) -> Array:
    """Matrices G^T diag(values) G."""
    return np.einsum("ji,dj,jk->dik", links, values, links)


def exponentials(matrices: Array) -> Array:
    """Exponentials of many small matrices, by scaling, Taylor's series and squaring.

    ``matrices``, shape (number, m, m).
    Returns shape (number, m, m).
    """
    return _squared(matrices, int(np.max(_halvings(matrices), initial=0)))


def apart(matrices: Array) -> Array:
    """As `exponentials`, each to the same bits whichever others are made with it.

    ``matrices``, shape (number, m, m).
    Returns shape (number, m, m).
    """
    halvings, found = _halvings(matrices), np.empty_like(matrices)
    for count in np.unique(halvings):
        found[halvings == count] = _squared(matrices[halvings == count], int(count))
    return found


def _halvings(matrices: Array) -> NDArray[np.int64]:
    """How often each matrix is halved until its norm is at most a quarter, shape (number,)."""
    sizes = np.max(np.sum(np.abs(matrices), axis=2), axis=1)
    return np.maximum(0, np.ceil(np.log2(np.maximum(sizes, 1e-300))).astype(np.int64) + 2)


def _squared(matrices: Array, halvings: int) -> Array:
    """Exponentials by Taylor's series of the halved matrices, squared as often."""
    scaled = matrices / 2.0**halvings
    identity = np.eye(matrices.shape[1])
    found = identity + scaled / TERMS
    for k in range(TERMS - 1, 0, -1):
        found = identity + scaled @ found / k
    for _ in range(halvings):
        found = found @ found
    return found
