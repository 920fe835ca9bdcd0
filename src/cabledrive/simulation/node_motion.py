"""New speeds of nodes and coordinates over a step, with axial damping solved for, compiled."""

from math import sqrt

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_inner
from cabledrive.simulation import damped as of
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import AXIAL_LOSS, FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.coordinates import end_moved, gather, invert, turn
from cabledrive.simulation.observe import add_to, copy_rows
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import end_pulls


@njit_inner
def move(
    plan: Plan, centred: Array | None, state: State, work: Workspace, torque: Array, forces: Array
) -> None:
    """New speeds of nodes and coordinates under the components in ``work.p``."""
    if centred is not None:
        kick_centred(plan, state.x, state.x_t, work.old)
    else:
        kick_nodes(plan, state.x_t, work, forces)
    end_pulls(plan, work.p, work)
    gather(plan, state.q, torque, work)
    turn_and_damp(plan, state.q_t, state.x_t, state.tallies, work)


@njit_inner
def kick_nodes(plan: Plan, x_t: Array, work: Workspace, forces: Array) -> None:
    """New speeds of all nodes but the rims, without axial damping; the old ones are kept."""
    node = plan.node
    one = np.uintp(1)  # an index that might be negative would keep from taking many nodes at once
    for axis in range(3):
        speed, kept, pull = x_t[axis], work.old[axis], work.p[axis]
        kick, keep = node[at.KICK_U], node[at.KEEP_T]
        kept[0], kept[pull.size] = speed[0], speed[pull.size]
        if axis > 0:
            kick = node[at.KICK_T]
        for before in range(np.uintp(pull.size) - one):
            i = before + one
            kept[i] = speed[i]
            speed[i] = (keep[i] if axis > 0 else 1.0) * speed[i] + kick[i] * (pull[i] - pull[before])
    along, across, fall_u, fall_w = x_t[0], x_t[2], node[at.FALL_U], node[at.FALL_W]
    for node_number in range(along.size):
        along[node_number] += fall_u[node_number]
        across[node_number] += fall_w[node_number]
    for k in range(plan.force.shape[0]):
        i, axis = plan.force[k, 0], plan.force[k, 1]
        x_t[axis, i] += node[at.KICK_U if axis == 0 else at.KICK_T, i] * forces[k]


@njit_inner
def turn_and_damp(plan: Plan, q_t: Array, x_t: Array, tallies: Array, work: Workspace) -> None:
    """New speeds of the coordinates, with axial damping those of the nodes as well."""
    if plan.axial != of.UNDAMPED:
        damp_axially(plan, q_t, x_t, tallies, work)
    else:
        turn(plan, q_t, plan.inverse, plan.rub_mobility, plan.rub_own, work)


@njit_inner
def finish(plan: Plan, state: State, work: Workspace, forces: Array) -> None:
    """Displacements after the step, with the work of the forces and the transverse loss over it."""
    x, x_t, old, tallies = state.x, state.x_t, work.old, state.tallies
    for k in range(plan.force.shape[0]):
        i, axis = plan.force[k, 0], plan.force[k, 1]
        add_to(tallies, int(FORCE_WORK), plan.step * forces[k] * 0.5 * (old[axis, i] + x_t[axis, i]))
    squares = 0.0
    for axis in range(3):
        place, speed = x[axis], x_t[axis]
        for i in range(place.size):
            place[i] += plan.step * speed[i]
        if axis > 0:
            drag, slow = plan.node[at.DRAG], old[axis]
            for i in range(place.size):
                squares += drag[i] * (slow[i] + speed[i]) ** 2
    if squares > 0.0:
        add_to(tallies, int(TRANSVERSE_LOSS), 0.25 * plan.step * squares)


@njit_inner
def slopes(place: Array, i: int, inverse: float) -> tuple[float, float]:
    """First and second derivative along the rope at a node, by central differences [-], [1/m]."""
    before, here, behind = place[i - 1], place[i], place[i + 1]
    return 0.5 * inverse * (behind - before), inverse * inverse * (behind - 2.0 * here + before)


