"""The closed loop as one linear recursion: plant, filter and law, in deviations from the reference."""

from dataclasses import dataclass

import numpy as np

from cabledrive.control.darc import darc_step
from cabledrive.control.numbers import DARC, KALMAN, NOMINAL, LawNumbers, ObserverNumbers
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.chain_plant import linear_step
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import Array, Integers


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearLoop:
    """One step of the loop; states are the plant's, the filter's before its readings, its shaft torque."""

    matrix: Array  # (states, states)
    rounding: Array  # (states, m): from errors of the encoders' readings
    # plant_torque, filter_torque: (states,): from a torque at the plant's motor that the filter does not
    # know, and one that only the filter believes in
    plant_torque: Array
    filter_torque: Array
    command: Array  # (states,): what the law makes of the states [N m]
    command_rounding: Array  # (m,): and of the readings' errors at once
    size: int  # number of inertias

    def noise(self, counts: Array, samples: int) -> tuple[float, float]:
        """Deviations of motor speed [rad/s] and command [N m] by white rounding of ``counts`` [rad]."""
        variance = counts**2 / 12.0
        speed = response(self.matrix, self.rounding, self.motor_speed, samples)
        command = response(self.matrix, self.rounding, self.command, samples)
        power = (command**2).sum(axis=0) + self.command_rounding**2
        return float(np.sqrt((speed**2).sum(axis=0) @ variance)), float(np.sqrt(power @ variance))

    @property
    def load_angle(self) -> Array:
        """Picks the load's angle from the states."""
        row = np.zeros(len(self.matrix))
        row[self.size - 1] = 1.0
        return row

    @property
    def motor_speed(self) -> Array:
        """Picks the motor's speed from the states."""
        row = np.zeros(len(self.matrix))
        row[self.size] = 1.0
        return row


def feedback_row(law: LawNumbers) -> Array:
    """Command of a law of the chain per angle and speed, estimates as they start, shape (2n,)."""
    if law.kind != DARC:
        raise InputRefused("the linear loop is made of the laws of the chain: take darc-4-damped, or another")
    count = law.matrix.shape[0]
    frozen = law.learning[NOMINAL].copy()
    frozen[2:] = 0.0
    return np.array([darc_step(law, frozen, unit, np.zeros(count + 3)).command for unit in np.eye(count)])


def linear_loop(loop: Loop, chain: LumpedChain | None = None) -> LinearLoop:
    """Linear recursion of a loop with the filter's settled gain, the motor slipping."""
    seen, rig = loop.observer, loop.rig
    if seen.kind != KALMAN or rig.late_samples or rig.late_part > 0.0 or loop.cable is not None:
        raise InputRefused(
            "the linear loop is made for a lumped chain and a Kalman filter without delay: "
            "leave the others out"
        )
    rate = loop.plant.current_rate
    table = linear_step(chain or loop.chain, rig.interval, rate)
    return assembled(table, rate, seen, loop.controller.law, rig.encoders)


def assembled(
    table: Array, rate: float, seen: ObserverNumbers, law: LawNumbers, encoders: Integers
) -> LinearLoop:
    """Plant's table, shape (m, m + 3), filter and law put together; ``rate``: of the torque [rad/s]."""
    size, m, states = len(table) // 2, len(table), seen.model.shape[0]
    step, by_command, by_motor = table[:, :m].copy(), table[:, m], table[:, m + 1]
    if rate == 0.0:  # without torque loop, torque is command
        by_command = by_command + step[:, m - 1]
        step[:, m - 1] = 0.0
    reads = np.zeros((len(encoders), m))
    reads[np.arange(len(encoders)), encoders] = 1.0
    total, gain = m + states + 1, seen.gains[-1]
    corrected = np.zeros((states, total))
    corrected[:, :m] = gain @ reads
    corrected[:, m : m + states] = np.eye(states) - gain @ seen.output
    feedback = np.zeros(states)
    feedback[seen.chosen] = feedback_row(law)
    if seen.scalars[8] > 0.0:
        feedback[seen.places[1]] -= 1.0
    command, at_once = feedback @ corrected, feedback @ gain
    held, newest = seen.scalars[2], seen.scalars[4]
    inner, last = slice(m, m + states), total - 1
    matrix, rounding = np.zeros((total, total)), np.zeros((total, len(encoders)))
    matrix[:m, :m] = step
    matrix[:m] += np.outer(by_command, command)
    matrix[inner] = seen.model[:, :states] @ corrected + np.outer(seen.model[:, states + 2], command)
    matrix[inner, last] += seen.model[:, states]
    matrix[last] = newest * command
    matrix[last, last] += held
    rounding[:m] = np.outer(by_command, at_once)
    rounding[inner] = seen.model[:, :states] @ gain + np.outer(seen.model[:, states + 2], at_once)
    rounding[last] = newest * at_once
    plant_torque, filter_torque = np.zeros(total), np.zeros(total)
    plant_torque[:m], filter_torque[inner] = by_motor, seen.model[:, states + 3]
    return LinearLoop(
        matrix=matrix,
        rounding=rounding,
        plant_torque=plant_torque,
        filter_torque=filter_torque,
        command=command,
        command_rounding=at_once,
        size=size,
    )


def response(matrix: Array, start: Array, output: Array, samples: int) -> Array:
    """Output of a recursion after an impulse in each of its inputs, shape (samples, inputs)."""
    found, state = np.zeros((samples, start.shape[1])), start.copy()
    for k in range(samples):
        found[k] = output @ state
        state = matrix @ state
    return found


def driven(matrix: Array, forcing: Array, output: Array) -> Array:
    """Output from rest, shape (samples,), under a ``forcing``, shape (samples, k), of the first k states."""
    state, found, k = np.zeros(len(matrix)), np.zeros(len(forcing)), forcing.shape[1]
    for i, push in enumerate(forcing):
        found[i] = output @ state
        state = matrix @ state
        state[:k] += push
    return found
