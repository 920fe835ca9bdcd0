"""Power series of a lumped chain between two instants, and the first at which its motor changes."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.compiled import njit_in_place

Array = NDArray[np.float64]
MOST_TERMS, PROBES, HALVINGS = 40, 6, 60
STUCK = 0


@njit_in_place
def motor_load(rates: Array, inertia: float, x: Array, force: float) -> float:
    """Torque on the motor without its Coulomb friction."""
    m = rates.shape[0]
    rate = 0.0
    for j in range(m):
        rate += rates[m // 2, j] * x[j]
    return inertia * rate + force


@njit_in_place
def series(
    rates: Array,
    norm: float,
    x: Array,
    held: bool,
    u: float,
    motor: float,
    load: float,
    time: float,
    terms: Array,
) -> int:
    """Terms of x(s time), s from 0 to 1, in powers of s; returns how many are needed."""
    m = x.size
    kept = m // 2 if held else -1
    for i in range(m):
        terms[0, i] = x[i]
        value = rates[i, m] * u + rates[i, m + 1] * motor + rates[i, m + 2] * load
        for j in range(m):
            value += rates[i, j] * x[j]
        terms[1, i] = 0.0 if i == kept else value * time
    power = 1.0
    reach = norm * time
    for k in range(2, terms.shape[0]):
        for i in range(m):
            value = 0.0
            for j in range(m):
                value += rates[i, j] * terms[k - 1, j]
            terms[k, i] = 0.0 if i == kept else value * time / k
        power *= reach / k
        if power < 1e-18:
            return k + 1
    return terms.shape[0]


@njit_in_place
def at(terms: Array, count: int, i: int, s: float) -> float:
    """Quantity i at the share s of the time."""
    value = terms[count - 1, i]
    for k in range(count - 2, -1, -1):
        value = value * s + terms[k, i]
    return value


@njit_in_place
def margin(
    rates: Array,
    inertia: float,
    coulomb: float,
    terms: Array,
    count: int,
    slip: int,
    motor: float,
    s: float,
    x: Array,
) -> float:
    """What is left before the motor changes: speed in its direction, or friction that is not used up."""
    m = terms.shape[1]
    if slip != STUCK:
        return slip * at(terms, count, m // 2, s)
    rate = 0.0
    for i in range(m):
        rate += rates[m // 2, i] * at(terms, count, i, s)
    return coulomb - abs(inertia * rate + motor)


@njit_in_place
def first_change(
    rates: Array, inertia: float, coulomb: float, terms: Array, count: int, slip: int, motor: float, x: Array
) -> float:
    """Share of the time at which the motor changes for the first time; above 1 if it does not."""
    low = 0.0
    for probe in range(1, PROBES + 1):
        high = probe / PROBES
        if margin(rates, inertia, coulomb, terms, count, slip, motor, high, x) < 0.0:
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if margin(rates, inertia, coulomb, terms, count, slip, motor, middle, x) < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        low = high
    return 2.0
