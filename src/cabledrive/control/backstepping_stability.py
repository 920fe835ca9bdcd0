r"""The sufficient condition of the backstepping theorem, at the states that a run meets.

With signs :math:`s_i` of the errors,

.. math::
    D_z = -\tfrac12(A + A^T) - \tfrac12(S + S^T), \qquad
    S_{ij} = s_is_j\Big|\frac{\partial\alpha_{i-1}}{\partial\hat p}\Big|\,|\Gamma\varphi_j|

must be positive definite for every choice of signs. As printed it adds errors of different units. Derivatives
are taken by complex steps, exact to round-off.
"""

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.backstepping_recursion import BacksteppingStep, backstepping_step, signal_count
from cabledrive.control.numbers import BY_REFERENCE, GAIN, NOMINAL, SLOPE, LawNumbers
from cabledrive.parameters.arrays import Array

STEP = 1e-30


def errors_matrix(law: LawNumbers, estimate: Array, size: int) -> Array:
    """A of the errors' dynamics of 4 or 6 states with fixed estimates, (size, size), Eq. (6.103)."""
    matrix = np.diag(np.ones(size - 1), 1) - law.matrix
    for place in range(1, size - 1, 2):
        matrix[place, place + 1] = estimate[place - 1]
    return matrix


def scaled_states(law: LawNumbers, states: Array) -> Array:
    """States x of the law, (2n,), from angles and speeds, (2n,), from the motor to the load."""
    n = len(states) // 2
    x = np.empty(2 * n)
    x[0], x[1] = states[n - 1], states[2 * n - 1]
    for j in range(1, n):
        scale = law.rows[0, j - 1]
        x[2 * j] = scale * (states[n - 1 - j] - states[n - j])
        x[2 * j + 1] = scale * (states[2 * n - 1 - j] - states[2 * n - j])
    return x


def backstepping_row(law: LawNumbers, size: int) -> list[float]:
    """Command per angle and speed of 4 or 6 states, estimates fixed, without Coulomb friction and offset."""
    estimate = law.learning[NOMINAL].copy()
    estimate[-3:-1] = 0.0  # Coulomb friction and offset, before the gain of the input
    signals = np.zeros(signal_count(size // 2, bool(law.scalars[BY_REFERENCE])))

    def command(states: Array) -> float:
        x, speed = scaled_states(law, states), states[size // 2]
        return float(law_step(law, estimate, x, signals, speed, 0.0).command)

    return [command(unit) - command(np.zeros(size)) for unit in np.eye(size)]


def law_step(
    law: LawNumbers, estimate: NDArray[Any], x: Array, signals: Array, speed: float, friction: float
) -> BacksteppingStep:
    """One step of a frozen law from its scaled states."""
    known = bool(law.scalars[BY_REFERENCE])
    return backstepping_step(law.matrix, law.rows[0], known, estimate, x, signals, speed, friction)


def stability_margin(law: LawNumbers, estimate: Array, states: Array, reference: Array) -> float:
    """Smallest eigenvalue [rad/s] of D_z over all signs at a state; above 0 Eq. (6.100) holds there."""
    size = len(states)
    x, speed = scaled_states(law, states), states[size // 2]
    signals = reference[:-1] if law.scalars[BY_REFERENCE] else reference[: size + 1]
    friction = np.tanh(law.scalars[SLOPE] * (reference[-1] if law.scalars[BY_REFERENCE] else speed))
    given = (x, signals, speed, friction)
    phi = law_step(law, estimate, *given).regressors
    slopes = np.zeros((size, len(estimate)))
    for m in range(len(estimate)):
        moved = estimate.astype(complex)
        moved[m] += 1j * STEP * abs(estimate[m] or 1.0)
        slopes[1:, m] = law_step(law, moved, *given).virtual.imag / (STEP * abs(estimate[m] or 1.0))
    learnt = np.linalg.norm(phi * law.learning[GAIN], axis=1)
    coupling = np.outer(np.linalg.norm(slopes, axis=1), learnt)
    fixed = errors_matrix(law, estimate, size)
    worst = np.inf
    for signs in product((1.0, -1.0), repeat=size - 1):
        s = np.array([1.0, *signs])
        matrix = fixed + coupling * np.outer(s, s)
        worst = min(worst, float(np.linalg.eigvalsh(-0.5 * (matrix + matrix.T))[0]))
    return worst
