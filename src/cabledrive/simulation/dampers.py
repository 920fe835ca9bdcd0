r"""Axial dampers of ropes that are straight but for small slopes: what of their equations never changes.

A damper :math:`\beta = b(1+\varepsilon_0)/h` in each segment acts on the mean speeds V over a step, which its
tension q itself changes: with the directions d of the segments

.. math:: \frac{q_i}{\beta_i} = d_{i+1/2}\cdot(V_{i+1} - V_i), \qquad
          V_i = V_i^* + \tfrac{g_i}{2}(q_i d_{i+1/2} - q_{i-1} d_{i-1/2}), \qquad g = \Delta t/m.

Where :math:`|d| = 1`, the matrix S of q differs from that of a straight rope by
:math:`1 - \cos` of the angles between neighbours alone. It is taken for one: eliminated once, from both ends
of a piece to its middle; directions of the rates and of the tensions stay those of the moving rope.
"""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.arrays import Integers

STIFFEST = 500.0
"""Largest eigenvalue of the dampers over a step up to which the matrix of the straight rope is taken."""
TINY = 1e-20
"""Answers below this share are none: nothing is left of them in a sum."""
UNDAMPED, AS_STRAIGHT, AS_BENT = range(3)
"""How segments are damped where they point: not, with the matrix of straight ropes, or with their own."""
BEFORE, BEHIND, INVERSE, TO_START, TO_END = range(5)
"""Rows of the table of the dampers."""


class Dampers(NamedTuple):
    """The eliminated matrices of all pieces, and what they do to the coordinates."""

    # (5, nodes - 1): shares of the elimination of the segment before, up to the middle, and of that behind,
    # from there on; 1 / pivot; answers to unit rates of the first and of the last segment [N s/m]
    table: Array
    loss: Array  # (n, n): of the coordinates' speeds [N s/m]
    stiffest: float  # largest eigenvalue of the dampers over a step; negative where nothing is damped

    def how(self, *, exact: bool) -> int:
        """How segments are damped under the exact law, or under another."""
        if self.stiffest < 0.0:
            return UNDAMPED
        return AS_STRAIGHT if exact and self.stiffest <= STIFFEST else AS_BENT


def eliminated(nodes: Integers, compliance: Array, kick: Array, ropes: Array, ends: Array) -> Dampers:
    """Eliminate the dampers of all pieces.

    ``compliance``, (nodes - 1,): h over b (1 + eps0) [m/s / N], 0 where nothing is damped; ``kick``,
    (nodes,): speed gained along u per force over a step; ``ends``, (pieces, 2, n): motion of both ends along.
    """
    from scipy.linalg import solveh_banded

    table, loss, stiffest = np.zeros((5, compliance.size)), np.zeros((ends.shape[-1],) * 2), -1.0
    for (first, last), count, (start, end) in zip(nodes, ropes, ends, strict=True):
        if compliance[first] == 0.0:
            continue
        half = 0.5 * kick[first : last + 1]
        half[[0, -1]] = 0.0
        pivot = compliance[first:last] + half[:-1] + half[1:]
        stiffest = max(stiffest, float((4.0 * (half[:-1] + half[1:]) / compliance[first:last]).max()))
        own, units = table[:, first:last], np.zeros((2, last - first))
        units[0, 0] = units[1, -1] = 1.0
        bands = np.stack([np.append(0.0, -half[1:-1]), pivot])
        answers = solveh_banded(bands, units.T).T if last - first > 1 else units / pivot
        own[TO_START:] = np.where(np.abs(answers) < TINY * np.abs(answers).max(), 0.0, answers)
        size, middle = last - first, (last - first - 1) // 2
        for i in range(1, middle + 1):
            own[BEFORE, i] = half[i] / pivot[i - 1]
            pivot[i] -= own[BEFORE, i] * half[i]
        for i in range(size - 2, middle - 1, -1):
            own[BEHIND, i] = half[i + 1] / pivot[i + 1]
            pivot[i] -= own[BEHIND, i] * half[i + 1]
        own[INVERSE] = 1.0 / pivot
        first_row = own[TO_END, 0] * end - own[TO_START, 0] * start
        last_row = own[TO_END, -1] * end - own[TO_START, -1] * start
        loss += count * (np.outer(end, last_row) - np.outer(start, first_row))
    return Dampers(table, loss, stiffest)
