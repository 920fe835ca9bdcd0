"""What changes from step to step, in arrays that the methods write into."""

from typing import Any, NamedTuple, TypeVar

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.channels import EXTREMES, TALLIES
from cabledrive.simulation.runs import Integers

MOST_EVENTS = 1000
# Arrays that change from step to step: that of a loop, or of another kind of run.
AnyState = TypeVar("AnyState", bound=tuple[Any, ...])

# Entries of State.counts.
STEPS, EVENTS, UPPER_SLACK, LOWER_SLACK = range(4)

# Entries of State.extra of the energy-conserving scheme: E half a step before the state's time, C, and what
# rounding took from E and from the displacements of drive rim, load rim and motor.
STORED, SHIFT, STORED_LOST, DRIVE_LOST, LOAD_LOST, MOTOR_LOST = range(6)


class State(NamedTuple):
    """Displacements at the time t_j of a step, velocities half a step before it, and what was counted."""

    x: Array  # (3, nodes): u, v, w [m]
    x_t: Array  # (3, nodes): velocities at t_j - step/2 [m/s]
    motor: Array  # (2,): displacement [m] and velocity [m/s] of the motor, at the rim
    tallies: Array  # (2, TALLIES): works and losses [J], and what rounding took from them
    extremes: Array  # (EXTREMES,): see channels
    events: Array  # (MOST_EVENTS, 4): step, span, segment and tension [N] where a span went slack
    counts: Integers  # (4,): steps done, events, whether upper and lower span were slack at the last step
    extra: Array  # what else a method keeps


def new_state(displacement: Array, velocity: Array, motor: tuple[float, float], extra: int = 0) -> State:
    """State at the start of a run.

    ``displacement``, shape (3, nodes): u, v, w [m]; ``velocity``, shape (3, nodes): velocities half a step
    before the start [m/s]; ``motor``: displacement [m] and velocity [m/s] of the motor at the rim; ``extra``:
    numbers a method keeps besides.
    """
    extremes = np.zeros(EXTREMES)
    extremes[0:6:2], extremes[1:6:2] = np.inf, -np.inf
    return State(
        x=np.array(displacement, dtype=np.float64),
        x_t=np.array(velocity, dtype=np.float64),
        motor=np.array(motor, dtype=np.float64),
        tallies=np.zeros((2, TALLIES)),
        extremes=extremes,
        events=np.zeros((MOST_EVENTS, 4)),
        counts=np.zeros(4, dtype=np.int64),
        extra=np.zeros(extra),
    )


def copy_state(state: AnyState) -> AnyState:
    """Copy of a state, of this or another kind, that shares nothing with it."""
    copies: Any = (np.array(array) for array in state)
    return type(state)(*copies)


def set_state(state: AnyState, other: AnyState) -> None:
    """Write another state into this one.

    ``state``: overwritten in place; ``other``: of the same run.
    """
    for mine, theirs in zip(state, other, strict=True):
        mine[...] = theirs
