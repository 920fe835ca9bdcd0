"""Compiled motion of a linear lumped chain whose motor sticks and slips, exact between any two instants.

States are angles, speeds and the torque at the shaft. Over a whole internal step the exact transition is a
table; a step in which the motor starts, stops or turns is followed by the power series of the exponential,
whose terms are summed to round-off, and the instant is found on that series.
"""

from math import tanh
from typing import NamedTuple

from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.rig.closed_loop.series_kernels import (
    MOST_TERMS,
    STUCK,
    Array,
    at,
    first_change,
    motor_load,
    series,
)

MOST_EVENTS = 64
__all__ = ["MOST_TERMS", "PlantNumbers", "advance"]


class PlantNumbers(NamedTuple):
    """A lumped chain of n inertias; m = 2n + 1 states.

    Attributes
    ----------
    rates : ndarray, shape (m, m + 3)
        Rates of the states from the states, the command, a torque on the motor, a torque on the load.
    tables : ndarray, shape (2, m, m + 4)
        States after one internal step from the same; the motor held, the motor free. The last column is of a
        torque on the motor that rises from 0 to 1 in the step.
    scalars : ndarray, shape (9,)
        Internal step [s]; motor's inertia, Coulomb friction and offset torque; Coulomb friction of the load,
        smoothed by tanh(K w), and K; bandwidth of the torque loop [rad/s], 0: none; bound of the rates
        [1/s]; K of the motor's friction c tanh(K w), 0: it sticks and slips.
    """

    rates: Array
    tables: Array
    scalars: Array

    @property
    def size(self) -> int:
        """Number of inertias."""
        return (self.rates.shape[0] - 1) // 2


@njit_in_place
def settle(load: float, coulomb: float) -> int:
    """Stick or slip of a motor at rest; it slips the way of a load that friction cannot hold."""
    if abs(load) <= coulomb * (1.0 + 1e-13):
        return STUCK
    return 1 if load > 0.0 else -1


@njit_in_place
def advance_exactly(
    rates: Array,
    scalars: Array,
    x: Array,
    slip: int,
    u: float,
    motor: float,
    load: float,
    time: float,
    terms: Array,
    work: Array,
) -> int:
    """Move the chain on by any time, event by event; ``x`` is changed, the new slip returned."""
    m = x.size
    n = m // 2
    inertia, coulomb, norm = scalars[1], scalars[2], scalars[7]
    rest = time
    for _ in range(MOST_EVENTS):
        if slip == STUCK:
            slip = settle(motor_load(rates, inertia, x, motor), coulomb)
        held = slip == STUCK
        part = rest if norm * rest < 2.0 else 2.0 / norm
        count = series(rates, norm, x, held, u, motor - slip * coulomb, load, part, terms)
        s = 2.0
        if coulomb > 0.0:
            s = first_change(rates, inertia, coulomb, terms, count, slip, motor, work)
        changed = s <= 1.0
        s = min(s, 1.0)
        for i in range(m):
            x[i] = at(terms, count, i, s)
        rest -= s * part
        if changed:
            if not held:
                x[n] = 0.0
            now = motor_load(rates, inertia, x, motor)
            slip = (1 if now > 0.0 else -1) if held else settle(now, coulomb)
        if rest <= 1e-15 * time:
            return slip
    x[n] = 0.0
    count = series(rates, norm, x, True, u, motor, load, rest, terms)
    for i in range(m):
        x[i] = at(terms, count, i, 1.0)
    return STUCK


@njit_in_place
def table_step(
    rates: Array,
    tables: Array,
    scalars: Array,
    x: Array,
    slip: int,
    u: float,
    motor: float,
    load: float,
    terms: Array,
    work: Array,
) -> int:
    """One internal step by the table; event by event where the motor changes in it."""
    m = x.size
    n = m // 2
    step, inertia, coulomb = scalars[0], scalars[1], scalars[2]
    held = slip == STUCK and coulomb > 0.0
    before = motor_load(rates, inertia, x, motor)
    if held and abs(before) > coulomb:
        return advance_exactly(rates, scalars, x, slip, u, motor, load, step, terms, work)
    which = 0 if held else 1
    friction = motor - slip * coulomb
    for i in range(m):
        value = tables[which, i, m] * u + tables[which, i, m + 1] * friction + tables[which, i, m + 2] * load
        for j in range(m):
            value += tables[which, i, j] * x[j]
        work[i] = value
    if coulomb > 0.0:
        after = motor_load(rates, inertia, work, motor)
        if held:
            changes = abs(after) > coulomb
        else:
            start, end = slip * before - coulomb, slip * after - coulomb
            turns = start < 0.0 < end and -start * step > inertia * slip * x[n]
            changes = slip * work[n] < 0.0 or turns
        if changes:
            return advance_exactly(rates, scalars, x, slip, u, motor, load, step, terms, work)
    for i in range(m):
        x[i] = work[i]
    return slip


@njit_in_place
def smooth_step(
    tables: Array, scalars: Array, x: Array, u: float, motor: float, load: float, work: Array
) -> None:
    """One internal step with friction c tanh(K w) on a straight line, of order 2 in the step."""
    m = x.size
    n = m // 2
    coulomb, slope = scalars[2], scalars[8]
    before = coulomb * tanh(slope * x[n])
    for i in range(m):
        value = tables[1, i, m] * u + tables[1, i, m + 1] * (motor - before) + tables[1, i, m + 2] * load
        for j in range(m):
            value += tables[1, i, j] * x[j]
        work[i] = value
    rise = before - coulomb * tanh(slope * work[n])
    for i in range(m):
        x[i] = work[i] + tables[1, i, m + 3] * rise


@njit_in_place
def smooth_part(
    rates: Array, scalars: Array, x: Array, u: float, motor: float, load: float, time: float, terms: Array
) -> None:
    """Part of an internal step with smoothed friction held, in pieces short enough for the series."""
    norm, rest = scalars[7], time
    while rest > 0.0:
        part = rest if norm * rest < 2.0 else 2.0 / norm
        count = series(rates, norm, x, False, u, motor, load, part, terms)
        for i in range(x.size):
            x[i] = at(terms, count, i, 1.0)
        rest -= part


@njit_in_place
def advance(
    rates: Array,
    tables: Array,
    scalars: Array,
    x: Array,
    slip: int,
    u: float,
    motor: float,
    load: float,
    time: float,
    terms: Array,
    work: Array,
) -> int:
    """Move the chain on under a constant command, by the table if nothing happens; returns the new slip."""
    m, step = x.size, scalars[0]
    if scalars[6] == 0.0:
        x[m - 1] = u
    motor += scalars[3]
    done = 0.0
    while done < time * (1.0 - 1e-12):
        part = min(step, time - done)
        pull = load
        if scalars[4] > 0.0:
            pull -= scalars[4] * tanh(scalars[5] * x[m - 2])
        if part < step * (1.0 - 1e-9):
            if scalars[8] > 0.0:
                friction = scalars[2] * tanh(scalars[8] * x[m // 2])
                smooth_part(rates, scalars, x, u, motor - friction, pull, part, terms)
            else:
                slip = advance_exactly(rates, scalars, x, slip, u, motor, pull, part, terms, work)
        elif scalars[8] > 0.0:
            smooth_step(tables, scalars, x, u, motor, pull, work)
        else:
            slip = table_step(rates, tables, scalars, x, slip, u, motor, pull, terms, work)
        done += part
    return slip
