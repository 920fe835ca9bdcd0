"""Compiled motion of a lumped chain with set-valued friction, and its exact sensitivities.

Between events the chain is smooth and one Runge-Kutta step of order 4 carries state and sensitivities. An
inertia whose speed reaches zero is followed to that instant; there it sticks, or slips on the other way, and
the sensitivity of its speed jumps by the ratio of its accelerations after and before. One that sticks is
followed to the instant at which its load exceeds its friction. The readable door is
`cabledrive.reduction.friction_integration`.

A state is an array (2n, 1 + m): places, then speeds, in its first column, their sensitivities to m parameters
in the others.
"""

from math import exp, tanh
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.compiled import njit, njit_inner
from cabledrive.parameters.arrays import Array, Integers


class ChainNumbers(NamedTuple):
    """The chain in few arrays, since every array costs at every call; what varies, in which directions.

    ``body`` has a column per inertia and the rows INERTIA to SLOPE, ``link`` a column per link and the rows
    STIFFNESS to Q. ``directions`` has one column per parameter; rows: inertia, viscous, coulomb, offset,
    gain (n each), stiffness, damping (n - 1 each), initial angle, initial speed (n each).
    """

    body: Array
    link: Array
    directions: Array


INERTIA, VISCOUS, COULOMB, OFFSET, GAIN, EXCESS, FADING, SLOPE = range(8)
STIFFNESS, DAMPING, GAP, P, Q = range(5)


@njit_inner
def link_force(c: ChainNumbers, j: int, x: Array) -> tuple[float, float]:
    """Force of link j: stretch beyond the gap times stiffness, and damping while it is in contact."""
    n = c.body.shape[1]
    stretch = c.link[P, j] * x[j, 0] - c.link[Q, j] * x[j + 1, 0]
    rate = c.link[P, j] * x[n + j, 0] - c.link[Q, j] * x[n + j + 1, 0]
    half = 0.5 * c.link[GAP, j]
    if half > 0.0:
        if abs(stretch) <= half:
            return 0.0, 0.0
        beyond = stretch - half if stretch > 0.0 else stretch + half
        force = c.link[STIFFNESS, j] * beyond + c.link[DAMPING, j] * rate
        if force * beyond <= 0.0:
            return 0.0, 0.0
        return force, beyond
    return c.link[STIFFNESS, j] * stretch + c.link[DAMPING, j] * rate, stretch


@njit_inner
def load_on(c: ChainNumbers, i: int, x: Array, u: float) -> float:
    """Torque on inertia i without its Coulomb friction."""
    n = c.body.shape[1]
    load = c.body[GAIN, i] * u + c.body[OFFSET, i] - c.body[VISCOUS, i] * x[n + i, 0]
    if i < n - 1:
        load -= c.link[P, i] * link_force(c, i, x)[0]
    if i > 0:
        load += c.link[Q, i - 1] * link_force(c, i - 1, x)[0]
    return load


@njit_inner
def coulomb_of(c: ChainNumbers, i: int, speed: float, slip: int) -> float:
    """Coulomb friction of inertia i that slips in direction ``slip``."""
    if c.body[SLOPE, i] > 0.0:
        return c.body[COULOMB, i] * tanh(c.body[SLOPE, i] * speed)
    friction = c.body[COULOMB, i]
    if c.body[EXCESS, i] != 0.0:
        friction += c.body[EXCESS, i] * exp(-((speed / c.body[FADING, i]) ** 2))
    return slip * friction


