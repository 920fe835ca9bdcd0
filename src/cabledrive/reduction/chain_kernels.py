"""Compiled motion of a lumped chain with set-valued friction, and its exact sensitivities.

Between events the chain is smooth and one Runge-Kutta step of order 4 carries state and sensitivities. An
inertia whose speed reaches zero is followed to that instant; there it sticks, or slips on the other way, and
the sensitivity of its speed jumps by the ratio of its accelerations after and before. The readable door is
`cabledrive.reduction.friction_integration`.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Integers
from cabledrive.reduction.chain_motion_kernels import (
    COULOMB,
    EXCESS,
    INERTIA,
    SLOPE,
    ChainNumbers,
    Work,
    load_on,
    runge_kutta,
)

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
    c: ChainNumbers,
    x: Array,
    s: Array,
    slip: Integers,
    u0: float,
    u1: float,
    h: float,
    xe: Array,
    se: Array,
    work_x: Work,
    work_s: Work,
) -> None:
    """One step with all turns and releases in it; ``x``, ``s`` and ``slip`` are moved on."""
    n = c.body.shape[1]
    done = 0.0
    for _event in range(MOST_EVENTS):
        rest = h - done
        release(c, x, slip, u0 + (u1 - u0) * done / h)
        ua = u0 + (u1 - u0) * done / h
        runge_kutta(c, x, s, slip, ua, u1, rest, xe, se, work_x, work_s)
        i, part = first_crossing(c, x, xe, slip)
        if i < 0:
            x[:] = xe
            s[:] = se
            return
        low, high = 0.0, 1.0
        at_low, at_high = slip[i] * x[n + i], slip[i] * xe[n + i]
        for _ in range(CROSSING_STEPS):
            ub = ua + (u1 - ua) * part
            runge_kutta(c, x, s, slip, ua, ub, part * rest, xe, se, work_x, work_s)
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
def integrate(
    c: ChainNumbers,
    torque: Array,
    x0: Array,
    interval: float,
    substeps: int,
    hold: float,
    stored: Integers,
    states: Array,
    sensitivities: Array,
) -> None:
    """Carry the chain over all samples; keeps the ``stored`` states and their sensitivities at each sample.

    ``hold``: 0 for torque that stands from sample to sample, 1 for torque on straight lines between samples.
    """
    n = c.body.shape[1]
    m = c.directions.shape[1]
    x = x0.copy()
    s = np.zeros((2 * n, m))
    for i in range(n):
        for k in range(m):
            s[i, k] = c.directions[7 * n - 2 + i, k]
            s[n + i, k] = c.directions[8 * n - 2 + i, k]
    xe, se = np.empty(2 * n), np.empty((2 * n, m))
    nx, ns = 2 * n, (2 * n, m)
    work_x = (np.empty(nx), np.empty(nx), np.empty(nx), np.empty(nx), np.empty(nx))
    work_s = (np.empty(ns), np.empty(ns), np.empty(ns), np.empty(ns), np.empty(ns))
    slip = np.zeros(n, dtype=np.int64)
    for i in range(n):
        if c.body[SLOPE, i] > 0.0 or c.body[COULOMB, i] + c.body[EXCESS, i] <= 0.0:
            slip[i] = 1
        elif x[n + i] != 0.0:
            slip[i] = 1 if x[n + i] > 0.0 else -1
    h = interval / substeps
    for sample in range(torque.size):
        for a in range(stored.size):
            states[sample, a] = x[stored[a]]
            for k in range(m):
                sensitivities[sample, a, k] = s[stored[a], k]
        if sample == torque.size - 1:
            break
        start = torque[sample]
        rise = (torque[sample + 1] - start) * hold
        for part in range(substeps):
            u0 = start + rise * part / substeps
            u1 = start + rise * (part + 1) / substeps
            step(c, x, s, slip, u0, u1, h, xe, se, work_x, work_s)
