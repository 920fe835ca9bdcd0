"""Compiled motion of a lumped chain with set-valued friction, and its exact sensitivities.

Between events the chain is smooth and one Runge-Kutta step of order 4 carries state and sensitivities. An
inertia whose speed reaches zero is followed to that instant; there it sticks, or slips on the other way, and
the sensitivity of its speed jumps by the ratio of its accelerations after and before. The readable door is
`cabledrive.reduction.friction_integration`.
"""

from math import exp, tanh
from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Integers

Moved = tuple[Array, Array]
"""Places, then speeds (2n,), and their sensitivities (2n, m)."""
Work = tuple[Moved, Moved, Moved, Moved, Moved]


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


@njit
def link_force(c: ChainNumbers, j: int, x: Array, n: int) -> tuple[float, float]:
    """Force of link j: stretch beyond the gap times stiffness, and damping while it is in contact."""
    stretch = c.link[P, j] * x[j] - c.link[Q, j] * x[j + 1]
    rate = c.link[P, j] * x[n + j] - c.link[Q, j] * x[n + j + 1]
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


@njit
def load_on(c: ChainNumbers, i: int, x: Array, u: float, n: int) -> float:
    """Torque on inertia i without its Coulomb friction."""
    load = c.body[GAIN, i] * u + c.body[OFFSET, i] - c.body[VISCOUS, i] * x[n + i]
    if i < n - 1:
        load -= c.link[P, i] * link_force(c, i, x, n)[0]
    if i > 0:
        load += c.link[Q, i - 1] * link_force(c, i - 1, x, n)[0]
    return load


@njit
def coulomb_of(c: ChainNumbers, i: int, speed: float, slip: int) -> float:
    """Coulomb friction of inertia i that slips in direction ``slip``."""
    if c.body[SLOPE, i] > 0.0:
        return c.body[COULOMB, i] * tanh(c.body[SLOPE, i] * speed)
    friction = c.body[COULOMB, i]
    if c.body[EXCESS, i] != 0.0:
        friction += c.body[EXCESS, i] * exp(-((speed / c.body[FADING, i]) ** 2))
    return slip * friction


@njit
def derivative(c: ChainNumbers, now: Moved, slip: Integers, u: float, rates: Moved) -> None:
    """Rates of the state (2n,) and of its sensitivities (2n, m)."""
    (x, s), (dx, ds) = now, rates
    n = c.body.shape[1]
    m = s.shape[1]
    for i in range(n):
        dx[i] = x[n + i]
        for k in range(m):
            ds[i, k] = s[n + i, k]
        if slip[i] == 0:
            dx[n + i] = 0.0
            for k in range(m):
                ds[n + i, k] = 0.0
            continue
        speed = x[n + i]
        acceleration = (load_on(c, i, x, u, n) - coulomb_of(c, i, speed, slip[i])) / c.body[INERTIA, i]
        dx[n + i] = acceleration
        for k in range(m):
            force = c.directions[4 * n + i, k] * u + c.directions[3 * n + i, k]
            force -= c.directions[n + i, k] * speed + c.body[VISCOUS, i] * s[n + i, k]
            force -= c.directions[i, k] * acceleration
            if c.body[SLOPE, i] > 0.0:
                level = tanh(c.body[SLOPE, i] * speed)
                force -= c.directions[2 * n + i, k] * level
                force -= c.body[COULOMB, i] * c.body[SLOPE, i] * (1.0 - level * level) * s[n + i, k]
            else:
                force -= slip[i] * c.directions[2 * n + i, k]
                if c.body[EXCESS, i] != 0.0:
                    ratio = speed / c.body[FADING, i]
                    fall = -2.0 * ratio / c.body[FADING, i] * exp(-ratio * ratio)
                    force -= slip[i] * c.body[EXCESS, i] * fall * s[n + i, k]
            if i < n - 1:
                force -= c.link[P, i] * link_sensitivity(c, i, x, s, k, n)
            if i > 0:
                force += c.link[Q, i - 1] * link_sensitivity(c, i - 1, x, s, k, n)
            ds[n + i, k] = force / c.body[INERTIA, i]


