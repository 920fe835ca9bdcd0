"""A law's reference row from the time alone, compiled.

The sign of friction is smoothed to both sides and the filter's error follows the torque between two samples:
the motion is known ahead, and the generator works one sample before the row that it writes.
"""

from math import tanh

import numpy as np

from cabledrive.control.reference import (
    LoadRowNumbers,
    LoadRowState,
    MotionNumbers,
    ReferenceNumbers,
    ReferenceState,
    new_reference_state,
)
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array, Integers

LAST_SAMPLE = 1_000_000_000  # the count stays there: a target runs for years
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


@njit_in_place
def sign_ahead(load: LoadRowNumbers, motion: MotionNumbers, g: LoadRowState, time: float) -> float:
    """Sign of the wanted speed at an instant, before it is smoothed; zero where nothing is to move."""
    peak = abs(motion.scalars[0]) * rise_derivative(motion.coefficients, 0.5, 1) / motion.scalars[1]
    if not peak > 0.0:
        return 0.0
    set_motion(motion.coefficients, motion.scalars, time, g.wanted)
    return tanh(load.scalars[1] * g.wanted[1] / peak)


@njit_in_place
def unit_torques(
    load: LoadRowNumbers, motion: MotionNumbers, g: LoadRowState, time: float, torque: Array
) -> None:
    """Torques of unit friction, viscous friction and inertia with their derivatives, shape (3, r)."""
    for k in range(torque.shape[1]):
        value = 0.0
        for i in range(load.sign.shape[1]):
            value += load.sign[k, i] * g.window[i]
        torque[0, k] = value
    set_motion(motion.coefficients, motion.scalars, time, g.wanted)
    for k in range(torque.shape[1]):
        torque[1, k] = g.wanted[k + 1]
        torque[2, k] = g.wanted[k + 2]


@njit_in_place
def step_ahead(
    load: LoadRowNumbers, motion: MotionNumbers, number: int, g: LoadRowState, time: float
) -> None:
    """Torques at this sample and at the next one; at the start the window is filled first."""
    interval, last = load.scalars[0], g.window.size - 1
    half = last // 2
    if number > 0:
        for p in range(g.now.shape[0]):
            for k in range(g.now.shape[1]):
                g.now[p, k] = g.next[p, k]
    else:
        for i in range(g.window.size):
            g.window[i] = sign_ahead(load, motion, g, time + (i - half) * interval)
        unit_torques(load, motion, g, time, g.now)
    for i in range(last):
        g.window[i] = g.window[i + 1]
    g.window[last] = sign_ahead(load, motion, g, time + (half + 1) * interval)
    unit_torques(load, motion, g, time + interval, g.next)


@njit_in_place
def load_columns(
    load: LoadRowNumbers, motion: MotionNumbers, number: int, g: LoadRowState, time: float, row: Array
) -> None:
    """Write, last in the row, of each torque states less what the filter misses, torque, innovations."""
    step_ahead(load, motion, number, g, time)
    states, readings = g.error.shape[1], load.white.shape[0]
    n2, width, torques = load.chosen.size, g.now.shape[1], g.now.shape[0]
    cell, block = min(number, load.gains.shape[0] - 1), n2 + 1 + readings
    for p in range(torques):
        at = row.size - (torques - p) * block
        for k in range(width):
            g.stages[0, k] = g.now[p, k]
        filter_stages(load.lags, load.sources, number > 0, g.memory[p], g.stages)
        for c in range(n2 + 1):
            row[at + c] = mapped(0.0, load.output[c], g.stages)
        for j in range(readings):
            seen = 0.0
            for i in range(states):
                seen += load.seen[j, i] * g.error[p, i]
            g.innovation[j] = seen
        for i in range(states):
            for j in range(readings):
                g.error[p, i] -= load.gains[cell, i, j] * g.innovation[j]
        for i in range(n2):
            row[at + i] -= g.error[p, load.chosen[i]]
        for j in range(readings):
            value = 0.0
            for i in range(readings):
                value += load.white[j, i] * g.innovation[i]
            row[at + n2 + 1 + j] = value
        mean = 0.5 * (g.now[p, 0] + g.next[p, 0])
        for i in range(states):
            value = load.transition[i, states] * mean
            for j in range(states):
                value += load.transition[i, j] * g.error[p, j]
            g.fresh[i] = value
        for i in range(states):
            g.error[p, i] = g.fresh[i]


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
    number = g.made[0]
    filter_stages(numbers.lags, numbers.sources, number > 0, g.memory, stages)
    for c in range(numbers.output.shape[0]):
        row[c] = mapped(numbers.constant[c], numbers.output[c], stages)
    for i in range(numbers.friction.shape[0]):
        speed = row[numbers.places[i, 1]]
        row[numbers.places[i, 0]] += numbers.friction[i, 0] * tanh(numbers.friction[i, 1] * speed)
    if numbers.load.sign.shape[0] > 0:
        load_columns(numbers.load, motion, number, g.load, time, row)
    g.made[0] = min(number + 1, LAST_SAMPLE)


@njit_in_place
def fill_table(
    numbers: ReferenceNumbers, motion: MotionNumbers, g: ReferenceState, interval: float, table: Array
) -> None:
    """Rows of all samples, shape (samples, columns)."""
    for k in range(table.shape[0]):
        reference_row(numbers, motion, g, k * interval, table[k])


def reference_table(numbers: ReferenceNumbers, motion: MotionNumbers, interval: float, samples: int) -> Array:
    """Rows of a whole motion from rest, shape (samples, columns); ``interval``: sample time [s]."""
    table = np.zeros((samples, numbers.columns))
    fill_table(numbers, motion, new_reference_state(numbers), interval, table)
    return table
