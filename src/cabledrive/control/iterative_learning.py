r"""Iterative learning: a torque added along a motion, corrected by the error of the last repetition.

Between repetitions, with P from added torque to the load's error in the closed loop and its singular values
:math:`P = U\Sigma V^T`, the torque is :math:`w = V_ra` in the first r directions and

.. math:: a_{j+1} = \Pi\big(a_j - g\,\Sigma_r^{-1}U_r^Te_j\big), \qquad e_j = P_{true}V_ra_j + d

with d what repeats and :math:`\Pi` the projection on a ball. :math:`\Pi` brings no two points further apart,
so that the step is a contraction by :math:`\gamma = \lVert I - g\,\Sigma_r^{-1}U_r^TP_{true}V_r\rVert_2`
wherever that is below 1: by Banach's theorem the torque converges to one fixed point, from any beginning and
by :math:`\gamma` a repetition. That point lies within the first correction over :math:`1 - \gamma`, which is
the radius of the ball: where the loop is the linear one the projection never acts. r is the most directions
with which :math:`\gamma` keeps a limit on every plant that is looked at, and rounding to counts another.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import toeplitz

from cabledrive.parameters.arrays import Array

GAIN = 0.7
"""Share of the error that a repetition takes away in the nominal loop."""
MOST_CONTRACTION = 0.8
"""Of the worst plant that is looked at."""
SIGMAS = 5.0
"""Deviations of the command by rounding that keep its limit."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RepetitionLearning:
    """What is learnt between repetitions, in directions of the torque."""

    directions: Array  # (k, r): torque at the nodes of each direction, of length 1
    correction: Array  # (r, k): from mean errors between the nodes [rad] to directions [N m]
    contraction: float  # largest over the plants that were looked at

    def radius(self, error: Array) -> float:
        """Of the ball that holds the fixed point, by the first error, shape (k,) [rad]; [N m]."""
        return float(np.linalg.norm(self.correction @ error)) / (1.0 - self.contraction)

    def corrected(self, place: Array, error: Array, radius: float) -> Array:
        """Directions after a repetition [N m]; ``place``, shape (r,); ``error``, shape (k,) [rad]."""
        found = place - self.correction @ error
        size = float(np.linalg.norm(found))
        return found if size <= radius else found * (radius / size)


def lifted(impulse: Array, nodes: int, width: int) -> Array:
    """Mean error between nodes from torque at the nodes, straight lines between them, shape (nodes, nodes).

    ``impulse``, shape (samples,): of the load's angle to the torque of one sample [rad/(N m)]; ``width``:
    samples from node to node.
    """
    hat = 1.0 - np.abs(np.arange(1 - width, width)) / width
    smooth = np.convolve(impulse, hat)[: nodes * width]
    smooth = np.pad(smooth, (0, nodes * width - len(smooth)))
    # A node's hat begins a width before it: the first mean holds its rising half alone.
    column = smooth.reshape(nodes, width).mean(axis=1)
    return np.asarray(toeplitz(column, np.zeros(nodes)))


def repetition_learning(
    nominal: Array, others: Sequence[Array], command: Array, noise: float, ripple: float
) -> RepetitionLearning | None:
    """The most directions that keep both limits, contraction on every plant; none: not one direction does.

    ``nominal``, ``others``, ``command``, shape (k, k): from `lifted`, of errors and of the whole command;
    ``noise``: standard deviation of a mean error by rounding [rad]; ``ripple``: most that five deviations of
    the command by it may be [N m].
    """
    u, sizes, v = np.linalg.svd(nominal)
    steps = [GAIN / sizes[:, None] * (u.T @ plant @ v.T) for plant in (nominal, *others)]

    def contraction(r: int) -> float:
        return max(float(np.linalg.norm(np.eye(r) - step[:r, :r], 2)) for step in steps)

    made = np.sum((command @ v.T) ** 2, axis=0) * (GAIN * noise / np.maximum(sizes, 1e-300)) ** 2
    by_rounding = SIGMAS * np.sqrt(np.cumsum(made) / len(sizes))
    low, high = 0, int(np.count_nonzero(by_rounding <= ripple)) + 1
    while high - low > 1:  # the norm of a leading block grows with its size
        middle = (low + high) // 2
        low, high = (middle, high) if contraction(middle) <= MOST_CONTRACTION else (low, middle)
    if low == 0:
        return None
    return RepetitionLearning(
        directions=v[:low].T, correction=GAIN / sizes[:low, None] * u[:, :low].T, contraction=contraction(low)
    )


def torque_along(nodes: Array, width: int, samples: int) -> Array:
    """Torque of every sample, straight lines between nodes [N m], shape (samples,)."""
    places = width * np.arange(len(nodes) + 1.0) - 1.0
    return np.asarray(np.interp(np.arange(samples), places, np.append(0.0, nodes), right=0.0))
