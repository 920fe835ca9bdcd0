"""Compiled Stoermer-Verlet integration of the staggered chain.

One step: tensions of all segments, velocities half a step on, displacements a step on. Under the exact law it
is one pass over the segments, `cabledrive.simulation.kernels.taut_steps`, as long as they are taut; other
laws, slack and axial damping take the long loop.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.channels import BALANCE
from cabledrive.simulation.kernels.axial_damping import strain_directions
from cabledrive.simulation.kernels.nodes import damp_axially, kick_nodes, tally_nodes, turn
from cabledrive.simulation.kernels.observe import record
from cabledrive.simulation.kernels.segments import EXACT, segment_tensions
from cabledrive.simulation.kernels.steps import (
    copy_rows,
    keep_before,
    keep_extremes,
    note_slack,
    shaft_forces,
    tally_shafts,
)
from cabledrive.simulation.kernels.taut_steps import integrate_taut, rows_of
from cabledrive.simulation.plan import (
    INVERSE_SPACING,
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
    """Take a step per entry of ``torque``, recording the first of every ``every`` into the next row.

    ``plan``, ``state``, ``work``, ``torque``, ``forces``, ``every``, ``rows``, ``fields``: see
    `cabledrive.simulation.method.Method.integrate`.
    Returns DONE, SLACK (before the step at whose start a span is slack) or NOT_FINITE (after the record that
    shows it).
    """
    check_kernel_law(plan)
    if plan.law != EXACT or plan.axial_damping > 0.0:
        return integrate_any(plan, state, work, torque, forces, every, rows, fields)
    lines = rows_of(state)
    j = 0
    while j < torque.size:
        j, finite = integrate_taut(plan, state, work, torque, forces, every, rows, fields, j, *lines)
        if j >= torque.size or not finite:
            return DONE if finite else NOT_FINITE
        here, record_here = slice(j, j + every), slice(j // every, j // every + 1)
        code = integrate_any(
            plan, state, work, torque[here], forces[here], every, rows[record_here], fields[record_here]
        )
        if code != DONE:
            return code
        j += every
    return DONE


@njit_in_place
def integrate_any(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """As `integrate`, for every law and every drive, slack or not."""
    x, x_t, motor, tallies, shaft = state.x, state.x_t, state.motor, state.tallies, work.shaft
    inverse_spacing, radius = plan.segment[INVERSE_SPACING], plan.shaft[RADIUS, 0]
    for j in range(torque.size):
        keep_extremes(plan.segments, plan.spans, plan.probe, x, motor, state.extremes)
        recording = j % every == 0
        if recording:
            keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)
        slack = segment_tensions(
            plan.law, plan.tension_only, plan.pretension, plan.rigidity, x, inverse_spacing, work.p
        )
        if slack > 0 or state.counts[UPPER_SLACK] + state.counts[LOWER_SLACK] > 0:
            note_slack(plan, x, state.events, state.counts)
            if plan.stop_when_slack and slack > 0:
                return SLACK
        push = torque[j] / radius
        shaft_forces(
            plan.closed, plan.segments, plan.joint_stiffness, plan.shaft, plan.node, x, x_t, motor, work.p,
            plan.driven, push, shaft,
        )  # fmt: skip
        if plan.axial_damping > 0.0:
            strain_directions(plan, x, work.direction)
        move_each(plan, x, x_t, motor, tallies, forces[j], work)
        tally_shafts(plan.step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, tallies)
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
@for_kernels
def move_each(
    plan: Plan, x: Array, x_t: Array, motor: Array, tallies: Array, forces: Array, work: Workspace
) -> None:
    """Kick and drift with every node's own mass, carriages, forces on them and axial damping."""
    p, old, shaft = work.p, work.old, work.shaft
    kick_nodes(plan, x_t, old, p, forces)
    if plan.axial_damping > 0.0:
        damp_axially(plan, x, x_t, motor, tallies, work)
    else:
        turn(plan, plan.shaft_matrices[0], x_t, motor, shaft)
    tally_nodes(plan, x_t, old, tallies, forces)
    for axis in range(3):
        for i in range(x.shape[1]):
            x[axis, i] += plan.step * x_t[axis, i]
