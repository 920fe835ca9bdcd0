"""A law's reference row from the time alone, compiled: motion, filters, a linear map, torques of the load."""

from math import tanh

import numpy as np

from cabledrive.control.load_row_kernels import load_columns
from cabledrive.control.reference_numbers import (
    MotionNumbers,
    ReferenceNumbers,
    ReferenceState,
    new_reference_state,
)
from cabledrive.control.reference_part_kernels import add_motion, filter_stages, mapped
from cabledrive.mechanics.compiled import njit_in_place, njit_part
from cabledrive.parameters.arrays import Array


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
    for c in range(numbers.output.shape[0]):
        row[c] = mapped(numbers.constant[c], numbers.output[c], stages)
    for i in range(numbers.friction.shape[0]):
        speed = row[numbers.places[i, 1]]
        row[numbers.places[i, 0]] += numbers.friction[i, 0] * tanh(numbers.friction[i, 1] * speed)
    if numbers.load.sign.shape[0] > 0:
        load_columns(
            numbers.load, motion, g.begun[0] != 0, g.load, time, row, numbers.output.shape[0]
        )  # fmt: skip
    g.begun[0] = 1


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