@njit
def link_sensitivity(c: ChainNumbers, j: int, x: Array, s: Array, k: int, n: int) -> float:
    """Derivative of the force of link j by parameter k."""
    force, beyond = link_force(c, j, x, n)
    if beyond == 0.0 and force == 0.0 and c.link[GAP, j] > 0.0:
        return 0.0
    rate = c.link[P, j] * x[n + j] - c.link[Q, j] * x[n + j + 1]
    stretch_s = c.link[P, j] * s[j, k] - c.link[Q, j] * s[j + 1, k]
    rate_s = c.link[P, j] * s[n + j, k] - c.link[Q, j] * s[n + j + 1, k]
    by_stiffness = c.directions[5 * n + j, k] * beyond
    by_damping = c.directions[6 * n - 1 + j, k] * rate
    return by_stiffness + by_damping + c.link[STIFFNESS, j] * stretch_s + c.link[DAMPING, j] * rate_s


@njit
def runge_kutta(
    c: ChainNumbers, now: Moved, slip: Integers, drive: tuple[float, float, float], end: Moved, work: Work
) -> None:
    """One step of order 4 into ``end``; ``drive``: torque at its start and its end, its length [s]."""
    (x, s), (xe, se), (u0, u1, h) = now, end, drive
    first, second, third, fourth, trial = work
    um = 0.5 * (u0 + u1)
    derivative(c, now, slip, u0, first)
    advance(now, 0.5 * h, first, trial)
    derivative(c, trial, slip, um, second)
    advance(now, 0.5 * h, second, trial)
    derivative(c, trial, slip, um, third)
    advance(now, h, third, trial)
    derivative(c, trial, slip, u1, fourth)
    (k0, s0), (k1, s1), (k2, s2), (k3, s3) = first, second, third, fourth
    for a in range(x.size):
        xe[a] = x[a] + h / 6.0 * (k0[a] + 2.0 * (k1[a] + k2[a]) + k3[a])
        for k in range(s.shape[1]):
            se[a, k] = s[a, k] + h / 6.0 * (s0[a, k] + 2.0 * (s1[a, k] + s2[a, k]) + s3[a, k])


@njit
def advance(now: Moved, part: float, rates: Moved, trial: Moved) -> None:
    """State and sensitivities after a part of a step at given rates."""
    (x, s), (dx, ds), (xt, st) = now, rates, trial
    for a in range(x.size):
        xt[a] = x[a] + part * dx[a]
        for k in range(s.shape[1]):
            st[a, k] = s[a, k] + part * ds[a, k]


MOST_EVENTS = 24
CROSSING_STEPS = 12


@njit
def first_crossing(c: ChainNumbers, x: Array, xe: Array, slip: Integers) -> tuple[int, float]:
    """Number of the inertia whose speed turns first within a step, by linear interpolation; -1: none."""
    n = slip.size
    found, earliest = -1, 2.0
    for i in range(n):
        if slip[i] != 0 and c.body[SLOPE, i] == 0.0 and c.body[COULOMB, i] + c.body[EXCESS, i] > 0.0:
            before, after = slip[i] * x[n + i], slip[i] * xe[n + i]
            if after < 0.0:
                part = before / (before - after) if before > 0.0 else 0.0
                if part < earliest:
                    found, earliest = i, part
    return found, earliest


@njit
def turn(c: ChainNumbers, x: Array, s: Array, slip: Integers, i: int, u: float) -> None:
    """At zero speed of inertia i: stick, or slip on; the sensitivity of its speed jumps accordingly."""
    n = c.body.shape[1]
    x[n + i] = 0.0
    load = load_on(c, i, x, u, n)
    most = c.body[COULOMB, i] + c.body[EXCESS, i]
    before = (load - slip[i] * most) / c.body[INERTIA, i]
    if abs(load) <= most:
        slip[i] = 0
        after = 0.0
    else:
        slip[i] = 1 if load > 0.0 else -1
        after = (load - slip[i] * most) / c.body[INERTIA, i]
    ratio = after / before if before != 0.0 else 0.0
    for k in range(s.shape[1]):
        s[n + i, k] *= ratio


