"""What follows from the components of a cable law by numbers: slope, energy, slack strain."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Components: TypeAlias = tuple[Array, Array, Array]
Formula: TypeAlias = Callable[[Array, Array, Array], Components]

GRADIENT_STEP = 6e-6
"""Step of central differences of components, in gradients [-]."""
SHORTEST = -0.5
"""Strain down to which a cable is looked for that is slack [-]."""


def central_differences(formula: Formula, u_x: Array, v_x: Array, w_x: Array) -> Array:
    """Derivatives of the components with respect to the gradients, shape (..., 3, 3), row: component [N]."""
    at = [np.asarray(gradient, dtype=np.float64) for gradient in (u_x, v_x, w_x)]
    columns = []
    for k in range(3):
        ahead = [value + GRADIENT_STEP * (k == i) for i, value in enumerate(at)]
        behind = [value - GRADIENT_STEP * (k == i) for i, value in enumerate(at)]
        change = np.stack(formula(*ahead)) - np.stack(formula(*behind))
        columns.append(change / (2.0 * GRADIENT_STEP))
    return np.moveaxis(np.stack(columns), (0, 1), (-1, -2))


def work_from_zero(formula: Formula, u_x: Array, v_x: Array, w_x: Array) -> Array:
    """Work of the components on the straight path from zero to the gradients [J/m], by 16 points of Gauss."""
    places, weights = np.polynomial.legendre.leggauss(16)
    total = np.zeros(np.shape(u_x))
    for share, weight in zip(0.5 * (places + 1.0), 0.5 * weights, strict=True):
        x, y, z = formula(share * u_x, share * v_x, share * w_x)
        total += weight * (x * u_x + y * v_x + z * w_x)
    return total


def first_slack(formula: Formula, guess: float) -> float:
    """Strain of the straight cable at which its tension vanishes, by bisection [-]; -inf: nowhere."""

    def pushes(strain: float) -> bool:
        zero = np.zeros(1)
        return float(np.ravel(formula(zero + strain, zero, zero)[0])[0]) < 0.0

    low, high = guess, 0.0
    while not pushes(low):
        low, high = 2.0 * low, low
        if low < SHORTEST:
            return -np.inf
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if pushes(middle) else (low, middle)
    return low
