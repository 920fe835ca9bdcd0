"""A controller of the user's own as firmware calls it: the same start, hold and filter as a packaged law."""

from collections.abc import Callable
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.controller_kernels import LAST_SAMPLE, issue, observe
from cabledrive.control.controller_state import ControllerState
from cabledrive.control.numbers import LawNumbers
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.control.target_kernels import new_target_state
from cabledrive.parameters.arrays import Array


class OwnTargetState(NamedTuple):
    """As `target_kernels.TargetState`, with copies that the user's step may change."""

    controller: ControllerState
    datum: Array
    readings: Array
    missed: NDArray[np.int64]
    memory: Array
    measurement: Array
    row: Array


def new_own_target_state(
    observer: ObserverNumbers, law: LawNumbers, late_samples: int, memory: Array, columns: int, filtered: bool
) -> OwnTargetState:
    """A controller before its start; ``memory``, shape (m,): how many numbers it keeps."""
    plain = new_target_state(observer, law, late_samples)
    controller = plain.controller._replace(memory=np.zeros(len(memory)))
    seen = len(observer.chosen) if filtered else len(observer.output)
    return OwnTargetState(
        controller, *plain[1:], np.zeros(len(memory)), np.zeros(seen), np.zeros(columns)
    )  # fmt: skip


def start_own(start: Array, t: OwnTargetState, readings: Array) -> None:
    """Start at rest at the angles read, which become zero; ``start``: memory to begin with."""
    for i in range(start.size):
        t.controller.memory[i] = start[i]
    for j in range(readings.size):
        t.datum[j] = readings[j]


def own_target_step(step: Any, filtered: bool) -> Callable[..., tuple[float, bool]]:
    """The kernel of a target around a step of the user's; ``filtered``: it takes states, not readings.

    The rig runs the same order of work in `cabledrive.rig.closed_loop.own_kernels`.
    """

    def own_step(
        observer: Any, own_gains: Any, limit: float, t: Any, readings: Array, reference: Array
    ) -> tuple[float, bool]:
        """One sample: limited command [N m], and whether it was computed; else the last one is held."""
        known = True
        for i in range(reference.shape[1]):
            known = known and isfinite(reference[0, i])
        for j in range(readings.size):
            if not isfinite(t.datum[j]) and isfinite(readings[j]):
                t.datum[j] = readings[j]
            t.readings[j] = readings[j] - t.datum[j]
            known = known and isfinite(t.readings[j])
        seen = observe(observer, t.controller, t.readings)
        torque, valid = 0.0, False
        if known and seen:
            for i in range(t.memory.size):
                t.memory[i] = t.controller.memory[i]
            for i in range(t.measurement.size):
                t.measurement[i] = t.controller.states[i] if filtered else t.readings[i]
            for i in range(t.row.size):
                t.row[i] = reference[0, i]
            fresh, torque = step(own_gains, t.memory, t.measurement, t.row)
            valid = isfinite(torque)
            for i in range(t.memory.size):
                valid = valid and isfinite(fresh[i])
            if valid:
                for i in range(t.memory.size):
                    t.controller.memory[i] = fresh[i]
        _, command = issue(observer, limit, t.controller, torque, valid)
        t.missed[0] = 0 if valid else min(t.missed[0] + 1, LAST_SAMPLE)
        return command, valid

    return own_step
