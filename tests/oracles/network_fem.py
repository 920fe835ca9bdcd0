"""Modes of a network of strings by the p-version of finite elements: no wave formula, every rope its own.

Shape functions of a string of length 1 are the two linear ones and integrated Legendre polynomials. A string
that runs with speed v has the kinetic energy of (w_t + v w_x), hence a gyroscopic matrix.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Legendre
from scipy.linalg import eigh, eigvals


@dataclass(frozen=True)
class String:
    """One rope: rows of its ends, density, wave speed and speed; its length is 1.

    ``taper``: how much its stiffness grows from start to end, as a share of the mean, evenly along it.
    """

    start: np.ndarray
    end: np.ndarray
    density: float
    wave_speed: float
    speed: float = 0.0
    ropes: int = 1
    taper: float = 0.0


@cache
def shape_functions(degree):
    """Values and slopes of the shape functions at Gauss points of [0, 1], with the weights and points."""
    x, weights = np.polynomial.legendre.leggauss(degree + 2)
    values, slopes = [(1 - x) / 2, (1 + x) / 2], [np.full_like(x, -0.5), np.full_like(x, 0.5)]
    for n in range(2, degree + 1):
        scale = np.sqrt((2 * n - 1) / 2)
        slopes.append(scale * Legendre.basis(n - 1)(x))
        values.append(scale * (Legendre.basis(n)(x) - Legendre.basis(n - 2)(x)) / (2 * n - 1))
    return np.array(values), 2 * np.array(slopes), weights / 2, (1 + x) / 2


def matrices(strings, mass, stiffness, degree):
    """Mass, gyroscopic and stiffness matrix of a network; its own coordinates first."""
    n = mass.shape[0]
    total = n + sum(string.ropes for string in strings) * (degree - 1)
    m, g, k = (np.zeros((total, total)) for _ in range(3))
    m[:n, :n], k[:n, :n] = mass, stiffness
    values, slopes, weights, points = shape_functions(degree)
    inner = n
    for string in strings:
        rho, c, v = string.density, string.wave_speed, string.speed
        for _ in range(string.ropes):
            rows = np.zeros((degree + 1, total))
            rows[0, :n], rows[1, :n] = string.start, string.end
            rows[2:, inner : inner + degree - 1] = np.eye(degree - 1)
            inner += degree - 1
            cross = (values * weights) @ slopes.T
            for matrix, local in (
                (m, rho * (values * weights) @ values.T),
                (g, rho * v * (cross - cross.T)),
                (
                    k,
                    rho * (slopes * weights * (c**2 * (1 + string.taper * (points - 0.5)) - v**2)) @ slopes.T,
                ),
            ):
                matrix += rows.T @ local @ rows
    return m, g, k


def natural_frequencies(strings, mass, stiffness, degree):
    """All natural frequencies of the discretised network [rad/s], rigid-body modes as zeros."""
    m, g, k = matrices(strings, mass, stiffness, degree)
    if not g.any():
        return np.sqrt(np.maximum(eigh(k, m, eigvals_only=True), 0.0))
    return with_flow(m, g, k)


def with_flow(m, g, k):
    """Natural frequencies [rad/s] of matrices of mass, of what flows, and of stiffness."""
    size = m.shape[0]
    one, none = np.eye(size), np.zeros((size, size))
    try:  # Hermitian where nothing moves without strain: double roots keep their digits
        energy = np.block([[k, none], [none, m]])
        return eigh(-1j * np.block([[none, k], [-k, -g]]), energy, eigvals_only=True)[-size:]
    except np.linalg.LinAlgError:
        values = eigvals(np.block([[none, one], [-k, -g]]), np.block([[one, none], [none, m]]))
        return np.sort(values.imag)[-size:]


def modes_below(chain, omega):
    """Modes of a chain below a frequency by eigenvalues of its matrix, Eq. (M.5), rigid-body mode included.

    K/omega of a segment is Z (cot, -1/sin), a held end is struck out.
    """
    n, pendants = chain.masses.size, chain.pendants
    matrix = np.diag(np.append(-omega * chain.masses, np.zeros(len(pendants))))
    inside = 0
    for i, (z, time) in enumerate(zip(chain.impedances, chain.travel_times, strict=True)):
        phase, a, b = omega * time, i, (i + 1) % n
        inside += int(phase / np.pi)
        for j in (a, b):
            matrix[j, j] += z / np.tan(phase)
        matrix[a, b] -= z / np.sin(phase)
        matrix[b, a] -= z / np.sin(phase)
    for i, ground in enumerate(chain.ground_springs):
        matrix[i, i] += ground / omega
    for i, own in enumerate(pendants, n):
        strain = np.zeros(n + len(pendants))
        strain[i], strain[own.joint] = 1.0, -1.0
        matrix += own.stiffness / omega * np.outer(strain, strain)
        matrix[i, i] += own.ground / omega - omega * own.mass
    held = [joint for joint, fixed in ((0, chain.fixed[0]), (n - 1, chain.fixed[1])) if fixed]
    free = np.setdiff1d(np.arange(n + len(pendants)), held)
    return int(np.sum(np.linalg.eigvalsh(matrix[np.ix_(free, free)]) < 0.0)) + inside