@njit
def release(c: ChainNumbers, x: Array, slip: Integers, u: float) -> None:
    """Let go every inertia whose load exceeds its friction."""
    n = c.body.shape[1]
    for i in range(n):
        if slip[i] == 0:
            load = load_on(c, i, x, u, n)
            if abs(load) > c.body[COULOMB, i] + c.body[EXCESS, i]:
                slip[i] = 1 if load > 0.0 else -1


@njit
def step(
    c: ChainNumbers, now: Moved, slip: Integers, drive: tuple[float, float, float], end: Moved, work: Work
) -> None:
    """One step with all turns and releases in it; the state and ``slip`` are moved on."""
    (x, s), (xe, se), (u0, u1, h) = now, end, drive
    n = c.body.shape[1]
    done = 0.0
    for _event in range(MOST_EVENTS):
        rest = h - done
        release(c, x, slip, u0 + (u1 - u0) * done / h)
        ua = u0 + (u1 - u0) * done / h
        runge_kutta(c, now, slip, (ua, u1, rest), end, work)
        i, part = first_crossing(c, x, xe, slip)
        if i < 0:
            x[:] = xe
            s[:] = se
            return
        low, high = 0.0, 1.0
        at_low, at_high = slip[i] * x[n + i], slip[i] * xe[n + i]
        for _ in range(CROSSING_STEPS):
            ub = ua + (u1 - ua) * part
            runge_kutta(c, now, slip, (ua, ub, part * rest), end, work)
            value = slip[i] * xe[n + i]
            if abs(value) <= 1e-12 * (abs(at_low) + abs(at_high)) or high - low < 1e-13:
                break
            if value > 0.0:
                low, at_low = part, value
                at_high *= 0.5
            else:
                high, at_high = part, value
                at_low *= 0.5
            part = (
                low + (high - low) * at_low / (at_low - at_high) if at_low > at_high else 0.5 * (low + high)
            )
        x[:] = xe
        s[:] = se
        done += part * rest
        turn(c, x, s, slip, i, ua + (u1 - ua) * part)
        if done >= h * (1.0 - 1e-12):
            return
    x[:] = xe
    s[:] = se


@njit
def moved(n: int, m: int) -> Moved:
    """Room for a state of n inertias and its sensitivities to m parameters."""
    return np.empty(2 * n), np.empty((2 * n, m))


@njit
def integrate(
    c: ChainNumbers, torque: Array, x0: Array, grid: tuple[float, int, float], kept: tuple[Array, Array]
) -> None:
    """Carry the chain over all samples; keeps its state and the sensitivities at each sample.

    ``grid``: interval of the samples [s]; steps in it; 0 for torque that stands from sample to sample, 1 for
    torque on straight lines between samples.
    """
    (interval, substeps, hold), (states, sensitivities) = grid, kept
    n = c.body.shape[1]
    m = c.directions.shape[1]
    x = x0.copy()
    s = np.zeros((2 * n, m))
    for i in range(n):
        for k in range(m):
            s[i, k] = c.directions[7 * n - 2 + i, k]
            s[n + i, k] = c.directions[8 * n - 2 + i, k]
    now, end = (x, s), moved(n, m)
    work = (moved(n, m), moved(n, m), moved(n, m), moved(n, m), moved(n, m))
    slip = np.zeros(n, dtype=np.int64)
    for i in range(n):
        if c.body[SLOPE, i] > 0.0 or c.body[COULOMB, i] + c.body[EXCESS, i] <= 0.0:
            slip[i] = 1
        elif x[n + i] != 0.0:
            slip[i] = 1 if x[n + i] > 0.0 else -1
    h = interval / substeps
    for sample in range(torque.size):
        states[sample] = x
        sensitivities[sample] = s
        if sample == torque.size - 1:
            break
        start = torque[sample]
        rise = (torque[sample + 1] - start) * hold
        for part in range(substeps):
            u0 = start + rise * part / substeps
            u1 = start + rise * (part + 1) / substeps
            step(c, now, slip, (u0, u1, h), end, work)
