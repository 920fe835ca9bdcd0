"""Parts of a reference row, compiled: smooth rises of any order, filters exact between samples."""

from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.parameters.arrays import Array, Integers

EDGE = 1e-9  # of a rise: the first instant of a motion, rounded, belongs to it


@njit_in_place
def rise_derivative(coefficients: Array, xi: float, k: int) -> float:
    """Derivative number k of the rise at 0 <= xi <= 1/2, by Horner's rule."""
    value = 0.0
    for power in range(coefficients.size - 1, k - 1, -1):
        factor = 1.0
        for j in range(k):
            factor *= power - j
        value = value * xi + factor * coefficients[power]
    return value


@njit_in_place
def add_motion(coefficients: Array, scalars: Array, time: float, weight: float, wanted: Array) -> None:
    """Add the wanted load angle and its derivatives, times a weight, to ``wanted``; nothing before time 0."""
    if time < -EDGE * scalars[1]:
        return
    time = max(time, 0.0)
    angle, rise, stay = scalars[0], scalars[1], scalars[1] + scalars[2]
    share = min(time / (2.0 * stay), scalars[3] - 1.0)
    at = time - 2.0 * stay * int(share)
    scale = weight * angle
    if at >= stay:
        wanted[0] += scale
        at -= stay
        scale = -scale
    xi = at / rise
    if xi > 1.0:
        wanted[0] += scale
        return
    late = xi > 0.5  # the upper half by s(xi) = 1 - s(1 - xi): no digits are lost near the end
    if late:
        wanted[0] += scale
        xi = 1.0 - xi
        scale = -scale
    for k in range(wanted.size):
        wanted[k] += scale * rise_derivative(coefficients, xi, k)
        scale = -scale / rise if late else scale / rise


@njit_in_place
def set_motion(coefficients: Array, scalars: Array, time: float, wanted: Array) -> None:
    """Write the wanted load angle and its derivatives at an instant into ``wanted``."""
    for k in range(wanted.size):
        wanted[k] = 0.0
    add_motion(coefficients, scalars, time, 1.0, wanted)


@njit_in_place
def mapped(start: float, weights: Array, stages: Array) -> float:
    """A number and the stages times their weights, which stand one stage behind the other."""
    value, width = start, stages.shape[1]
    for i in range(stages.shape[0]):
        for k in range(width):
            value += weights[i * width + k] * stages[i, k]
    return value


@njit_in_place
def filter_stages(lags: Array, sources: Integers, begun: bool, memory: Array, stages: Array) -> None:
    """Each filter one sample on, from rest on its first value: its output is a stage of its own."""
    for i in range(lags.shape[0]):
        for k in range(stages.shape[1]):
            value = stages[sources[i], k]
            if not begun:
                memory[i, k] = (1.0 - lags[i, 0]) * value
            stages[i + 1, k] = lags[i, 0] * value + memory[i, k]
            memory[i, k] = lags[i, 1] * value + lags[i, 2] * stages[i + 1, k]
