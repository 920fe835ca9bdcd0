"""What the closed loop of the rig needs to run, as its compiled form takes it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.backstepping_recursion import work_shape
from cabledrive.control.numbers import BACKSTEPPING, LINEAR, LawNumbers
from cabledrive.control.observer_numbers import DIFFERENCE, ObserverNumbers
from cabledrive.rig.closed_loop.plant_kernels import MOST_TERMS

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
ESTIMATES = 12
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
    ``first_end``: sample at which the first pulse and its dwell are over. ``blind``: sensor, first and last
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
    blind: Integers


class LoopState(NamedTuple):
    """Everything that moves, and scratch; arrays, so that a run can go on where another ended.

    ``x``: angles, speeds and shaft torque, then whatever else the plant keeps. ``discrete``: slip, sample of
    the observer's schedule, why the run ended (`DIVERGED`, `WENT_SLACK`; 0: it did not). ``held``: torque of
    the observer's shaft, last command. ``commands``: those not yet at the motor, oldest first.
    """

    x: Array
    discrete: Integers
    estimate: Array
    held: Array
    parameters: Array
    memory: Array
    commands: Array
    states: Array
    readings: Array
    regressor: Array
    terms: Array
    work: Array
    table: Array
    summary: Array


def new_state(
    plant_states: int, observer: ObserverNumbers, law: LawNumbers, rig: RigNumbers, start: Array
) -> LoopState:
    """A loop at rest at angle zero.

    ``plant_states``: number of states of the plant; ``start``, shape (<= 12,): parameter estimates to begin
    with.
    """
    memory = law.matrix.shape[0] if law.kind == LINEAR else 0
    parameters = np.zeros(ESTIMATES)
    parameters[: len(start)] = start
    observed = max(observer.model.shape[0], 2 * len(rig.encoders) if observer.kind == DIFFERENCE else 0)
    scratch = max(plant_states, observed, memory, ESTIMATES)
    return LoopState(
        x=np.zeros(plant_states),
        discrete=np.zeros(3, dtype=np.int64),
        estimate=np.zeros(observed),
        held=np.zeros(2),
        parameters=parameters,
        memory=np.zeros(memory),
        commands=np.zeros(rig.late_samples + 2),
        states=np.zeros(len(observer.chosen)),
        readings=np.zeros(len(rig.encoders)),
        regressor=np.zeros(ESTIMATES),
        terms=np.zeros((MOST_TERMS, plant_states)),
        work=np.zeros(scratch),
        table=np.zeros(work_shape(len(law.matrix) // 2) if law.kind == BACKSTEPPING else (0, 0)),
        summary=np.zeros(len(SUMMARY)),
    )
