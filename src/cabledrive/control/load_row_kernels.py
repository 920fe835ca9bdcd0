"""Columns of a law that learns the load's torque, compiled: what a unit asks of states, motor and filter.

The sign of friction is smoothed to both sides and the filter's error follows the torque between two samples:
the motion is known ahead, and the generator works one sample before the row that it writes.
"""

from math import tanh

from cabledrive.control.load_row_numbers import LoadRowNumbers, LoadRowState
from cabledrive.control.reference_numbers import MotionNumbers
from cabledrive.control.reference_part_kernels import filter_stages, mapped, rise_derivative, set_motion
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.parameters.arrays import Array


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
    """Torques of unit friction, viscous friction and inertia with their derivatives, shape (3, r).

    The window of signs stands about the same instant.
    """
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
    load: LoadRowNumbers, motion: MotionNumbers, begun: bool, g: LoadRowState, time: float
) -> None:
    """Torques at this sample and at the next one; at the start the window is filled first."""
    interval, last = load.scalars[0], g.window.size - 1
    half = last // 2
    if begun:
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
    load: LoadRowNumbers,
    motion: MotionNumbers,
    begun: bool,
    g: LoadRowState,
    time: float,
    row: Array,
    first: int,
) -> None:
    """Write the columns from ``first`` on.

    Of each torque: states less what the filter misses, motor torque, innovations.
    """
    step_ahead(load, motion, begun, g, time)
    states, readings = g.error.shape[1], load.white.shape[0]
    n2, width = load.chosen.size, g.now.shape[1]
    for p in range(g.now.shape[0]):
        at = first + p * (n2 + 1 + readings)
        for k in range(width):
            g.stages[0, k] = g.now[p, k]
        filter_stages(load.lags, load.sources, begun, g.memory[p], g.stages)
        for c in range(n2 + 1):
            row[at + c] = mapped(0.0, load.output[c], g.stages)
        # The filter's error, as `cabledrive.control.innovations_of_load.filter_error` has it.
        for j in range(readings):
            seen = 0.0
            for i in range(states):
                seen += load.seen[j, i] * g.error[p, i]
            g.innovation[j] = seen
        for i in range(states):
            for j in range(readings):
                g.error[p, i] -= load.gains[i, j] * g.innovation[j]
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
