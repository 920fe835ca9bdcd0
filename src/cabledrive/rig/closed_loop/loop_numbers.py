"""What the closed loop of the rig needs to run, as its compiled form takes it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.numbers import (
    ESTIMATES,
    ControllerState,
    LawNumbers,
    ObserverNumbers,
    new_controller_state,
)

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
__all__ = ["ESTIMATES", "SUMMARY", "Array", "ControllerState", "Integers", "LoopState", "RigNumbers"]
DIVERGED, WENT_SLACK = 1, 2
SUMMARY = (
    "peak",
    "first_peak",
    "later_peak",
    "square",
    "peak_torque",
    "saturated",
    "invalid",
    "twist",
    "own_peak",
    "slack",
    "loose",
    "aside",
    "swing",
)


class RigNumbers(NamedTuple):
    """Sensors, actuator and disturbances.

    ``encoders`` (m,): inertia that each encoder reads; ``counts`` (m,): one count at the first shaft [rad],
    0: ideal; ``phases`` (m,): where in its count each encoder starts, from -1/2 to 1/2. ``torque_limit`` [N
    m]; ``late_samples`` and ``late_part`` [s]: the delay. ``jitter`` (samples,): how late each sample is
    taken [s]. ``forces`` (samples, 2): torque on motor and load from this sample to the next [N m].
    ``first_end``: sample at which the first pulse and its dwell are over. ``dropout``: sensor, first and last
    sample at which it gives NaN.
    """

    interval: float
    encoders: Integers
    counts: Array
    phases: Array
    torque_limit: float
    late_samples: int
    late_part: float
    jitter: Array
    forces: Array
    first_end: int
    dropout: Integers


class LoopState(NamedTuple):
    """Everything that moves, and scratch; arrays, so that a run can go on where another ended.

    ``x``: angles, speeds and shaft torque, then whatever else the plant keeps. ``discrete``: slip, and why
    the run ended (`DIVERGED`, `WENT_SLACK`; 0: it did not). ``controller``: what the controller keeps.
    """

    x: Array
    discrete: Integers
    controller: ControllerState
    readings: Array
    terms: Array
    work: Array
    summary: Array


def new_state(
    plant_states: int,
    observer: ObserverNumbers,
    law: LawNumbers,
    rig: RigNumbers,
    start: Array,
    memory: Array | None = None,
) -> LoopState:
    """A loop at rest at angle zero; ``start``: of the estimates; ``memory``: of a user's controller."""
    readings, own = len(rig.encoders), np.zeros(0) if memory is None else memory
    return LoopState(
        x=np.zeros(plant_states),
        discrete=np.zeros(2, dtype=np.int64),
        controller=new_controller_state(observer, law, readings, rig.late_samples, start, own),
        readings=np.zeros(readings),
        terms=np.zeros((5, plant_states)),
        work=np.zeros(plant_states),
        summary=np.zeros(len(SUMMARY)),
    )
