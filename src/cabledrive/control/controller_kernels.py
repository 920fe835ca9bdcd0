"""The sampled controller as it would run on a target, compiled: filter, law, torque limit.

One state, one step: readings and a reference in, a torque out. The rig reads the encoders and moves
the plant.
"""

from math import isfinite

from cabledrive.control.controller_state import ControllerState
from cabledrive.control.law_kernels import law_step
from cabledrive.control.load_schedule_kernels import announced_load, correct_by_load, predict_by_load
from cabledrive.control.numbers import SCHEDULED, LawNumbers
from cabledrive.control.observer_kernels import correct, predict
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.mechanics.compiled import njit_part
from cabledrive.parameters.arrays import Array

LAST_SAMPLE = 1_000_000_000  # the count stays there: a target runs for years


@njit_part
def observe(observer: ObserverNumbers, c: ControllerState, readings: Array) -> bool:
    """Angles and speeds from the readings; false where one of them is not a number.

    With ideal sensors the states are those that the rig has written.
    """
    if observer.kind == 3:
        correct_by_load(observer, c.parameters[0], c.estimate, readings, c.states, c.work)
    elif observer.kind != 0:
        correct(observer, c.sample[0], c.estimate, readings, c.states, c.work)
    c.sample[0] = min(c.sample[0] + 1, LAST_SAMPLE)
    seen = True
    for i in range(c.states.size):
        seen = seen and isfinite(c.states[i])
    return seen


@njit_part
def issue(
    observer: ObserverNumbers, limit: float, c: ControllerState, torque: float, valid: bool
) -> tuple[float, float]:
    """Limit the law's torque and carry the filter on: command wanted, limited command.

    Without a valid torque the last command is held.
    """
    wanted = torque
    if valid:
        if observer.scalars[8] > 0.0:
            wanted -= c.estimate[observer.places[1]]
        c.held[1] = wanted
    else:
        wanted = c.held[1]
    command = min(max(wanted, -limit), limit)
    newest = c.commands.size - 1
    for i in range(newest):
        c.commands[i] = c.commands[i + 1]
    c.commands[newest] = command
    if observer.kind == 2:
        predict(observer, c.estimate, c.held, c.commands[0], c.commands[1], c.work)
    elif observer.kind == 3:
        predict_by_load(observer, c.parameters[0], c.estimate, c.held, c.commands, c.work)
    return wanted, command


@njit_part
def controller_step(
    observer: ObserverNumbers,
    law: LawNumbers,
    limit: float,
    c: ControllerState,
    readings: Array,
    reference: Array,
    k: int,
) -> tuple[float, float, float, bool]:
    """One sample: command wanted, limited command, sigma, and whether the law had states.

    ``reference[k]`` is the row of this sample. The commands on their way to the motor move up by one, and the
    filter is carried to the next sample.
    """
    if law.kind == SCHEDULED:  # the filter goes by the load of this sample as well
        c.parameters[0] = announced_load(law, reference, k)
    observe(observer, c, readings)
    torque, sigma, valid = law_step(law, c, reference, k)
    wanted, command = issue(observer, limit, c, torque, valid)
    return wanted, command, sigma, valid
