"""Ropes by finite elements of high order, no wave formula: beams whose tension changes, ropes that sag.

A rope without bending has linear functions and bubbles between nodes, one that bends cubic ones of Hermite
and bubbles of order four; elements grow by the factor three from both ends, where a stiff rope bends within a
small length. No condensation: every polynomial is a coordinate of the machine.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from scipy.linalg import eigh
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True)
class Beam:
    """Rows of the displacement of its start, then of its end and, with EI, of the slope after each.

    ``density`` per length; ``tension`` at start and end; ``ropes`` that all move alike.
    """

    rows: np.ndarray
    length: float
    density: float
    bending: float
    tension: tuple[float, float]
    ropes: int = 1

    def matrices(self, elements, degree):
        """Mass and stiffness, the motions of its ends first, as in its rows."""
        nodes, place, measure, x = cut(self, elements, degree)
        w0, w1, w2 = basis(nodes, degree, self.bending > 0, x)
        tension = self.tension[0] + (self.tension[1] - self.tension[0]) * place / self.length
        mass = self.density * weighted(w0, measure)
        stiffness = weighted(w1, measure * tension) + self.bending * weighted(w2, measure)
        return ends_first([(1 + (self.bending > 0), w0.shape[1])], nodes, mass, stiffness)


@dataclass(frozen=True)
class HangingRope:
    """A rope that sags, stretched by c u' + s w', turned by c w' - s u'.

    Rows of the motion of its start, then of its end: along, across and, with EI, slope.
    ``length`` and ``bending`` under tension, ``density`` and ``rigidity`` per unstretched length; ``load``
    across per length, ``shear`` at the start.
    """

    rows: np.ndarray
    length: float
    density: float
    rigidity: float
    bending: float
    tension: tuple[float, float]
    shear: float
    load: float
    ropes: int = 1

    def tension_at(self, x):
        """Tension at a place from its start."""
        return self.tension[0] + (self.tension[1] - self.tension[0]) * x / self.length

    @property
    def stretch(self):
        """Length under tension over the unstretched one, by the string of the same travel time."""
        return 1.0 + np.mean(np.sqrt(self.tension)) ** 2 / self.rigidity

    def taut_at(self, x):
        """T/(1 + T/EA) of a metre of rope, by lengths under tension."""
        pull = self.tension_at(x)
        return pull * self.stretch / (1.0 + pull / self.rigidity)

    def slope(self, x):
        """Slope at rest."""
        return (self.shear - self.load * x) / self.tension_at(x)

    def matrices(self, elements, degree):
        """Mass and stiffness, the motions of its ends first, as in its rows."""
        nodes, place, measure, x = cut(self, elements, degree)
        u, w = basis(nodes, degree, False, x), basis(nodes, degree, self.bending > 0, x)
        slope = self.slope(place)[:, None]
        cosine, sine = 1.0 / np.sqrt(1.0 + slope**2), slope / np.sqrt(1.0 + slope**2)
        along, across = np.hstack((u[0], 0 * w[0])), np.hstack((0 * u[0], w[0]))
        mass = weighted(along, measure) + weighted(across, measure)
        stretched = np.hstack((cosine * u[1], sine * w[1]))
        turned, bent = np.hstack((-sine * u[1], cosine * w[1])), np.hstack((0 * u[0], w[2]))
        stiffness = self.rigidity * self.stretch * weighted(stretched, measure)
        stiffness += weighted(turned, measure * self.taut_at(place)) + self.bending * weighted(bent, measure)
        fields = [(1, u.shape[-1]), (1 + (self.bending > 0), w.shape[-1])]
        return ends_first(fields, nodes, self.density / self.stretch * mass, stiffness)


def shear_between(tension, load, length):
    """Shear at the start of a rope whose ends lie on its chord, by a fine trapezium rule."""
    x = np.linspace(0.0, length, 200_001)
    pull = tension[0] + (tension[1] - tension[0]) * x / length
    return load * np.trapezoid(x / pull, x) / np.trapezoid(1.0 / pull, x)


def cut(rope, elements, degree):
    """Nodes, shape (m,), places and weights of quadrature, shape (points,), and its points in [0, 1]."""
    inner = np.linspace(0, 1, elements + 1)
    e = np.sqrt(rope.bending / min(rope.tension)) / rope.length
    steps = []
    while rope.bending and 0 < e < 0.5 / elements:
        steps.append(e)
        e *= 3
    near = np.array(steps)
    nodes = rope.length * np.unique(np.concatenate((inner, near, 1 - near)))
    x, weights = np.polynomial.legendre.leggauss(degree + 6)
    x, h = (1 + x) / 2, np.diff(nodes)[:, None]
    return nodes, (nodes[:-1, None] + h * x).ravel(), (h * weights / 2).ravel(), x


def basis(nodes, degree, smooth, places):
    """Values, slopes and curvatures of a field's functions at places of each element.

    Returns three arrays, shape (elements * places, n): displacement (and slope) of the nodes first.
    """
    if smooth:
        ends, bubble = [[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]], [0, 0, 1, -2, 1]
    else:
        ends, bubble = [[1, -1], [0, 1]], [0, 1, -1]
    per_node, more, m = len(ends) // 2, degree + 1 - len(ends), nodes.size
    legendre = (Legendre.basis(k).convert(kind=Polynomial)(Polynomial([-1, 2])) for k in range(more))
    shapes = [*map(Polynomial, ends), *(Polynomial(bubble) * one for one in legendre)]
    out = np.zeros((3, m - 1, places.size, per_node * m + more * (m - 1)))
    for i, h in enumerate(np.diff(nodes)):
        own = [
            *range(per_node * i, per_node * (i + 2)),
            *range(per_node * m + more * i, per_node * m + more * (i + 1)),
        ]
        scale = np.ones(len(shapes))
        if smooth:
            scale[[1, 3]] = h
        for k in range(3):
            values = [f.deriv(k)(places) if k else f(places) for f in shapes]
            out[k, i][:, own] = scale * np.array(values).T / h**k
    return out.reshape(3, -1, out.shape[-1])


def weighted(values, measure):
    """Integrals of all products of functions, by their values at the points of quadrature."""
    return values.T @ (measure[:, None] * values)


def ends_first(fields, nodes, *matrices):
    """The matrices, the ends of the rope first; ``fields``: coordinates of a node, and of all."""
    last, first, starts, ends = nodes.size - 1, 0, [], []
    for per_node, size in fields:
        starts += range(first, first + per_node)
        ends += range(first + per_node * last, first + per_node * (last + 1))
        first += size
    order = [*starts, *ends, *sorted({*range(first)} - {*starts, *ends})]
    return tuple(own[np.ix_(order, order)] for own in matrices)


def with_ropes(mass, stiffness, ropes, coordinates, *, elements, degree):
    """Mass and stiffness of a network with ropes; ``coordinates``: how many of them come first."""
    for rope in ropes:
        m, k = rope.matrices(elements, degree)
        ends = rope.rows.shape[0]
        for _ in range(rope.ropes):
            size, more = mass.shape[0], m.shape[0] - ends
            mass, stiffness = (np.pad(own, (0, more)) for own in (mass, stiffness))
            at = np.concatenate((np.arange(coordinates), np.arange(size, size + more)))
            rows = np.zeros((m.shape[0], at.size))
            rows[:ends, :coordinates] = rope.rows
            rows[ends:, coordinates:] = np.eye(more)
            mass[np.ix_(at, at)] += rows.T @ m @ rows
            stiffness[np.ix_(at, at)] += rows.T @ k @ rows
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
