r"""Axial damping of the spans of a network, implicit: a damping tension per segment, tridiagonal in a piece.

A damper :math:`\beta = b(1+\varepsilon_0)/h` in each segment acts along the straight span on the mean speeds
V over the step, which its tension q itself changes: :math:`q_i/\beta = V_{i+1} - V_i`,
:math:`V_i = V_i^* + \tfrac{g}{2} (q_i - q_{i-1})`, :math:`g = \Delta t/m`. The speeds of the ends are left
open, :math:`q = q_0 + q_a V_a + q_b V_b`; what :math:`q_a, q_b` do to the coordinates is a constant matrix.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.network.mesh import NetworkMesh


@dataclass(frozen=True, kw_only=True, eq=False)
class AxialDampers:
    """Constant parts of the damping tensions."""

    compliance: Array  # (pieces,): 1 / beta of a segment [m/s/N]; 0 where no rope is damped
    pivot: Array  # (nodes - 1,): pivots of the elimination
    start: Array  # (nodes - 1,): damping tension per speed of the start [N s/m]
    end: Array  # (nodes - 1,): per speed of the end [N s/m]
    matrix: Array  # (n, n): what they do to the coordinates, as dampers


def axial_dampers(mesh: NetworkMesh, step: float) -> AxialDampers:
    """The dampers of all pieces; ``step`` [s]."""
    from scipy.linalg import solveh_banded

    size = mesh.size - 1
    pivot, start, end = np.ones(size), np.zeros(size), np.zeros(size)
    matrix = np.zeros_like(mesh.mass)
    compliance = np.zeros(len(mesh.length))
    for k, (first, last) in enumerate(mesh.nodes):
        damping = float(mesh.axial_damping[k]) * (1.0 + float(mesh.tension[k] / mesh.rigidity[k]))
        if damping == 0.0:
            continue
        h, here = float(mesh.spacing[k]), slice(first, last)
        compliance[k] = h / damping
        half = 0.5 * step / float(mesh.density[k] * h)
        diagonal = np.full(last - first, compliance[k] + 2.0 * half)
        diagonal[0] -= half  # the ends are no nodes of the piece's own
        diagonal[-1] -= half
        pivot[here] = _pivots(diagonal, half)
        sides = np.zeros((last - first, 2))
        sides[0, 0], sides[-1, 1] = -1.0, 1.0
        bands = np.stack([np.append(0.0, np.full(last - first - 1, -half)), diagonal])
        solved = solveh_banded(bands, sides) if last - first > 1 else sides / diagonal[:, None]
        start[here], end[here] = solved.T
        a, b = mesh.ends[k, 0, 0], mesh.ends[k, 1, 0]
        first_row = start[first] * a + end[first] * b
        last_row = start[last - 1] * a + end[last - 1] * b
        matrix += mesh.ropes[k] * (np.outer(b, last_row) - np.outer(a, first_row))
    return AxialDampers(compliance=compliance, pivot=pivot, start=start, end=end, matrix=matrix)


def _pivots(diagonal: Array, half: float) -> Array:
    """Pivots of the tridiagonal matrix with this diagonal and -half beside it."""
    found = diagonal.copy()
    for i in range(1, found.size):
        found[i] -= half * half / found[i - 1]
    return found
