"""A rope that sags, stretched by c u' + s w', turned by c w' - s u', by finite elements of high order.

No condensation, no modes between held ends: every polynomial is a coordinate of the machine.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, Polynomial

from oracles.beam_fem import nodes_of, shape_functions


@dataclass(frozen=True)
class HangingRope:
    """Rows of the motion of its start, then of its end: along, across and, with EI, slope.

    ``length`` and ``bending`` under tension, ``density`` and ``rigidity`` per unstretched length; ``load``
    across per length, ``shear`` at the start; ``begin``: where it starts, from the place of that
    shear; ``span``: the length over which its tension changes; ``along``: its length where it is stretched.
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
    begin: float = 0.0
    span: float | None = None
    along: float | None = None

    def tension_at(self, x):
        """Tension at a place from its start."""
        share = (x + self.begin) / (self.span or self.length)
        return self.tension[0] + (self.tension[1] - self.tension[0]) * share

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
        return (self.shear - self.load * (x + self.begin)) / self.tension_at(x)


def shear_between(tension, load, length):
    """Shear at the start of a rope whose ends lie on its chord, by a fine trapezium rule."""
    x = np.linspace(0.0, length, 200_001)
    pull = tension[0] + (tension[1] - tension[0]) * x / length
    return load * np.trapezoid(x / pull, x) / np.trapezoid(1.0 / pull, x)


def basis(nodes, degree, smooth, places):
    """Values, slopes and curvatures of a field's functions at places of each element.

    Returns three arrays, shape (elements, places, n): displacement (and slope) of the nodes first.
    """
    per_node = 2 if smooth else 1
    shapes = shape_functions(degree) if smooth else [Polynomial([1, -1]), Polynomial([0, 1])]
    if not smooth:
        bubble = Polynomial([0, 1, -1])
        legendre = (Legendre.basis(k).convert(kind=Polynomial) for k in range(degree - 1))
        shapes += [bubble * one(Polynomial([-1, 2])) for one in legendre]
    more, m = len(shapes) - 2 * per_node, nodes.size
    size = per_node * m + more * (m - 1)
    out = np.zeros((3, m - 1, places.size, size))
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
    return out


def hanging_matrices(rope, elements, degree):
    """Mass and stiffness of one rope; the motions of its ends first, as in its rows."""
    nodes, (x, weights) = nodes_of(rope_as_beam(rope), elements), np.polynomial.legendre.leggauss(degree + 6)
    x, weights = (1 + x) / 2, weights / 2
    u = basis(nodes, degree, False, x)
    w = basis(nodes, degree, rope.bending > 0, x)
    h = np.diff(nodes)[:, None]
    place = nodes[:-1, None] + h * x
    measure = (h * weights).ravel()
    (u0, u1, _), (w0, w1, w2) = ([one.reshape(-1, one.shape[-1]) for one in field] for field in (u, w))
    slope, tension = rope.slope(place).ravel(), rope.taut_at(place).ravel()
    longer = rope.length / (rope.along or rope.length)
    cosine, sine = 1.0 / np.sqrt(1.0 + slope**2), slope / np.sqrt(1.0 + slope**2)
    stretch = np.hstack((cosine[:, None] * u1, sine[:, None] * w1))
    none = np.zeros_like(u0)
    mass = (rope.density / rope.stretch) * (
        np.hstack((u0, 0 * w0)).T @ (measure[:, None] / longer * np.hstack((u0, 0 * w0)))
        + np.hstack((none, w0)).T @ (measure[:, None] * np.hstack((none, w0)))
    )
    stiffness = stretch.T @ (measure[:, None] * rope.rigidity * rope.stretch * longer * stretch)
    turn, bend = np.hstack((-sine[:, None] * u1, cosine[:, None] * w1)), np.hstack((none, w2))
    stiffness += turn.T @ ((measure * tension)[:, None] * turn) + rope.bending * bend.T @ (
        measure[:, None] * bend
    )
    m, k = nodes.size, 2 if rope.bending else 1
    first = u0.shape[1]
    ends = [0, *range(first, first + k), m - 1, *range(first + k * (m - 1), first + k * m)]
    order = [*ends, *(i for i in range(mass.shape[0]) if i not in ends)]
    return mass[np.ix_(order, order)], stiffness[np.ix_(order, order)]


def rope_as_beam(rope):
    """What the choice of nodes looks at."""
    from oracles.beam_fem import Beam

    return Beam(np.zeros((4, 0)), rope.length, rope.density, rope.bending, rope.tension)


def with_hanging(mass, stiffness, ropes, coordinates, *, elements, degree):
    """Mass and stiffness of a network with hanging ropes; ``coordinates``: how many of them come first."""
    for rope in ropes:
        m, k = hanging_matrices(rope, elements, degree)
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
