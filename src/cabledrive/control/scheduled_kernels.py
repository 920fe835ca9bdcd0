"""Compiled step of a law and an observer whose matrices are tabled over the position of a carriage."""

from typing import NamedTuple

from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array


class ScheduledLaw(NamedTuple):
    """Tables over the positions of the carriage, as the compiled step takes them."""

    grid: Array  # (3,): first position, spacing, start of the carriage [m]
    feedback: Array  # (positions, 8): force per error of the states
    correction: Array  # (positions, 10, 2): of the observer's states by the errors of the two encoders
    transition: Array  # (positions, 10, 10): over one sample
    drive: Array  # (positions, 10): by a force on the motor
    limit: float  # largest force [N]


@njit
def place_in(grid_start: float, spacing: float, count: int, position: float) -> tuple[int, float]:
    """Interval of the table and the share of it that a position lies in; held at the ends."""
    share = (position - grid_start) / spacing
    share = min(max(share, 0.0), count - 1.0)
    low = min(int(share), count - 2)
    return low, share - low


@njit
def scheduled_step(
    law: ScheduledLaw, estimate: Array, readings: Array, reference: Array, k: int, fresh: Array
) -> float:
    """One sample: the observer takes in the readings, the law acts, the observer goes on; returns the force.

    ``reference[k]``: states, force, friction in it.
    """
    grid, feedback, correction, transition, drive, limit = law
    n, m, states = estimate.size, readings.size, feedback.shape[1]
    low, share = place_in(grid[0], grid[1], feedback.shape[0], grid[2] + estimate[1])
    for i in range(n):
        value = estimate[i]
        for j in range(m):
            gain = correction[low, i, j] + share * (correction[low + 1, i, j] - correction[low, i, j])
            value += gain * (readings[j] - estimate[2 * j])
        fresh[i] = value
    force = reference[k, states]
    for i in range(states):
        gain = feedback[low, i] + share * (feedback[low + 1, i] - feedback[low, i])
        force -= gain * (fresh[i] - reference[k, i])
    force = min(max(force, -limit), limit)
    net = force - reference[k, states + 1]
    for i in range(n):
        value = (drive[low, i] + share * (drive[low + 1, i] - drive[low, i])) * net
        for j in range(n):
            part = transition[low, i, j] + share * (transition[low + 1, i, j] - transition[low, i, j])
            value += part * fresh[j]
        estimate[i] = value
    return force
