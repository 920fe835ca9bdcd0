"""Kernels along a planned motion: coefficients change from step to step, frequencies stay exact.

A leapfrog step with the stiffness 4 sin^2(w h / 2) / h^2 in place of w^2 turns by exactly w h.
"""

# mypy: allow-untyped-defs

import numpy as np

from cabledrive.mechanics.compiled import njit


@njit
def exact_stiffness(squared, h):
    """Stiffness with which a leapfrog of step h turns at the frequency of `squared`; negative ones stay."""
    if squared <= 0.0:
        return squared
    half = 0.5 * h * np.sqrt(squared)
    return (2.0 * np.sin(half) / h) ** 2


@njit
def transitions(across, lift, q, gamma, h, edges, out):
    """Transition matrices of Eq. (A.32) from edge to edge, of (a, rate / w), shape (edges - 1, 2, 2)."""
    loss = 0.5 * h * gamma
    for block in range(edges.size - 1):
        w0, w1 = across[edges[block]], across[edges[block + 1] - 1]
        for column in range(2):
            a = 1.0 if column == 0 else 0.0
            b = 0.0 if column == 0 else w0
            for n in range(edges[block], edges[block + 1]):
                stiff = exact_stiffness(across[n] ** 2 + lift[n] * q[n], h)
                b = ((1.0 - loss) * b - h * stiff * a) / (1.0 + loss)
                a += h * b
            out[block, 0, column] = a
            out[block, 1, column] = b / w1
