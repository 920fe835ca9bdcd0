"""Compiled parts of a step in which every node has its own mass: kick, shafts, axial damping, tallies."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.channels import AXIAL_LOSS, FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.kernels.axial_damping import solve_span
from cabledrive.simulation.kernels.shafts import SHAFTS, add_to
from cabledrive.simulation.kernels.steps import turn_shafts
from cabledrive.simulation.plan import (
    COMPLIANCE,
    DRAG,
    FALL_U,
    FALL_W,
    KEEP_T,
    KICK_T,
    KICK_U,
    Plan,
)
from cabledrive.simulation.workspace import FORCE, NEW, OLD, Workspace


@njit_in_place
@for_kernels
def turn(plan: Plan, matrix: Array, x_t: Array, motor: Array, shaft: Array) -> None:
    """New speeds of the shafts under a matrix of inertias and dampings."""
    back = plan.shaft_matrices[1]
    turn_shafts(plan.step, plan.closed, plan.segments, matrix, back, plan.shaft, motor, x_t, shaft)


@njit_in_place
@for_kernels
def kick_nodes(plan: Plan, x_t: Array, old: Array, p: Array, forces: Array) -> None:
    """New velocities of all nodes but the rims, without axial damping; the old ones are kept."""
    node = plan.node
    for axis in range(3):
        for i in range(x_t.shape[1]):
            old[axis, i] = x_t[axis, i]
    for i in range(1, p.shape[1]):
        x_t[0, i] += node[KICK_U, i] * (p[0, i] - p[0, i - 1]) + node[FALL_U, i]
        x_t[1, i] = node[KEEP_T, i] * x_t[1, i] + node[KICK_T, i] * (p[1, i] - p[1, i - 1])
        x_t[2, i] = node[KEEP_T, i] * x_t[2, i] + node[KICK_T, i] * (p[2, i] - p[2, i - 1]) + node[FALL_W, i]
    for k in range(plan.force.shape[0]):
        i, axis = plan.force[k, 0], plan.force[k, 1]
        x_t[axis, i] += node[KICK_U if axis == 0 else KICK_T, i] * forces[k]


@njit_in_place
@for_kernels
def tally_nodes(plan: Plan, x_t: Array, old: Array, tallies: Array, forces: Array) -> None:
    """Work of the forces and transverse loss over the step."""
    for k in range(plan.force.shape[0]):
        i, axis = plan.force[k, 0], plan.force[k, 1]
        add_to(tallies, int(FORCE_WORK), plan.step * forces[k] * 0.5 * (old[axis, i] + x_t[axis, i]))
    squares = 0.0
    for i in range(1, x_t.shape[1] - 1):
        drag = plan.node[DRAG, i]
        squares += drag * ((old[1, i] + x_t[1, i]) ** 2 + (old[2, i] + x_t[2, i]) ** 2)
    add_to(tallies, int(TRANSVERSE_LOSS), 0.25 * plan.step * squares)


@njit_in_place
@for_kernels
def damp_axially(plan: Plan, x: Array, x_t: Array, motor: Array, tallies: Array, work: Workspace) -> None:
    """Solve for the damping tensions of the segments together with the speeds of the shafts.

    ``work.direction`` holds the derivatives of the strains.
    """
    n = plan.segments
    direction, q, mean, shaft, matrix = work.direction, work.q, work.mean, work.shaft, work.matrix
    node = plan.node
    for axis in range(3):
        for i in range(x.shape[1]):
            mean[axis, i] = 0.5 * (work.old[axis, i] + x_t[axis, i])
    for i in range(SHAFTS):
        for k in range(SHAFTS):
            matrix[i, k] = plan.shaft_matrices[0, i, k]
    for span in range(plan.spans):
        first, last = span * n, (span + 1) * n
        start, end = span, 1 - span  # shafts at which the span starts and ends
        solve_span(first, last, plan.segment[COMPLIANCE], node[KICK_U], node[KICK_T], mean, direction, q)
        for side in range(2):
            own = start if side == 0 else end
            segment = first if side == 0 else last - 1
            pull = direction[0, segment] if side == 0 else -direction[0, segment]
            to_start, to_end = 0.5 * pull * q[1, segment], 0.5 * pull * q[2, segment]
            shaft[FORCE, own] += pull * q[0, segment]
            shaft[FORCE, own] += to_start * shaft[OLD, start] + to_end * shaft[OLD, end]
            matrix[own, start] -= to_start
            matrix[own, end] -= to_end
    turn(plan, matrix, x_t, motor, shaft)
    loss = 0.0
    for i in range(q.shape[1]):
        start = i // n
        end = 1 - start
        q[0, i] += 0.5 * q[1, i] * (shaft[OLD, start] + shaft[NEW, start])
        q[0, i] += 0.5 * q[2, i] * (shaft[OLD, end] + shaft[NEW, end])
        loss += plan.segment[COMPLIANCE, i] * q[0, i] ** 2
    add_to(tallies, int(AXIAL_LOSS), plan.step * loss)
    for axis in range(3):
        kick = node[KICK_U if axis == 0 else KICK_T]
        for i in range(1, q.shape[1]):
            x_t[axis, i] += kick[i] * (direction[axis, i] * q[0, i] - direction[axis, i - 1] * q[0, i - 1])
