"""Compiled time integration of the node-centred scheme.

Interior nodes follow the equations of motion as written out, with central differences at the node; the rims
take the tension half a segment away, and carry the half cells in between.
"""

from math import sqrt

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.simulation.channels import BALANCE, TRANSVERSE_LOSS
from cabledrive.simulation.kernels.observe import record
from cabledrive.simulation.kernels.segments import EXACT, LINEAR, WEAK, segment_tensions
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.kernels.steps import (
    copy_rows,
    keep_before,
    keep_extremes,
    note_slack,
    shaft_forces,
    tally_shafts,
    turn_shafts,
)
from cabledrive.simulation.plan import (
    DRAG,
    FALL_U,
    FALL_W,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    RADIUS,
    Plan,
    check_kernel_law,
)
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
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
    """Take a step per entry of ``torque``; as `cabledrive.simulation.kernels.verlet.integrate`."""
    check_kernel_law(plan)
    return integrate_nodes(plan, state, work, torque, forces, every, rows, fields)


@njit_in_place
def integrate_nodes(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """As `integrate`, compiled: steps of Eqs. (2.32) and (2.35)-(2.38)."""
    step, closed, n = plan.step, plan.closed, plan.segments
    x, x_t, motor, tallies, p, shaft = state.x, state.x_t, state.motor, state.tallies, work.p, work.shaft
    matrix, back = plan.shaft_matrices[0], plan.shaft_matrices[1]
    inverse_spacing, radius = plan.segment[INVERSE_SPACING], plan.shaft[RADIUS, 0]
    for j in range(torque.size):
        keep_extremes(n, plan.spans, plan.probe, x, motor, state.extremes)
        recording = j % every == 0
        if recording:
            keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)
        slack = segment_tensions(plan.law, False, plan.pretension, plan.rigidity, x, inverse_spacing, p)
        if slack > 0 or state.counts[UPPER_SLACK] + state.counts[LOWER_SLACK] > 0:
            note_slack(plan, x, state.events, state.counts)
            if plan.stop_when_slack and slack > 0:
                return SLACK
        push = torque[j] / radius
        shaft_forces(
            closed, n, plan.joint_stiffness, plan.shaft, plan.node, x, x_t, motor, p, plan.driven, push, shaft
        )
        _kick_nodes(plan, x, x_t, tallies, work.mean)
        turn_shafts(step, closed, n, matrix, back, plan.shaft, motor, x_t, shaft)
        for axis in range(3):
            for i in range(x.shape[1]):
                x[axis, i] += step * x_t[axis, i]
        tally_shafts(step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, tallies)
        state.counts[STEPS] += 1
        if recording:
            row = rows[j // every]
            record(plan, work, x_t, motor, tallies, torque[j], row)
            if fields.shape[0] > 0:
                copy_rows(work.before[0], fields[j // every])
            if not abs(row[BALANCE]) < 1e300:
                return NOT_FINITE
    return DONE


@njit_in_place
def _kick_nodes(plan: Plan, x: Array, x_t: Array, tallies: Array, gained: Array) -> None:
    """New velocities of the nodes between the rims, from the equations of motion as written out.

    First and second differences at the nodes, Eqs. (2.33) and (2.34).
    """
    h = plan.segment[INVERSE_SPACING, 0]
    c_u2, c_w2 = (plan.rigidity + plan.pretension) / plan.density, plan.pretension / plan.density
    squares = 0.0
    for i in range(1, x.shape[1] - 1):
        if i == plan.segments:
            continue
        u_x, u_xx = 0.5 * h * (x[0, i + 1] - x[0, i - 1]), h * h * (x[0, i + 1] - 2.0 * x[0, i] + x[0, i - 1])
        v_x, v_xx = 0.5 * h * (x[1, i + 1] - x[1, i - 1]), h * h * (x[1, i + 1] - 2.0 * x[1, i] + x[1, i - 1])
        w_x, w_xx = 0.5 * h * (x[2, i + 1] - x[2, i - 1]), h * h * (x[2, i + 1] - 2.0 * x[2, i] + x[2, i - 1])
        # T' and T / (1 + lambda), both over rho, and the strain's derivative
        if plan.law == EXACT:
            stretch = sqrt((1.0 + u_x) ** 2 + v_x * v_x + w_x * w_x)
            strain_x = ((1.0 + u_x) * u_xx + v_x * v_xx + w_x * w_xx) / stretch
            across = (c_w2 + c_u2 * (stretch - 1.0)) / stretch
            turning = (c_u2 - across) * strain_x / stretch
            a_u, a_v, a_w = turning * (1.0 + u_x) + across * u_xx, turning * v_x, turning * w_x
        elif plan.law == LINEAR:
            across = c_w2
            a_u, a_v, a_w = c_u2 * u_xx, 0.0, 0.0
        else:
            strain = u_x + 0.5 * (v_x * v_x + w_x * w_x)
            strain_x = u_xx + v_x * v_xx + w_x * w_xx
            if plan.law == WEAK:
                across = (c_w2 + c_u2 * strain) / (1.0 + strain)
                turning = (c_u2 - across) * strain_x / (1.0 + strain)
                a_u, a_v, a_w = turning * (1.0 + u_x) + across * u_xx, turning * v_x, turning * w_x
            else:
                across = c_w2 + c_u2 * strain
                turning = c_u2 * strain_x
                a_u, a_v, a_w = turning, turning * v_x, turning * w_x
        gained[0, i] = plan.step * a_u + plan.node[FALL_U, i]
        damped = plan.step * plan.node[KICK_T, i] / plan.node[KICK_U, i]
        gained[1, i] = damped * (a_v + across * v_xx)
        gained[2, i] = damped * (a_w + across * w_xx) + plan.node[FALL_W, i]
    for i in range(1, x.shape[1] - 1):
        if i == plan.segments:
            continue
        x_t[0, i] += gained[0, i]
        for axis in range(1, 3):
            speed = plan.node[KEEP_T, i] * x_t[axis, i] + gained[axis, i]
            squares += plan.node[DRAG, i] * (speed + x_t[axis, i]) ** 2
            x_t[axis, i] = speed
    add_to(tallies, int(TRANSVERSE_LOSS), 0.25 * plan.step * squares)
