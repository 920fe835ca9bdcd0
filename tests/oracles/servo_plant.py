"""Motion of a row of inertias with friction that sticks, Stribeck's excess and backlash, in its own words.

Compiled for the length of its logs; its text shares nothing with the integration of `cabledrive.reduction`.
"""

from math import copysign, exp, tanh
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit

Array = NDArray[np.float64]
HALVINGS, MOST_TURNS = 44, 24


class Row(NamedTuple):
    """Inertias of a row, every field of shape (n,), of the links after them (n - 1,).

    ``excess``, ``fading``: friction at rest above the Coulomb friction [N m]; speed at which it has fallen to
    1/e [rad/s]; ``slope``: K of c tanh(K w) [s/rad]; 0: the inertia sticks; ``stiffness``, ``damping``,
    ``gap``: of the links; backlash from end to end [rad]; ``near``, ``far``: stretch of a link per angle of
    its first and of its second inertia.
    """

    inertia: Array
    viscous: Array
    coulomb: Array
    offset: Array
    excess: Array
    fading: Array
    slope: Array
    stiffness: Array
    damping: Array
    gap: Array
    near: Array
    far: Array


@njit
def torques(row: Row, x: Array, u: float) -> Array:
    """On every inertia, without friction that sticks; ``x``: angles, then speeds; ``u``: on the first."""
    n = row.inertia.size
    found = row.offset - row.viscous * x[n:]
    found[0] += u
    for i in range(n - 1):
        stretch = row.near[i] * x[i] - row.far[i] * x[i + 1]
        rate = row.near[i] * x[n + i] - row.far[i] * x[n + i + 1]
        if row.gap[i] > 0.0:
            half = 0.5 * row.gap[i]
            if abs(stretch) <= half:
                continue
            stretch -= copysign(half, stretch)
        force = row.stiffness[i] * stretch + row.damping[i] * rate
        if row.gap[i] > 0.0 and force * stretch < 0.0:
            continue  # the flanks of a gear push and never pull
        found[i] -= row.near[i] * force
        found[i + 1] += row.far[i] * force
    return found


@njit
def rates(row: Row, x: Array, ways: Array, u: float) -> Array:
    """Of angles and speeds; ``ways``: of every inertia 1, -1, or 0 where it sticks."""
    n = row.inertia.size
    found, load = np.zeros(2 * n), torques(row, x, u)
    found[:n] = x[n:]
    for i in range(n):
        if row.slope[i] > 0.0:
            friction = row.coulomb[i] * tanh(row.slope[i] * x[n + i])
        else:
            fallen = exp(-((x[n + i] / row.fading[i]) ** 2)) if row.excess[i] > 0.0 else 0.0
            friction = ways[i] * (row.coulomb[i] + row.excess[i] * fallen)
        found[n + i] = (load[i] - friction) / row.inertia[i] if ways[i] != 0.0 else 0.0
    return found


@njit
def later(row: Row, x: Array, ways: Array, u0: float, u1: float, h: float) -> Array:
    """State after a step of Runge and Kutta under a torque on a straight line."""
    middle = 0.5 * (u0 + u1)
    one = rates(row, x, ways, u0)
    two = rates(row, x + 0.5 * h * one, ways, middle)
    three = rates(row, x + 0.5 * h * two, ways, middle)
    four = rates(row, x + h * three, ways, u1)
    return x + h / 6.0 * (one + 2.0 * two + 2.0 * three + four)


@njit
def sticks(row: Row, i: int) -> bool:
    """Whether an inertia has friction that holds it at rest."""
    return row.slope[i] == 0.0 and row.coulomb[i] + row.excess[i] > 0.0


@njit
def turned(row: Row, x: Array, ways: Array) -> bool:
    """Whether an inertia that slips has passed its rest."""
    n, found = row.inertia.size, False
    for i in range(n):
        found = found or (sticks(row, i) and ways[i] * x[n + i] < 0.0)
    return found


@njit
def ways_of(row: Row, x: Array, ways: Array, u: float) -> None:
    """Let go every inertia at rest whose load exceeds its friction, and hold the others; ``ways`` changes."""
    n, load = row.inertia.size, torques(row, x, u)
    for i in range(n):
        if not sticks(row, i):
            ways[i] = 1.0
        elif x[n + i] == 0.0:
            held = abs(load[i]) <= row.coulomb[i] + row.excess[i]
            ways[i] = 0.0 if held else copysign(1.0, load[i])


@njit
def moved(row: Row, x: Array, ways: Array, u0: float, u1: float, h: float) -> Array:
    """State after a step in which inertias may stop, stick and let go; ``ways`` changes with them."""
    n, done = row.inertia.size, 0.0
    for _ in range(MOST_TURNS):
        start = u0 + (u1 - u0) * done / h
        ways_of(row, x, ways, start)
        there = later(row, x, ways, start, u1, h - done)
        if not turned(row, there, ways):
            return there
        early, late = 0.0, h - done
        for _ in range(HALVINGS):
            part = 0.5 * (early + late)
            end = start + (u1 - start) * part / (h - done)
            there = later(row, x, ways, start, end, part)
            if turned(row, there, ways):
                late = part
            else:
                early = part
        end = start + (u1 - start) * late / (h - done)
        x = later(row, x, ways, start, end, late)
        for i in range(n):
            if sticks(row, i) and ways[i] * x[n + i] < 0.0:
                x[n + i] = 0.0
        done += late
        if done >= h * (1.0 - 1e-12):
            ways_of(row, x, ways, u1)
            return x
    return x
