"""Compiled Stoermer-Verlet march of the staggered chain. Twin: `cabledrive.simulation.readable.verlet`.

One step: tensions of all segments, velocities half a step on, displacements a step on. Equal segments without
carriages under the exact law take a quick loop from record to record as long as they are taut; everything
else takes the long one.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.simulation.channels import BALANCE
from cabledrive.simulation.kernels.equal_segments import gain_series, stays_in_plane, step_equal_segments
from cabledrive.simulation.kernels.nodes import damp_axially, kick_nodes, tally_nodes, turn
from cabledrive.simulation.kernels.observe import observe
from cabledrive.simulation.kernels.segments import EXACT, segment_tensions
from cabledrive.simulation.kernels.steps import (
    copy_rows,
    keep_before,
    keep_extremes,
    note_slack,
    shaft_forces,
    tally_shafts,
)
from cabledrive.simulation.plan import (
    INVERSE_SPACING,
    RADIUS,
    Plan,
)
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import Workspace

DONE, SLACK, NOT_FINITE = range(3)


@njit
def march(
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

    ``forces`` is (steps, number of forces); ``fields`` (records or 0, 3, nodes) gets whole displacements.
    Returns DONE, SLACK (before the step at whose start a span is slack) or NOT_FINITE (after the record that
    shows it).
    """
    series = gain_series(plan.rigidity, plan.segment[INVERSE_SPACING, 0])
    return _march(plan, state, work, series, torque, forces, every, rows, fields)


@njit_in_place
def _march(
    plan: Plan,
    state: State,
    work: Workspace,
    series: Array,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """As `march`, with the series of the gain."""
    if not plan.uniform or plan.law != EXACT:
        return _march_any(plan, state, work, torque, forces, every, rows, fields)
    planar = stays_in_plane(state.x, state.x_t)
    for record in range((torque.size + every - 1) // every):
        first = record * every
        here = slice(first, min(first + every, torque.size))
        row, field = rows[record : record + 1], fields[record : record + 1]
        if _march_equal(plan, state, work, torque[here], series, planar, row, field):
            if not abs(row[0, BALANCE]) < 1e300:
                return NOT_FINITE
            continue
        code = _march_any(plan, state, work, torque[here], forces[here], every, row, field)
        if code != DONE:
            return code
    return DONE


@njit_in_place
def _march_equal(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    series: Array,
    planar: bool,
    row: Array,
    field: Array,
) -> bool:
    """Steps from one record up to the next; False, and nothing changed, where the quick loop will not do."""
    x, x_t, motor, tallies = state.x, state.x_t, state.motor, state.tallies
    keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)
    taken = _step_equal(plan, state, work, torque[:1], series, planar)
    if taken:
        _record(plan, work, x_t, motor, tallies, torque[0], row, field)
        taken = _step_equal(plan, state, work, torque[1:], series, planar)
    if taken:
        state.counts[STEPS] += torque.size
        state.counts[UPPER_SLACK] = 0
        state.counts[LOWER_SLACK] = 0
    else:
        copy_rows(work.before[0], x)
        copy_rows(work.before[1], x_t)
        copy_rows(work.before_tallies, tallies)
        motor[0], motor[1] = work.before_motor[0], work.before_motor[1]
    return taken


@njit_in_place
def _step_equal(
    plan: Plan, state: State, work: Workspace, torque: Array, series: Array, planar: bool
) -> bool:
    x, x_t = state.x, state.x_t
    if planar:
        return step_equal_segments(plan, state, work, torque, series, x[0], None, x[2], x_t[0], None, x_t[2])
    return step_equal_segments(plan, state, work, torque, series, x[0], x[1], x[2], x_t[0], x_t[1], x_t[2])


@njit_in_place
def _record(
    plan: Plan,
    work: Workspace,
    x_t: Array,
    motor: Array,
    tallies: Array,
    torque: float,
    row: Array,
    field: Array,
) -> None:
    """Write the record of the step whose start was kept; ``row`` and ``field`` hold one or none."""
    observe(
        plan, work.before, x_t, work.before_motor, motor, work.before_tallies, tallies,
        torque, work.p, work.q[0], row[0],
    )  # fmt: skip
    if field.shape[0] > 0:
        copy_rows(work.before[0], field[0])


@njit_in_place
def _march_any(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """As `march`, for every law and every drive, slack or not."""
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
            plan.closed, plan.segments, plan.joint_stiffness, plan.node, x, x_t, motor, work.p,
            plan.driven, push, shaft,
        )  # fmt: skip
        _move_each(plan, x, x_t, motor, tallies, forces[j], work)
        tally_shafts(plan.step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, tallies)
        state.counts[STEPS] += 1
        if recording:
            record = j // every
            row, field = rows[record : record + 1], fields[record : record + 1]
            _record(plan, work, x_t, motor, tallies, torque[j], row, field)
            if not abs(row[0, BALANCE]) < 1e300:
                return NOT_FINITE
    return DONE


@njit_in_place
def _move_each(
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
