r"""Compiled time integration of the energy-conserving scheme.

The energy of the cable is split into the quadratic one of the linear law and the rest :math:`V(x)`, for the
exact law :math:`\tfrac12 EA \int (\lambda^2 - u'^2)\,dx`. A scalar :math:`\psi` stands for
:math:`\sqrt{2(V + C)}`, and every step is one of Stoermer-Verlet in which the nonlinear forces
:math:`F = -\nabla V` are scaled by its mean over the step (L.1)-(L.3):

.. math::
    M\,\frac{\dot x_{j+1/2} - \dot x_{j-1/2}}{\Delta t}
        &= F_{lin}(x_j) + c_j F(x_j) + \dots, \qquad
    c_j = \frac{\psi_{j+1/2} + \psi_{j-1/2}}{2\sqrt{2(V(x_j) + C)}} \\
    E_{j+1/2} - E_{j-1/2} &= -c_j F(x_j)\cdot\frac{x_{j+1} - x_{j-1}}{2} \\
    \psi &= \sqrt{2(E + C)}

Whatever the rest of the step does, damping and friction included,
:math:`\tfrac12 \dot x^T M \dot x + \tfrac12 x_j^T K x_{j+1} + E` changes by the work done on it and no more.

Equal segments under the exact law take a quick loop as long as they are taut; everything else takes the long
one, in which a step is repeated until force scale and velocities agree.
"""

from math import sqrt

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.simulation.channels import BALANCE, TALLIES
from cabledrive.simulation.kernels.axial_damping import strain_directions
from cabledrive.simulation.kernels.energy_equal_segments import MOST_TRIALS, SETTLED, integrate_equal_segments
from cabledrive.simulation.kernels.nodes import damp_axially, kick_nodes, tally_nodes, turn
from cabledrive.simulation.kernels.nonlinear_energy import (
    answer_of,
    nonlinear_energy,
    own_balance,
    stretching,
    take_linear,
)
from cabledrive.simulation.kernels.observe import record
from cabledrive.simulation.kernels.segments import EXACT, segment_tensions
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.kernels.steps import (
    copy_rows,
    keep_before,
    keep_extremes,
    note_slack,
    shaft_forces,
    tally_shafts,
)
from cabledrive.simulation.kernels.stored_energy import raised_shift, sum_with_loss
from cabledrive.simulation.kernels.taut_steps import rows_of
from cabledrive.simulation.plan import INVERSE_SPACING, RADIUS, Plan, check_kernel_law
from cabledrive.simulation.state import (
    DRIVE_LOST,
    LOAD_LOST,
    LOWER_SLACK,
    MOTOR_LOST,
    SHIFT,
    STEPS,
    STORED,
    STORED_LOST,
    UPPER_SLACK,
    State,
)
from cabledrive.simulation.workspace import Workspace

DONE, SLACK, NOT_FINITE = range(3)