@njit_inner
def kick_centred(plan: Plan, x: Array, x_t: Array, old: Array) -> None:
    """New speeds from the equations of motion written out at the nodes, Eqs. (2.33) and (2.34)."""
    node, law = plan.node, plan.law
    bent = 0.0 if law == at.LINEAR else 1.0
    copy_rows(x_t, old)
    for piece in range(plan.nodes.shape[0]):
        pretension, rigidity = plan.piece[piece, at.PRETENSION], plan.piece[piece, at.RIGIDITY]
        for i in range(plan.nodes[piece, 0] + 1, plan.nodes[piece, 1]):
            inverse = plan.segment[at.INVERSE_SPACING, i]
            density = node[at.MASS, i] * inverse
            c_u2, c_w2 = (rigidity + pretension) / density, pretension / density
            u_x, u_xx = slopes(x[0], i, inverse)
            v_x, v_xx = slopes(x[1], i, inverse)
            w_x, w_xx = slopes(x[2], i, inverse)
            # stretch, its derivative, T over rho and over the stretch; the linear law has neither
            stretch, strain_x = 1.0 + u_x + 0.5 * bent * (v_x * v_x + w_x * w_x), v_x * v_xx + w_x * w_xx
            strain_x += u_xx
            if law == at.EXACT:
                stretch = sqrt((1.0 + u_x) ** 2 + v_x * v_x + w_x * w_x)
                strain_x = (strain_x + u_x * u_xx) / stretch
            if law == at.EXACT or law == at.WEAK:
                across = (c_w2 + c_u2 * (stretch - 1.0)) / stretch
                turning = (c_u2 - across) * strain_x / stretch
                along = turning * (1.0 + u_x) + across * u_xx
            else:
                across = c_w2 + bent * c_u2 * (stretch - 1.0)
                turning = bent * c_u2 * strain_x
                along = turning if bent > 0.0 else c_u2 * u_xx
            kick, keep = plan.step * node[at.KICK_T, i] / node[at.KICK_U, i], node[at.KEEP_T, i]
            x_t[0, i] += plan.step * along + node[at.FALL_U, i]
            x_t[1, i] = keep * x_t[1, i] + kick * (turning * v_x + across * v_xx)
            x_t[2, i] = keep * x_t[2, i] + kick * (turning * w_x + across * w_xx) + node[at.FALL_W, i]


@njit_inner
def damp_axially(plan: Plan, q_t: Array, x_t: Array, tallies: Array, work: Workspace) -> None:
    r"""Kelvin-Voigt damping, implicit: an unknown tension per segment, together with the coordinates' speeds.

    The damping tension of a segment, :math:`q = \beta\,d\cdot\Delta V`, acts along :math:`d` of
    `strain_directions`; V is the mean velocity, which q itself changes. Each piece answers to the speeds of
    its ends along its first and last segment with :math:`q = q_0 + q_a V_a + q_b V_b`.
    """
    d, q, node, n = work.direction, work.damp, plan.node, q_t.size
    for axis in range(3):
        for i in range(x_t.shape[1]):
            work.mean[axis, i] = 0.5 * (work.old[axis, i] + x_t[axis, i])
    # the plan holds the answers of straight ropes, for which those of bent ones stand here
    for i in range(n):
        for k in range(n):
            work.matrix[i, k] = plan.matrix[i, k] - 0.5 * plan.dampers[i, k]
    for piece in range(plan.nodes.shape[0]):
        solve_span(plan, plan.nodes[piece, 0], plan.nodes[piece, 1], work)
        for side in range(2):
            answer_of_end(plan, piece, side, q_t, work)
    invert(work.matrix, plan, work.inverse, work.mobility, work.own)
    turn(plan, q_t, work.inverse, work.mobility, work.own, work)
    loss = 0.0
    for piece in range(plan.nodes.shape[0]):
        first, last, power = plan.nodes[piece, 0], plan.nodes[piece, 1], 0.0
        start, end = end_speed(plan, piece, 0, q_t, work, 0.5), end_speed(plan, piece, 1, q_t, work, 0.5)
        for i in range(first, last):
            q[0, i] += q[1, i] * start + q[2, i] * end
            power += plan.segment[at.COMPLIANCE, i] * q[0, i] ** 2
        loss += plan.piece[piece, at.ROPES] * power
    add_to(tallies, int(AXIAL_LOSS), plan.step * loss)
    for axis in range(3):
        kick = node[at.KICK_U if axis == 0 else at.KICK_T]
        for i in range(1, q.shape[1]):
            x_t[axis, i] += kick[i] * (d[axis, i] * q[0, i] - d[axis, i - 1] * q[0, i - 1])