@njit_inner
def derivative(c: ChainNumbers, x: Array, slip: Integers, u: float, rate: Array) -> None:
    """Rates of a state."""
    n = c.body.shape[1]
    for i in range(n):
        for k in range(x.shape[1]):
            rate[i, k] = x[n + i, k]
            rate[n + i, k] = 0.0
        if slip[i] == 0:
            continue
        speed, inertia, slope = x[n + i, 0], c.body[INERTIA, i], c.body[SLOPE, i]
        acceleration = (load_on(c, i, x, u) - coulomb_of(c, i, speed, slip[i])) / inertia
        rate[n + i, 0] = acceleration
        # friction by its own size and by the speed
        level, fall = 1.0 * slip[i], c.body[VISCOUS, i]
        if slope > 0.0:
            level = tanh(slope * speed)
            fall += c.body[COULOMB, i] * slope * (1.0 - level * level)
        elif c.body[EXCESS, i] != 0.0:
            ratio = speed / c.body[FADING, i]
            fall -= level * c.body[EXCESS, i] * 2.0 * ratio / c.body[FADING, i] * exp(-ratio * ratio)
        for k in range(x.shape[1] - 1):
            force = c.directions[4 * n + i, k] * u + c.directions[3 * n + i, k]
            force -= c.directions[i, k] * acceleration + c.directions[n + i, k] * speed
            force -= c.directions[2 * n + i, k] * level + fall * x[n + i, 1 + k]
            if i < n - 1:
                force -= c.link[P, i] * link_sensitivity(c, i, x, k)
            if i > 0:
                force += c.link[Q, i - 1] * link_sensitivity(c, i - 1, x, k)
            rate[n + i, 1 + k] = force / inertia


@njit_inner
def link_sensitivity(c: ChainNumbers, j: int, x: Array, k: int) -> float:
    """Derivative of the force of link j by parameter k."""
    force, beyond = link_force(c, j, x)
    if beyond == 0.0 and force == 0.0 and c.link[GAP, j] > 0.0:
        return 0.0
    n, p, q = c.body.shape[1], c.link[P, j], c.link[Q, j]
    by_stiffness = c.directions[5 * n + j, k] * beyond
    by_damping = c.directions[6 * n - 1 + j, k] * (p * x[n + j, 0] - q * x[n + j + 1, 0])
    stretch = c.link[STIFFNESS, j] * (p * x[j, 1 + k] - q * x[j + 1, 1 + k])
    rate = c.link[DAMPING, j] * (p * x[n + j, 1 + k] - q * x[n + j + 1, 1 + k])
    return by_stiffness + by_damping + stretch + rate


@njit_inner
def runge_kutta(
    c: ChainNumbers, x: Array, slip: Integers, drive: tuple[float, float, float], end: Array, work: Array
) -> None:
    """One step of order 4 into ``end``; ``drive``: torque at its start and its end, its length [s]."""
    u0, u1, h = drive
    um = 0.5 * (u0 + u1)
    derivative(c, x, slip, u0, work[0])
    advance(x, 0.5 * h, work[0], work[4])
    derivative(c, work[4], slip, um, work[1])
    advance(x, 0.5 * h, work[1], work[4])
    derivative(c, work[4], slip, um, work[2])
    advance(x, h, work[2], work[4])
    derivative(c, work[4], slip, u1, work[3])
    for i in range(x.shape[0]):
        for k in range(x.shape[1]):
            inner = work[1, i, k] + work[2, i, k]
            end[i, k] = x[i, k] + h / 6.0 * (work[0, i, k] + 2.0 * inner + work[3, i, k])


@njit_inner
def advance(x: Array, part: float, rate: Array, end: Array) -> None:
    """State after a part of a step at given rates."""
    for i in range(x.shape[0]):
        for k in range(x.shape[1]):
            end[i, k] = x[i, k] + part * rate[i, k]


MOST_EVENTS = 24
CROSSING_STEPS = 12


@njit_inner
def reserve(c: ChainNumbers, i: int, x: Array, slip: Integers, u: float) -> float:
    """What is left before inertia i turns: its speed, or of one that sticks friction beyond its load."""
    if slip[i] != 0:
        return slip[i] * x[c.body.shape[1] + i, 0]
    return c.body[COULOMB, i] + c.body[EXCESS, i] - abs(load_on(c, i, x, u))