def integrate(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """Take a step per entry of ``torque``; as `cabledrive.simulation.kernels.verlet.integrate`.

    ``plan``, ``state``, ``work``, ``torque``, ``forces``, ``every``, ``rows``, ``fields``: see
    `cabledrive.simulation.method.Method.integrate`.
    Returns DONE, SLACK or NOT_FINITE.
    """
    check_kernel_law(plan)
    j, finite, quick = 0, True, plan.uniform and plan.law == EXACT
    lines = rows_of(state)
    rest, lost = np.zeros(work.p.shape), np.zeros((2, TALLIES))
    while True:
        if quick:
            j, finite = integrate_equal_segments(plan, state, work, torque, every, rows, fields, j, *lines)
        if j >= torque.size or not finite:
            return DONE if finite else NOT_FINITE
        stop = j - j % every + every if quick else torque.size
        code = integrate_any(
            plan, state, work, rest, lost, torque[:stop], forces[:stop], every, rows, fields, j
        )
        if code != DONE:
            return code
        j = stop


@njit_in_place
def integrate_any(
    plan: Plan,
    state: State,
    work: Workspace,
    rest: Array,
    lost: Array,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
    first: int,
) -> int:
    """As `integrate` from step ``first``, for every law and every drive, slack or not.

    ``rest`` (3, segments) and ``lost`` (2, TALLIES) are room for nonlinear components and losses of a trial.
    """
    x, x_t, motor, tallies = state.x, state.x_t, state.motor, state.tallies
    for j in range(first, torque.size):
        recording = j % every == 0
        stored = state.extra[STORED]
        if recording:
            keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)
        if _is_slack(plan, state, work):
            return SLACK
        _long_step(plan, state, work, rest, lost, torque[j], forces[j])
        if recording:
            row = rows[j // every]
            record(plan, work, x_t, motor, tallies, torque[j], row)
            row[BALANCE] += own_balance(plan, work, x_t, 0.5 * (stored + state.extra[STORED]))
            if fields.shape[0] > 0:
                copy_rows(work.before[0], fields[j // every])
            if not abs(row[BALANCE]) < 1e300:
                return NOT_FINITE
    return DONE


@njit_in_place
def _is_slack(plan: Plan, state: State, work: Workspace) -> bool:
    """Components of all segments; whether a slack one stops the run."""
    keep_extremes(plan.segments, plan.spans, plan.probe, state.x, state.motor, state.extremes)
    slack = segment_tensions(
        plan.law, False, plan.pretension, plan.rigidity, state.x, plan.segment[INVERSE_SPACING], work.p
    )
    if slack > 0 or state.counts[UPPER_SLACK] + state.counts[LOWER_SLACK] > 0:
        note_slack(plan, state.x, state.events, state.counts)
    return plan.stop_when_slack and slack > 0


@njit_in_place
def _long_step(
    plan: Plan, state: State, work: Workspace, rest: Array, lost: Array, torque: float, forces: Array
) -> None:
    """One step for every law and every drive, Eqs. (L.1)-(L.3); the components are in ``work.p``."""
    x, x_t, motor, extra, shaft = state.x, state.x_t, state.motor, state.extra, work.shaft
    place, speed = motor[0], motor[1]
    take_linear(plan, x, work.p, rest, -1.0)
    if plan.axial_damping > 0.0:
        strain_directions(plan, x, work.direction)
    energy = nonlinear_energy(plan, x)
    extra[SHIFT] = raised_shift(extra[SHIFT], min(energy, extra[STORED]))
    root, psi = sqrt(2.0 * (energy + extra[SHIFT])), sqrt(2.0 * (extra[STORED] + extra[SHIFT]))
    scale = 0.5 * plan.step / root
    answer = 0.5 * scale / root * answer_of(plan, rest)
    push = torque / plan.shaft[RADIUS, 0]
    change, result = 0.0, 0.0
    for trial in range(MOST_TRIALS):
        if trial > 0:
            copy_rows(work.old, x_t)
            motor[0], motor[1] = place, speed
        for k in range(TALLIES):
            lost[0, k], lost[1, k] = 0.0, 0.0
        for axis in range(3):
            for i in range(rest.shape[1]):
                work.p[axis, i] = (psi + 0.5 * change) / root * rest[axis, i]
        take_linear(plan, x, work.p, work.p, 1.0)
        shaft_forces(
            plan.closed, plan.segments, plan.joint_stiffness, plan.shaft, plan.node, x, x_t, motor, work.p,
            plan.driven, push, shaft,
        )  # fmt: skip
        kick_nodes(plan, x_t, work.old, work.p, forces)
        if plan.axial_damping > 0.0:
            damp_axially(plan, x, x_t, motor, lost, work)
        else:
            turn(plan, plan.shaft_matrices[0], x_t, motor, shaft)
        result = scale * (stretching(rest, work.old) + stretching(rest, x_t))
        if abs(result - change) <= SETTLED * abs(result) or trial == MOST_TRIALS - 1:
            break
        change += (result - change) / (1.0 + answer)
    extra[STORED] = sum_with_loss(extra, STORED_LOST, extra[STORED], result * (psi + 0.5 * change))
    tally_nodes(plan, x_t, work.old, state.tallies, forces)
    tally_shafts(plan.step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, state.tallies)
    for k in range(TALLIES):
        if lost[0, k] != 0.0:
            add_to(state.tallies, k, lost[0, k])
    _drift(plan, x, x_t, extra)
    motor[0] = sum_with_loss(extra, MOTOR_LOST, place, plan.step * motor[1])
    state.counts[STEPS] += 1


@njit_in_place
def _drift(plan: Plan, x: Array, x_t: Array, extra: Array) -> None:
    """Displacements after the step."""
    n, last = plan.segments, x.shape[1] - 1
    drive = sum_with_loss(extra, DRIVE_LOST, x[0, 0], plan.step * x_t[0, 0])
    load = sum_with_loss(extra, LOAD_LOST, x[0, n], plan.step * x_t[0, n])
    for axis in range(3):
        for i in range(x.shape[1]):
            x[axis, i] += plan.step * x_t[axis, i]
    x[0, 0], x[0, n] = drive, load
    if plan.closed:
        x[0, last] = drive
