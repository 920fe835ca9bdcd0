"""A hanging elastic cable in its plane, divided into straight elements about its exact state of rest."""

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import fsolve

GAUSS = np.polynomial.legendre.leggauss(8)


def shape_at_rest(rigidity, weight, chord, pull, elements):
    """Nodes, shape (m, 2), unstretched length, and forces at the middle of the elements.

    ``weight``: vector per unstretched length; ``chord``: vector from start to end; ``pull``: force along the
    chord at the start. By integration of dr/ds = F/|F| (1 + |F|/EA), F = F0 - weight s.
    """
    along = chord / np.hypot(*chord)
    across = np.array([-along[1], along[0]])

    def steps(unknown):
        v, length = unknown
        ends = length * np.arange(elements + 1) / elements
        s = ends[:-1, None] + length / elements * (1 + GAUSS[0]) / 2
        force = (pull * along + v * across)[:, None, None] - weight[:, None, None] * s
        size = np.hypot(*force)
        slope = force / size * (1 + size / rigidity)
        return length / elements * (slope @ (GAUSS[1] / 2)), length

    def miss(unknown):
        step, _ = steps(unknown)
        return (step.sum(axis=1) - chord) / np.hypot(*chord)

    size = np.hypot(*chord)
    found = fsolve(miss, [0.5 * weight @ across * size, size / (1 + pull / rigidity)], xtol=1e-13)
    step, length = steps(found)
    middle = length * (np.arange(elements) + 0.5) / elements
    force = (pull * along + found[0] * across)[:, None] - weight[:, None] * middle
    ends = [pull * along + found[0] * across - weight * s for s in (0.0, length)]
    return np.vstack((np.zeros(2), np.cumsum(step.T, axis=0))), length, np.hypot(*force), ends


def frequencies(rigidity, density, gravity, chord, pull, elements, wheel=None):
    """Natural frequencies [Hz]; both ends held, or the end on a wheel: (mass at its rim, ) that turns."""
    nodes, length, tension, ends = shape_at_rest(rigidity, density * gravity, chord, pull, elements)
    part = length / elements
    n = 2 * (elements + 1)
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    one = np.eye(2)
    for i in range(elements):
        d = nodes[i + 1] - nodes[i]
        size = np.hypot(*d)
        t = np.outer(d, d) / size**2
        block = rigidity / part * t + tension[i] / size * (one - t)
        at = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        stiffness[at] += np.block([[block, -block], [-block, block]])
        mass[at] += density * part / 6 * np.block([[2 * one, one], [one, 2 * one]])
    rows = np.zeros((n, n - 4 + (wheel is not None)))
    rows[2:-2, : n - 4] = np.eye(n - 4)
    if wheel is not None:
        rows[-2:, -1] = ends[1] / np.hypot(*ends[1])
    mass, stiffness = rows.T @ mass @ rows, rows.T @ stiffness @ rows
    if wheel is not None:
        mass[-1, -1] += wheel
    return np.sqrt(np.maximum(eigh(stiffness, mass, eigvals_only=True), 0)) / (2 * np.pi)


def extrapolated(*args, elements, count, **options):
    """The first frequencies, the error of second order taken out."""
    coarse, fine = (frequencies(*args, m, **options)[:count] for m in (elements, 2 * elements))
    return (4 * fine - coarse) / 3
