"""Lanczos' recursion on distinct squares of frequencies, and the chain of inertias and springs it gives."""

import numpy as np

from cabledrive.parameters.arrays import Array


def lanczos(squares: Array, start: Array) -> tuple[Array, Array, Array]:
    """Tridiagonal matrix of distinct squares begun with a row: diagonal, off-diagonal, rows of the basis."""
    n = squares.size
    alpha, beta, basis = np.zeros(n), np.zeros(n - 1), np.zeros((n, n))
    basis[0] = start / np.linalg.norm(start)
    for i in range(n):
        alpha[i] = basis[i] @ (squares * basis[i])
        if i == n - 1:
            break
        rest = squares * basis[i]
        for _ in range(2):  # twice is enough for full orthogonality
            rest = rest - basis[: i + 1].T @ (basis[: i + 1] @ rest)
        beta[i] = np.linalg.norm(rest)
        basis[i + 1] = -rest / beta[i]  # minus: a positive spring pulls neighbours together
    return alpha, beta, basis


def chain_numbers(alpha: Array, beta: Array, start: Array) -> tuple[Array, Array, float]:
    """Inertias, springs, and the spring left over at the end."""
    inertias, stiffness, before = [1.0 / float(start @ start)], [], 0.0
    for i, off in enumerate(beta):
        link = alpha[i] * inertias[i] - before
        stiffness.append(link)
        inertias.append(link**2 / (off**2 * inertias[i]))
        before = link
    return np.array(inertias), np.array(stiffness), float(alpha[-1] * inertias[-1] - before)
