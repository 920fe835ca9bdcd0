"""Natural frequencies as the dissertation finds them: from changes of sign of a determinant."""

from collections.abc import Callable
from math import pi

import numpy as np
from scipy.optimize import brentq

import cabledrive as cd

Determinant = Callable[[float], float]
COARSEST, FINEST = 64, 2**20


def modal_determinant(drive: cd.Drive) -> Determinant:
    """Determinant of the modal matrix of a loop with any carriages, as (3.13), (3.20) and (3.38).

    Unknowns a, b of each segment; one row of force balance and one of continuity for each joint.
    """
    length = drive.span_length
    speed = np.sqrt(drive.cable.axial_rigidity / drive.cable.mass_per_length)
    impedance = drive.cable.mass_per_length * speed
    upper, lower = drive.carriages_on("upper"), drive.carriages_on("lower")
    places = [0.0, *(c.position for c in upper), length, *(length + c.position for c in lower), 2 * length]
    times = np.diff(places) / speed
    rims = [pulley.rim_mass for pulley in drive.pulley]
    masses = np.array([rims[0], *(c.mass for c in upper), rims[1], *(c.mass for c in lower)]) / impedance
    n = times.size
    joints, before = np.arange(n), np.roll(np.arange(n), 1)

    def determinant(omega: float) -> float:
        sine, cosine = np.sin(omega * times[before]), np.cos(omega * times[before])
        matrix = np.zeros((2 * n, 2 * n))
        matrix[joints, before] += sine  # force: b + a_before sin - b_before cos + omega m a = 0
        matrix[joints, joints] += omega * masses
        matrix[joints, n + before] -= cosine
        matrix[joints, n + joints] += 1.0
        matrix[n + joints, before] -= cosine  # continuity: a = a_before cos + b_before sin
        matrix[n + joints, joints] += 1.0
        matrix[n + joints, n + before] -= sine
        return np.linalg.det(matrix)

    return determinant


def scan(determinant: Determinant, top: float, points: int) -> np.ndarray:
    """Roots between changes of sign on a grid, each by Brent's method, as fzero does; frequencies [Hz]."""
    grid = np.linspace(top / points, top, points)
    sign = np.sign([determinant(omega) for omega in grid])
    changes = np.flatnonzero(sign[:-1] * sign[1:] < 0)
    roots = [brentq(determinant, grid[i], grid[i + 1], xtol=1e-12 * top, rtol=1e-14) for i in changes]
    return np.array(roots) / (2 * pi)


def fine_enough(frequencies: np.ndarray, top: float) -> int:
    """Points of a grid with two in the smallest gap: a choice that takes the answer, so that no luck is needed."""
    gap = np.min(np.diff(frequencies))
    return int(np.ceil(2 * top / (2 * pi * gap)))


def halved_until_settled(determinant: Determinant, top: float) -> tuple[np.ndarray, int]:
    """Scan with grids halved until a halving adds nothing: what one does who does not know the answer."""
    points, before = COARSEST, np.empty(0)
    while points <= FINEST:
        found = scan(determinant, top, points)
        if found.size and found.size == before.size:
            break
        points, before = 2 * points, found
    return found, points
