r"""Bound of the load's error under a law that learns the load's torque along the motion.

With p the load's true parameters, :math:`\delta_j` and :math:`\tau_j` what a unit of each asks of states
and motor (`cabledrive.control.load_torque`) and K the feedback, :math:`\zeta = x - x_d - \sum_j p_j\delta_j`
obeys

.. math:: \zeta_{k+1} = (A + BK)\zeta_k + Bm_k + r_k, \qquad
    m = \sum_j(\hat p_j - p_j)(\tau_j - K\delta_j) + d

and :math:`\delta` leaves the load where it is: the load's error is that of :math:`\zeta`. d is a torque of
the motor of at most :math:`\Delta`. An estimate lies within its bounds, and as long as it lies within five of
its standard deviations, :math:`|m| \le h = \sum_j R_j|\tau_j - K\delta_j| + \Delta` with R the smaller of the
two. Without r the error lies within :math:`|g| * h`, g the response of the load to a torque of one sample.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.control.linear_laws import sampled_motion
from cabledrive.control.numbers import HIGH, LOW, LawNumbers
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain

DEVIATIONS = 5.0
"""Within which an estimate is taken to lie."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IdealLoop:
    """The law on the chain it is made for, with true states: memory first, then angles and speeds."""

    matrix: Array  # (k + 2n, k + 2n)
    push: Array  # (k + 2n,): from the motor's torque
    load: int  # place of the load's angle

    def response(self, samples: int) -> Array:
        """Load's angle after a torque of one sample, shape (samples,) [rad/(N m)]."""
        found, state = np.zeros(samples), self.push
        for k in range(1, samples):
            found[k] = state[self.load]
            state = self.matrix @ state
        return found


def ideal_loop(law: LawNumbers, chain: LumpedChain, interval: float) -> IdealLoop:
    """The loop of a law that learns, or of a linear one; ``chain``: that it is made for."""
    k, n = law.matrix.shape[0], chain.size
    a, b = sampled_motion(chain, interval)
    row = law.rows[:1, : k + 2 * n]
    matrix = np.zeros((k + 2 * n, k + 2 * n))
    matrix[:k] = law.matrix[:, : k + 2 * n]
    matrix[k:, k:] = a
    matrix[k:] += b @ row
    return IdealLoop(matrix=matrix, push=np.concatenate((np.zeros(k), b[:, 0])), load=k + n - 1)


def missing_torque(row: Array, states: Array, torque: Array) -> Array:
    r"""Torque at the motor per error of each parameter, :math:`\tau_j - K\delta_j`, shape (samples, p)."""
    return np.asarray((torque - states @ row).T)


def believed_range(law: LawNumbers, estimates: Array, deviations: Array) -> Array:
    """By how much each estimate may be off, shape (samples, p); ``estimates``, ``deviations``: the same."""
    low, high = law.learning[LOW], law.learning[HIGH]
    return np.minimum(np.maximum(high - estimates, estimates - low), DEVIATIONS * deviations)
