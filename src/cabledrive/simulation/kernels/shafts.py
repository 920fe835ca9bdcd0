"""Compiled motion of the shafts over one step: implicit friction, set-valued or smoothed.

The three shafts are drive pulley, load pulley and motor, all measured at the rim: displacement r theta, mass
J / r^2.
"""

from math import tanh

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_strict
from cabledrive.simulation.plan import COULOMB, SMOOTH, TURNS
from cabledrive.simulation.workspace import FRICTION, NEW, OLD, RIGHT

SHAFTS = 3
MOST_SWEEPS = 100


@njit_strict
@for_kernels
def solve_shafts(matrix: Array, table: Array, shaft: Array) -> None:
    """Speeds after the step: matrix @ new + friction = right, by coordinate descent on a convex function.

    ``table`` holds the shafts' numbers (see `Plan`), ``shaft`` what is known and what comes out (see
    `Workspace`). The friction is in ``coulomb * Sgn(new)`` where the smoothing speed is zero, and otherwise
    ``coulomb * tanh((old + new) / 2 / smoothing speed)``.
    """
    rubbing = False
    for i in range(SHAFTS):
        shaft[NEW, i] = shaft[OLD, i] * table[TURNS, i]
        shaft[FRICTION, i] = 0.0
        rubbing = rubbing or table[COULOMB, i] > 0.0
    coupled = matrix[0, 1] != 0.0 or matrix[0, 2] != 0.0 or matrix[1, 2] != 0.0
    if not (coupled or rubbing):
        for i in range(SHAFTS):
            if table[TURNS, i] > 0.0:
                shaft[NEW, i] = shaft[RIGHT, i] / matrix[i, i]
        return
    for _ in range(MOST_SWEEPS if coupled else 1):
        change = 0.0
        size = 0.0
        for i in range(SHAFTS):
            if table[TURNS, i] == 0.0:
                continue
            rest = shaft[RIGHT, i]
            if coupled:
                for k in range(SHAFTS):
                    rest -= 0.0 if k == i else matrix[i, k] * shaft[NEW, k]
            speed = one_shaft(matrix[i, i], rest, table[COULOMB, i], table[SMOOTH, i], shaft[OLD, i])
            if table[COULOMB, i] > 0.0:
                shaft[FRICTION, i] = rest - matrix[i, i] * speed
            change = max(change, abs(speed - shaft[NEW, i]))
            size = max(size, abs(speed))
            shaft[NEW, i] = speed
        if change <= 1e-15 * size:
            break


@njit_strict
@for_kernels
def one_shaft(inertia: float, rest: float, coulomb: float, smooth: float, old: float) -> float:
    """Speed after the step of a shaft whose neighbours' speeds are known."""
    if smooth > 0.0:
        return _smoothed(inertia, rest, coulomb, smooth, old)
    if abs(rest) <= coulomb:
        return 0.0
    return (rest - coulomb if rest > 0.0 else rest + coulomb) / inertia


@njit_strict
def _smoothed(inertia: float, rest: float, coulomb: float, smooth: float, old: float) -> float:
    """New speed under tanh friction at the mean speed: Newton on a monotone function, kept in its bracket."""
    total = rest + inertia * old  # 2 inertia mean + coulomb tanh(mean / smooth) = total
    low = (total - coulomb) / (2.0 * inertia)
    high = (total + coulomb) / (2.0 * inertia)
    mean = min(max(old, low), high)
    for _ in range(60):
        push = tanh(mean / smooth)
        excess = 2.0 * inertia * mean + coulomb * push - total
        if excess > 0.0:
            high = mean
        else:
            low = mean
        better = mean - excess / (2.0 * inertia + coulomb * (1.0 - push * push) / smooth)
        if not low < better < high:
            better = 0.5 * (low + high)
        if abs(better - mean) <= 1e-15 * abs(better):
            break
        mean = better
    return 2.0 * mean - old


@njit_strict
@for_kernels
def add_to(tallies: Array, number: int, amount: float) -> None:
    """Add to a tally, with what rounding took away last time (compensated summation).

    Callers write int(NAME) for the number: a named constant by itself would be compiled into a version of
    this function of its own.
    """
    amount -= tallies[1, number]
    total = tallies[0, number] + amount
    tallies[1, number] = (total - tallies[0, number]) - amount
    tallies[0, number] = total
