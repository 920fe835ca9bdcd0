r"""The flat output of a lumped chain: angles and motor torque are polynomials in s times it.

Of inertias :math:`J_1` (motor) to :math:`J_N` (load), joined by springs :math:`k_i` with dampers :math:`b_i`,
:math:`D_i = 1 + (b_i/k_i)s`. From the load backwards, without a polynomial division:

.. math::
    R_N = 1, \quad a_N = J_N s^2, \qquad
    R_i = D_i R_{i+1} + a_{i+1}/k_i, \quad a_i = J_i s^2 R_i + D_i a_{i+1}

Then :math:`\theta_i = D_1 \cdots D_{i-1} R_i z`, link 1 carries :math:`D_1 a_2 z`, and the motor needs
:math:`J_1 s^2 R_1 z + D_1 a_2 z` besides its friction. Without dampers z is the load angle.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlatOutput:
    """Polynomials of a chain of n inertias, coefficients of rising powers of s, all of length 2n + 1."""

    angles: Array  # (n, 2n + 1): each angle per flat output
    inertial: Array  # (2n + 1,): acceleration of the first inertia per flat output, s^2 R_1 [1/s^2]
    elastic: Array  # (2n + 1,): torque of the first link per flat output, D_1 a_2 [N m]
    time_constants: Array  # (n - 1,): b_i / k_i of the links [s]: the load is z through 1 + (b_i / k_i) s
    states: Array  # (2n, 2n): angles, then speeds, per z and its first 2n - 1 derivatives

    @property
    def size(self) -> int:
        """Number of inertias."""
        return int(self.angles.shape[0])

    @property
    def leading(self) -> float:
        """Coefficient c of the highest derivative in the first inertia's acceleration; mu is J_1 c."""
        return float(self.inertial[-1])

    @property
    def from_states(self) -> Array:
        """Z and its first 2n - 1 derivatives per angles, then speeds, shape (2n, 2n)."""
        inverse: Array = np.asarray(np.linalg.inv(self.states), dtype=np.float64)
        return inverse


def flat_output(chain: LumpedChain, *, damped: bool = True) -> FlatOutput:
    """Polynomials of a lumped chain whose links join equal angles; others are refused, see `reflected`.

    Its viscous friction beyond the first inertia is counted, that of the first is the control law's business;
    ``damped``: whether the dampers of the links are; the laws of the dissertation leave them out.
    """
    if any(ratio != (1.0, 1.0) for ratio in chain.ratios):
        raise InputRefused("a link joins unequal angles: reflect the lumped chain to its first shaft")
    n = chain.size
    length = 2 * n + 1
    times = np.array(chain.damping) / np.array(chain.stiffness) if damped else np.zeros(n - 1)
    rest = np.zeros(length)
    rest[0] = 1.0
    torque = _moved(rest, chain, n - 1, damped)
    carried = np.zeros(length)
    angles = np.zeros((n, length))
    angles[n - 1] = rest
    for i in range(n - 2, -1, -1):
        rest, carried = _through(rest, times[i]) + torque / chain.stiffness[i], _through(torque, times[i])
        angles[i] = rest
        torque = _moved(rest, chain, i, damped) + carried
    for i in range(1, n):
        for time in times[:i]:
            angles[i] = _through(angles[i], time)
    inertial = _shifted(rest, 2)
    states = np.zeros((2 * n, 2 * n))
    states[:n] = angles[:, : 2 * n]
    states[n:, 1:] = angles[:, : 2 * n - 1]
    return FlatOutput(angles=angles, inertial=inertial, elastic=carried, time_constants=times, states=states)


def _through(polynomial: Array, time: float) -> Array:
    """(1 + time s) polynomial."""
    return polynomial + time * _shifted(polynomial, 1)


def _shifted(polynomial: Array, power: int) -> Array:
    """s^power polynomial, cut to its length."""
    return np.concatenate((np.zeros(power), polynomial[:-power]))


def _moved(polynomial: Array, chain: LumpedChain, i: int, damped: bool) -> Array:
    """Torque that moves inertia i along the polynomial."""
    friction = chain.viscous[i] if damped else 0.0
    return chain.inertias[i] * _shifted(polynomial, 2) + friction * _shifted(polynomial, 1)
