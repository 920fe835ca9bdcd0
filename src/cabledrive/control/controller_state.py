"""What a controller keeps from sample to sample, and the space in which its laws work."""

from typing import NamedTuple

import numpy as np

from cabledrive.control.backstepping_recursion import work_shape
from cabledrive.control.numbers import BACKSTEPPING, LEARNING, LINEAR, SCHEDULED, LawNumbers
from cabledrive.control.observer_numbers import DIFFERENCE, ObserverNumbers
from cabledrive.parameters.arrays import Array, Integers

ESTIMATES = 12


class ControllerState(NamedTuple):
    """Everything that a controller keeps from sample to sample, and scratch.

    ``sample`` (1,): of the filter's schedule. ``held``: torque of the observer's shaft, last command before
    the limit. ``memory``: of a linear law, or of a controller of the user's own. ``commands``: limited, those
    not yet at the motor, oldest first. ``states``: angles and speeds that the law takes.
    """

    sample: Integers
    estimate: Array
    held: Array
    parameters: Array
    memory: Array
    commands: Array
    states: Array
    regressor: Array
    work: Array
    table: Array


def new_controller_state(
    observer: ObserverNumbers, law: LawNumbers, readings: int, late_samples: int, start: Array, memory: Array
) -> ControllerState:
    """A controller at rest at angle zero with some ``readings`` of encoders.

    ``late_samples``: whole samples of the delay; ``start``, (<= 12,): parameter estimates to begin with;
    ``memory``, (m,): of a controller of the user's own.
    """
    size = law.matrix.shape[0] if law.kind in (LINEAR, LEARNING, SCHEDULED) else 0
    parameters = np.zeros(ESTIMATES)
    parameters[: len(start)] = start
    observed = max(observer.output.shape[1], 2 * readings if observer.kind == DIFFERENCE else 0)
    return ControllerState(
        sample=np.zeros(1, dtype=np.int64),
        estimate=np.zeros(observed),
        held=np.zeros(2),
        parameters=parameters,
        memory=np.concatenate((np.zeros(size), memory)),
        commands=np.zeros(late_samples + 2),
        states=np.zeros(len(observer.chosen)),
        regressor=np.zeros(ESTIMATES),
        work=np.zeros(max(observed, size, ESTIMATES)),
        table=np.zeros(work_shape(len(law.matrix) // 2) if law.kind == BACKSTEPPING else (0, 0)),
    )
