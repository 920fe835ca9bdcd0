"""A loop as a mesh of finite elements with scipy's sparse eigensolver, shift and invert at zero."""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh

from cabledrive.mechanics.chain import Chain

# Stiffness times l/R and mass over rho l of an element: two nodes, or three (the middle one last).
ELEMENTS = {
    1: (np.array([[1, -1], [-1, 1]]), np.array([[2, 1], [1, 2]]) / 6),
    2: (
        np.array([[7, 1, -8], [1, 7, -8], [-8, -8, 16]]) / 3,
        np.array([[4, -1, 2], [-1, 4, 2], [2, 2, 16]]) / 30,
    ),
}


def mesh(ring: Chain, elements: int, degree: int) -> tuple[sparse.csc_matrix, sparse.csc_matrix]:
    """Stiffness and mass of a ring with about so many elements, shared out by length, one at least."""
    shares = np.maximum(1, np.rint(elements * ring.lengths / ring.lengths.sum())).astype(int)
    lengths = np.repeat(ring.lengths / shares, shares)
    joints = np.concatenate(([0], np.cumsum(shares)[:-1]))
    n = lengths.size
    nodes = [np.arange(n), (np.arange(n) + 1) % n, n + np.arange(n)][: degree + 1]
    size = n * degree
    stiffness, mass = (_assembled(part, nodes, size) for part in _parts(ring, lengths, degree))
    carried = np.zeros(size)
    carried[joints] = ring.masses
    return stiffness, (mass + sparse.diags(carried)).tocsc()


def _parts(ring: Chain, lengths: np.ndarray, degree: int):
    stiffness, mass = ELEMENTS[degree]
    yield stiffness[:, :, None] * ring.rigidity / lengths
    yield mass[:, :, None] * ring.density * lengths


def _assembled(values: np.ndarray, nodes: list[np.ndarray], size: int) -> sparse.csc_matrix:
    rows = np.broadcast_to(np.array(nodes)[:, None], values.shape)
    columns = np.broadcast_to(np.array(nodes)[None], values.shape)
    entries = values.ravel(), (rows.ravel(), columns.ravel())
    return sparse.coo_matrix(entries, shape=(size, size)).tocsc()


def frequencies(ring: Chain, modes: int, elements: int, degree: int, shift: float) -> np.ndarray:
    """The first frequencies [Hz], no rigid-body mode; `shift` below zero keeps the factors regular."""
    stiffness, mass = mesh(ring, elements, degree)
    start = np.cos(np.arange(stiffness.shape[0]))
    squares = eigsh(stiffness, modes + 1, mass, sigma=shift, v0=start, return_eigenvectors=False)
    return np.sqrt(np.sort(squares)[1:]) / (2 * np.pi)