@njit_inner
def answer_of_end(plan: Plan, piece: int, side: int, q_t: Array, work: Workspace) -> None:
    """What the damper at one end of a piece does to the coordinates: to their forces and to their matrix."""
    d, q, first, last = work.direction, work.damp, plan.nodes[piece, 0], plan.nodes[piece, 1] - 1
    segment, sign = (first, 1.0) if side == 0 else (last, -1.0)
    for row in range(6 * piece + 3 * side, 6 * piece + 3 * side + 3):
        pull = sign * plan.piece[piece, at.ROPES] * d[row % 3, segment]
        for entry in range(plan.row_start[row], plan.row_start[row + 1]):
            own, felt = plan.row_column[entry], pull * plan.row_value[entry]
            work.force[own] += felt * q[0, segment]
            for other in range(6):
                answer = 0.5 * felt * q[1 + other // 3, segment] * d[other % 3, first if other < 3 else last]
                beyond = 6 * piece + other
                for place in range(plan.row_start[beyond], plan.row_start[beyond + 1]):
                    column, part = plan.row_column[place], answer * plan.row_value[place]
                    work.force[own] += 2.0 * part * q_t[column]
                    work.matrix[own, column] -= part


@njit_inner
def end_speed(plan: Plan, piece: int, side: int, q_t: Array, work: Workspace, share: float) -> float:
    """Old speed of an end of a piece along its segment there, times a share, and half of the new one."""
    segment, speed = plan.nodes[piece, 1] - 1 if side == 1 else plan.nodes[piece, 0], 0.0
    for axis in range(3):
        row = 6 * piece + 3 * side + axis
        moved = share * end_moved(plan, row, q_t) + 0.5 * end_moved(plan, row, work.new)
        speed += work.direction[axis, segment] * moved
    return speed


@njit_inner
def solve_span(plan: Plan, first: int, last: int, work: Workspace) -> None:
    """Damping tensions of a piece, tridiagonal: constant part, answers to its ends, 1 / pivots."""
    d, q, link = work.direction, work.damp, 0.0
    if plan.segment[at.COMPLIANCE, first] == 0.0:  # nothing damps it
        for k in range(3):
            q[k, first:last] = 0.0
        return
    for i in range(first, last):
        own, rate, link = plan.segment[at.COMPLIANCE, i], 0.0, 0.0
        for axis in range(3):
            kick = plan.node[at.KICK_U if axis == 0 else at.KICK_T]
            if i > first:
                own += 0.5 * kick[i] * d[axis, i] ** 2
                rate -= d[axis, i] * work.mean[axis, i]
                link -= 0.5 * kick[i] * d[axis, i - 1] * d[axis, i]
            if i < last - 1:
                own += 0.5 * kick[i + 1] * d[axis, i] ** 2
                rate += d[axis, i] * work.mean[axis, i + 1]
        q[0, i] = rate
        q[1, i] = 0.0 if i > first else -1.0
        q[2, i] = 0.0 if i < last - 1 else 1.0
        if i > first:  # eliminate the segment before
            share = link * q[3, i - 1]
            own -= share * link
            for k in range(3):
                q[k, i] -= share * q[k, i - 1]
        q[3, i] = 1.0 / own
    for i in range(last - 1, first - 1, -1):
        link = 0.0
        for axis in range(3 if i < last - 1 else 0):
            kick = plan.node[at.KICK_U if axis == 0 else at.KICK_T]
            link -= 0.5 * kick[i + 1] * d[axis, i] * d[axis, i + 1]
        for k in range(3):
            q[k, i] -= link * q[k, min(i + 1, last - 1)]
            q[k, i] *= q[3, i]
