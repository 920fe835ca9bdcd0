"""A law's reference row from the time alone, compiled: smooth rises of any order, filters, one linear map."""

from math import tanh

import numpy as np

from cabledrive.control.reference_numbers import (
    Array,
    Integers,
    MotionNumbers,
    ReferenceNumbers,
    ReferenceState,
    new_reference_state,
)
from cabledrive.mechanics.compiled import njit_in_place, njit_part

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
def filter_stages(lags: Array, sources: Integers, begun: bool, memory: Array, stages: Array) -> None:
    """Each filter one sample on, from rest on its first value: its output is a stage of its own."""
    for i in range(lags.shape[0]):
        for k in range(stages.shape[1]):
            value = stages[sources[i], k]
            if not begun:
                memory[i, k] = (1.0 - lags[i, 0]) * value
            stages[i + 1, k] = lags[i, 0] * value + memory[i, k]
            memory[i, k] = lags[i, 1] * value + lags[i, 2] * stages[i + 1, k]


@njit_part
def reference_row(
    numbers: ReferenceNumbers, motion: MotionNumbers, g: ReferenceState, time: float, row: Array
) -> None:
    """The row of this sample, to be called once a sample; writes ``row``, shape (columns,)."""
    stages = g.stages
    for k in range(stages.shape[1]):
        stages[0, k] = 0.0
    for i in range(numbers.taps.shape[0]):
        add_motion(
            motion.coefficients, motion.scalars, time - numbers.taps[i, 0], numbers.taps[i, 1], stages[0]
        )
    filter_stages(numbers.lags, numbers.sources, g.begun[0] != 0, g.memory, stages)
    g.begun[0] = 1
    width = stages.shape[1]
    for c in range(row.size):
        value = numbers.constant[c]
        for i in range(stages.shape[0]):
            for k in range(width):
                value += numbers.output[c, i * width + k] * stages[i, k]
        row[c] = value
    for i in range(numbers.friction.shape[0]):
        speed = row[numbers.places[i, 1]]
        row[numbers.places[i, 0]] += numbers.friction[i, 0] * tanh(numbers.friction[i, 1] * speed)


@njit_in_place
def fill_table(
    numbers: ReferenceNumbers, motion: MotionNumbers, g: ReferenceState, interval: float, table: Array
) -> None:
    """Rows of all samples, shape (samples, columns)."""
    for k in range(table.shape[0]):
        reference_row(numbers, motion, g, k * interval, table[k])


def reference_table(numbers: ReferenceNumbers, motion: MotionNumbers, interval: float, samples: int) -> Array:
    """Rows of a whole motion from rest, shape (samples, columns); ``interval``: sample time [s]."""
    table = np.zeros((samples, len(numbers.output)))
    fill_table(numbers, motion, new_reference_state(numbers), interval, table)
    return table
