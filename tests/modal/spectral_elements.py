r"""Natural frequencies by spectral elements: Lobatto shape functions; no waves, dynamic stiffness or count.

Each segment carries the two linear functions and the integrals of the Legendre polynomials,
:math:`N_k(\xi) = (P_k(\xi) - P_{k-2}(\xi))/\sqrt{4k - 2}`, whose derivatives are orthonormal.
"""

from functools import cache

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

FEWEST, MORE = 12, 34  # degree of a short segment, and what the only segment of a chain has beyond it


@cache
def element(degree):
    """Stiffness and mass of the interval [-1, 1] for unit rigidity and density, each of order degree + 1."""
    nodes, weights = legendre.leggauss(degree + 2)
    p = legendre.legvander(nodes, degree)
    k = np.arange(2, degree + 1)
    ends = np.stack((1 - nodes, 1 + nodes), axis=1) / 2
    values = np.hstack((ends, (p[:, 2:] - p[:, :-2]) / np.sqrt(4 * k - 2)))
    slopes = np.hstack((np.full((nodes.size, 2), (-0.5, 0.5)), np.sqrt(k - 0.5) * p[:, 1:-1]))
    return slopes.T @ (weights[:, None] * slopes), values.T @ (weights[:, None] * values)


def frequencies(
    lengths,
    masses,
    rigidity,
    density,
    *,
    closed=False,
    fixed=(False, False),
    pendant=None,
    grounds=None,
    rotor_ground=0.0,
):
    """Angular frequencies, ascending, and how far round-off blurs each of them, relative.

    `fixed`: which of the first and last joint are held, or the numbers of held joints as a set. `pendant`:
    spring, mass and joint. `grounds`: springs from the joints to the ground; `rotor_ground`: the pendant's.
    """
    joints = len(masses)
    degrees = FEWEST + np.rint(MORE * np.asarray(lengths) / np.sum(lengths)).astype(int)
    inner = joints + np.concatenate(([0], np.cumsum(degrees - 1)))
    size = inner[-1] + (pendant is not None)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for i, (length, degree) in enumerate(zip(lengths, degrees, strict=True)):
        k, m = element(int(degree))
        here = np.ix_(*2 * [[i, (i + 1) % joints if closed else i + 1, *range(inner[i], inner[i + 1])]])
        stiffness[here] += k * rigidity * 2 / length
        mass[here] += m * density * length / 2
    mass[range(joints), range(joints)] += masses
    if pendant is not None:
        spring, own, joint = pendant
        stiffness[np.ix_(*2 * [[joint, size - 1]])] += spring * np.array([[1, -1], [-1, 1]])
        mass[-1, -1] = own
        stiffness[-1, -1] += rotor_ground
    if grounds is not None:
        stiffness[range(joints), range(joints)] += grounds
    ends = fixed if isinstance(fixed, tuple) else ()
    held = (
        sorted(fixed)
        if not ends
        else [j for j, is_held in zip((0, joints - 1), ends, strict=True) if is_held]
    )
    free = np.setdiff1d(np.arange(size), held)
    squares = eigh(stiffness[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)
    sprung = rotor_ground > 0.0 or (grounds is not None and np.any(grounds))
    squares = squares[0 if held or sprung else 1 :]
    return np.sqrt(squares), np.finfo(float).eps * squares[-1] / squares
