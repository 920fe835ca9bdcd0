"""Modes below a frequency by the formula itself: eigenvalues of the matrix of a chain, Eq. (M.5)."""

import numpy as np


def modes_below(chain, omega):
    """Rigid-body mode included; K/omega of a segment is Z (cot, -1/sin), a held end is struck out."""
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
