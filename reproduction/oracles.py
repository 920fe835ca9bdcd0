"""What the tests of the errata share, without the package: the loop in closed form, chains of inertias."""

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np
from scipy.optimize import brentq

Array = np.ndarray[Any, Any]

EA, DENSITY, LENGTH, RADIUS, PRETENSION = 2.6e9 * 4.26e-7, 4.9e-4, 1.0, 0.03, 5.0  # Table 3.1
LOAD, DRIVES = 7.316e-6, {1: 7.316e-6, 2: 0.0011}  # J2, and J1 by configuration

BETA = 2 * 850.0 * 0.04**2 / 0.00235  # Tables 4.2, 6.2


def stretched(pretension: float = PRETENSION) -> tuple[float, float, float, float]:
    """Length, density, c_u and c_w of a span whose mass is conserved when it is pretensioned."""
    stretch = 1 + pretension / EA
    density = DENSITY / stretch
    return LENGTH * stretch, density, np.sqrt(EA * stretch / density), np.sqrt(pretension / density)


def out_of_phase(inertia: float, length: float, density: float, c_u: float, count: int = 2) -> list[float]:
    """Lowest roots [Hz] of (3.13) in which the pulleys turn; one in each (m pi, (m + 1) pi)."""
    chi1, chi2 = (J / (2 * density * RADIUS**2 * length) for J in (inertia, LOAD))

    def residual(x: float) -> float:
        return float((chi1 * chi2 * x**2 - 1) * np.sin(x) - (chi1 + chi2) * x * np.cos(x))

    roots = (brentq(residual, m * pi + 1e-9, (m + 1) * pi - 1e-9, xtol=1e-14) for m in range(count))
    return [float(x * c_u / length / (2 * pi)) for x in roots]


def link_matrix(links: Sequence[float]) -> Array:
    """Stiffness or damping matrix of a chain of inertias, link by link from the motor."""
    matrix = np.zeros((len(links) + 1, len(links) + 1))
    for i, link in enumerate(links):
        matrix[i : i + 2, i : i + 2] += link * np.array([[1, -1], [-1, 1]])
    return matrix


def state_matrix(inertias: Sequence[float], springs: Array, dampers: Array) -> Array:
    """State matrix of a chain: angles, then speeds."""
    n, inverse = len(inertias), np.diag(1 / np.array(inertias))
    return np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ springs, -inverse @ dampers]])