@njit_inner
def turn(c: ChainNumbers, x: Array, slip: Integers, i: int, u: float) -> None:
    """At zero speed of inertia i: stick, or slip on; the sensitivity of its speed jumps accordingly."""
    row = c.body.shape[1] + i
    x[row, 0] = 0.0
    load, most = load_on(c, i, x, u), c.body[COULOMB, i] + c.body[EXCESS, i]
    if slip[i] == 0:
        slip[i] = 1 if load > 0.0 else -1
        return
    before, after = load - slip[i] * most, 0.0
    if abs(load) <= most:
        slip[i] = 0
    else:
        slip[i] = 1 if load > 0.0 else -1
        after = load - slip[i] * most
    ratio = after / before if before != 0.0 else 0.0
    for k in range(1, x.shape[1]):
        x[row, k] *= ratio


@njit_inner
def step(
    c: ChainNumbers, x: Array, slip: Integers, drive: tuple[float, float, float], end: Array, work: Array
) -> None:
    """One step with all turns in it; the state and ``slip`` are moved on."""
    u0, u1, h = drive
    done = 0.0
    for _event in range(MOST_EVENTS):
        rest, ua = h - done, u0 + (u1 - u0) * done / h
        for i in range(slip.size):
            if slip[i] == 0 and reserve(c, i, x, slip, ua) < 0.0:
                turn(c, x, slip, i, ua)
        runge_kutta(c, x, slip, (ua, u1, rest), end, work)
        found, part, at_low, at_high = -1, 2.0, 0.0, 0.0
        for i in range(slip.size):  # the first that turns, by linear interpolation
            if c.body[SLOPE, i] == 0.0 and c.body[COULOMB, i] + c.body[EXCESS, i] > 0.0:
                before, after = reserve(c, i, x, slip, ua), reserve(c, i, end, slip, u1)
                if after < 0.0:
                    early = before / (before - after) if before > 0.0 else 0.0
                    if early < part:
                        found, part, at_low, at_high = i, early, before, after
        if found < 0:
            advance(end, 0.0, end, x)
            return
        low, high = 0.0, 1.0
        for _ in range(CROSSING_STEPS):
            ub = ua + (u1 - ua) * part
            runge_kutta(c, x, slip, (ua, ub, part * rest), end, work)
            value = reserve(c, found, end, slip, ub)
            if abs(value) <= 1e-12 * (abs(at_low) + abs(at_high)) or high - low < 1e-13:
                break
            if value > 0.0:
                low, at_low = part, value
                at_high *= 0.5
            else:
                high, at_high = part, value
                at_low *= 0.5
            within = at_low / (at_low - at_high) if at_low > at_high else 0.5
            part = low + (high - low) * within
        advance(end, 0.0, end, x)
        done += part * rest
        turn(c, x, slip, found, ua + (u1 - ua) * part)
        if done >= h * (1.0 - 1e-12):
            return


@njit
def integrate(
    c: ChainNumbers, torque: Array, x: Array, grid: tuple[float, int, float], states: Array
) -> None:
    """Carry the chain over all samples from the state ``x``; keeps it at each, (samples, 2n, 1 + m).

    ``grid``: interval of the samples [s]; steps in it; 0 for torque that stands from sample to sample, 1 for
    torque on straight lines between samples.
    """
    interval, substeps, hold = grid
    n = c.body.shape[1]
    end, work = np.empty_like(x), np.empty((5, *x.shape))
    slip = np.zeros(n, dtype=np.int64)
    for i in range(n):
        if c.body[SLOPE, i] > 0.0 or c.body[COULOMB, i] + c.body[EXCESS, i] <= 0.0:
            slip[i] = 1
        elif x[n + i, 0] != 0.0:
            slip[i] = 1 if x[n + i, 0] > 0.0 else -1
    for sample in range(torque.size):
        advance(x, 0.0, x, states[sample])
        if sample == torque.size - 1:
            break
        start = torque[sample]
        rise = (torque[sample + 1] - start) * hold
        for part in range(substeps):
            ends = start + rise * part / substeps, start + rise * (part + 1) / substeps
            step(c, x, slip, (ends[0], ends[1], interval / substeps), end, work)
