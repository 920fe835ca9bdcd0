"""Beams under tension that changes along them, by finite elements of high order: no wave formula.

Cubic shape functions of Hermite, and x^2 (1 - x)^2 times Legendre polynomials; elements grow by the factor
three from both ends, where a stiff rope bends within a small length.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from scipy.linalg import eigh
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True)
class Beam:
    """One rope: rows of displacement and slope of its start, then of its end; it may be a string (EI = 0).

    ``density`` per length; ``tension`` at start and end; ``ropes`` that all move alike.
    """

    rows: np.ndarray
    length: float
    density: float
    bending: float
    tension: tuple[float, float]
    ropes: int = 1


def shape_functions(degree):
    """Four of Hermite, then the bubbles: polynomials on [0, 1]."""
    hermite = [[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]]
    bubble = Polynomial([0, 0, 1, -2, 1])
    legendre = [
        np.polynomial.Legendre.basis(k).convert(kind=Polynomial)(Polynomial([-1, 2]))
        for k in range(degree - 3)
    ]
    return [Polynomial(c) for c in hermite] + [bubble * one for one in legendre]


def nodes_of(beam, elements):
    """Places of the nodes, shape (m,)."""
    inner = np.linspace(0, 1, elements + 1)
    e = np.sqrt(beam.bending / min(beam.tension)) / beam.length
    steps = []
    while beam.bending and 0 < e < 0.5 / elements:
        steps.append(e)
        e *= 3
    near = np.array(steps)
    return beam.length * np.unique(np.concatenate((inner, near, 1 - near)))


def beam_matrices(beam, elements, degree):
    """Mass and stiffness of a beam, its four end coordinates first."""
    shapes = shape_functions(degree)
    x, weights = np.polynomial.legendre.leggauss(degree + 4)
    x, weights = (1 + x) / 2, weights / 2
    values = [np.array([f.deriv(d)(x) if d else f(x) for f in shapes]) for d in range(3)]
    nodes = nodes_of(beam, elements)
    m, per = nodes.size, degree - 3
    size = 2 * m + per * (m - 1)
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for i, h in enumerate(np.diff(nodes)):
        scale = np.ones(len(shapes))
        scale[[1, 3]] = h
        place = nodes[i] + h * x
        tension = beam.tension[0] + (beam.tension[1] - beam.tension[0]) * place / beam.length
        w, d, c = (scale[:, None] * value / h**k for k, value in enumerate(values))
        at = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3, *range(2 * m + per * i, 2 * m + per * (i + 1))]
        own = np.ix_(at, at)
        mass[own] += beam.density * h * (w * weights) @ w.T
        stiffness[own] += h * ((d * weights * tension) @ d.T + beam.bending * (c * weights) @ c.T)
    order = [0, 1, 2 * m - 2, 2 * m - 1, *range(2, 2 * m - 2), *range(2 * m, size)]
    return mass[np.ix_(order, order)], stiffness[np.ix_(order, order)]


def with_beams(mass, stiffness, beams, coordinates, *, elements, degree):
    """Mass and stiffness of a network with beams; ``coordinates``: how many of them come first."""
    parts = [(beam, *beam_matrices(beam, elements, degree)) for beam in beams for _ in range(beam.ropes)]
    size = mass.shape[0]
    # A string has no slope at its ends that anything ties: two more coordinates of its own.
    grown = sum(m.shape[0] - 4 + 2 * (not beam.bending) for beam, m, _ in parts)
    mass, stiffness = (np.pad(own, (0, grown)) for own in (mass, stiffness))
    for beam, m, k in parts:
        more = m.shape[0] - 4 + 2 * (not beam.bending)
        at = np.concatenate((np.arange(coordinates), np.arange(size, size + more)))
        rows = np.zeros((m.shape[0], at.size))
        rows[:4, :coordinates] = beam.rows
        rows[4:, coordinates : coordinates + m.shape[0] - 4] = np.eye(m.shape[0] - 4)
        if not beam.bending:
            rows[[1, 3], :] = 0.0
            rows[1, -2] = rows[3, -1] = 1.0
        mass[np.ix_(at, at)] += rows.T @ m @ rows
        stiffness[np.ix_(at, at)] += rows.T @ k @ rows
        size += more
    return mass, stiffness


def frequencies(mass, stiffness, below):
    """Natural frequencies [rad/s], ascending, up to about ``below``.

    Of each part that nothing ties to the others the largest eigenvalues of M against K + w^2 M, scaled to a
    unit diagonal: the low ones of stiff beams would drown in the round-off of K against M.
    """
    shifted = stiffness + below**2 * mass
    _, label = connected_components(csr_array(shifted != 0.0), directed=False)
    found = []
    for part in range(label.max() + 1):
        own = np.ix_(label == part, label == part)
        scale = np.outer(*2 * (1 / np.sqrt(np.diag(shifted[own])),))
        values = eigh(mass[own] * scale, shifted[own] * scale, eigvals_only=True)
        found.append(np.sqrt(np.maximum(1 / values[values > 0] - below**2, 0.0)))
    return np.sort(np.concatenate(found))
