"""Closed loop of a body between two motors: exact geometry, lines that only pull, friction that sticks."""

from typing import NamedTuple

import numpy as np

from cabledrive.control.tension_position import TensionGains, step_in_place
from cabledrive.mechanics.compiled import njit
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors_kernels import TwoMotors, line_at, pulled

# Columns of a record of m coordinates, in this order: place (m), tensions, torques, angles of the drums,
# reshaped, wanted tensions.
COLUMNS = 9


class RigNumbers(NamedTuple):
    """Sampling and sensors."""

    interval: float  # sample time [s]
    substeps: int  # internal steps per sample
    late: int  # delay from sampling to torque, in internal steps
    lag: float  # part of the distance to the commanded torque that remains after an internal step
    counts: Array  # (2,): one count of each drum's encoder [rad]; 0: exact
    phases: Array  # (2,): where in its count each starts
    noise: Array  # (samples, 2): of the load cells [N]


class Body(NamedTuple):
    """What moves, and scratch: places and speeds, shape (m,), angles and speeds of the drums, shape (2,)."""

    q: Array
    v: Array
    angle: Array
    turn: Array
    along: Array  # (2, m): directions of the lines
    tension: Array  # (2,): of the lines [N]


@njit
def close_loop(
    machine: TwoMotors,
    gains: TensionGains,
    state: Array,
    rig: RigNumbers,
    reference: Array,
    force: Array,
    record: Array,
    least: Array,
) -> int:
    """Run all samples of ``reference``, shape (samples, 3 m + 2); returns how many were run.

    ``force``, shape (samples, m): on the body [N]; ``record``, shape (samples, m + 9), takes what happens;
    ``least``, shape (2,): the least tension between samples as well [N]. A number that is not finite ends it.
    """
    m = machine.mass.size
    q, angle, tension, torque = np.zeros(m), np.zeros(2), np.zeros(2), np.zeros(2)
    body = Body(q, np.zeros(m), angle, np.zeros(2), np.zeros((2, m)), tension)
    command, held, measurement = np.zeros(2), np.zeros(2), np.zeros(4)
    state, space, work = state.copy(), np.zeros((2, m)), np.zeros(3 * m + 22)
    pull_of(machine, body)
    for i in range(2):  # at rest the motors hold the lines
        torque[i] = machine.drum[i] * tension[i]
        command[i] = held[i] = torque[i]
    for k in range(len(reference)):
        for i in range(2):
            measurement[i] = counted(angle[i], rig.counts[i], rig.phases[i])
            measurement[2 + i], held[i] = tension[i] + rig.noise[k, i], command[i]
        step_in_place(gains, state, measurement, reference[k], command, space, work)
        for j in range(m):
            record[k, j] = q[j]
            if not abs(q[j]) < 1e6:
                return k
        for i in range(2):
            record[k, m + i], record[k, m + 2 + i] = tension[i], command[i]
            record[k, m + 4 + i], record[k, m + 7 + i] = angle[i], state[3 * m + 7 + i]
        record[k, m + 6] = state[3 * m + 6]
        for s in range(rig.substeps):
            for i in range(2):
                wanted = command[i] if s >= rig.late else held[i]
                torque[i] = wanted + rig.lag * (torque[i] - wanted)
            move(machine, body, rig.interval / rig.substeps, torque, force[k])
            for i in range(2):
                least[i] = min(least[i], tension[i])
    return len(reference)


@njit
def counted(value: float, count: float, phase: float) -> float:
    """Reading of an encoder, rounded to nearest from where it was switched on."""
    return value if count == 0.0 else (np.rint(value / count + phase) - np.rint(phase)) * count


@njit
def pull_of(machine: TwoMotors, body: Body) -> None:
    """Write directions and tensions of both lines."""
    for i in range(2):
        length, free, _ = line_at(machine, i, body.q, body.along[i])
        speed = machine.drum[i] * body.turn[i]
        for j in range(body.q.size):
            speed += body.along[i, j] * body.v[j]
        stretch = length + machine.drum[i] * body.angle[i] - machine.unwound[i]
        body.tension[i] = pulled(stretch, speed, machine.rigidity[i] / free, machine.loss[i] / free)


@njit
def move(m: TwoMotors, body: Body, h: float, torque: Array, force: Array) -> None:
    """One internal step: speeds by the forces, friction set-valued, then places (symplectic)."""
    pull_of(m, body)
    along, tension, v, turn = body.along, body.tension, body.v, body.turn
    for j in range(v.size):
        total = m.force[j] + force[j] - along[0, j] * tension[0] - along[1, j] * tension[1]
        v[j] = rubbed(v[j], total, m.mass[j], m.viscous[j], m.coulomb[j], h)
        body.q[j] += h * v[j]
    for i in range(2):
        total = torque[i] - m.drum[i] * tension[i]
        turn[i] = rubbed(turn[i], total, m.inertia[i], m.turning_viscous[i], m.turning_coulomb[i], h)
        body.angle[i] += h * turn[i]


@njit
def rubbed(speed: float, force: float, mass: float, viscous: float, coulomb: float, h: float) -> float:
    """Speed after a step under a force, with friction that holds what it can hold."""
    free = mass * speed + h * force
    held = h * coulomb
    left = free - held if free > held else (free + held if free < -held else 0.0)
    return left / (mass + h * viscous)
