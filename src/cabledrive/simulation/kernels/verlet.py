"""Compiled Stoermer-Verlet march of the staggered chain. Twin: `cabledrive.simulation.readable.verlet`.

One step: tensions of all segments, velocities half a step on, displacements a step on. Equal segments without
carriages under the exact law take a quick loop from record to record as long as they are taut; everything
else takes the long one.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit
from cabledrive.simulation.channels import AXIAL_LOSS, BALANCE, FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.kernels.axial_damping import solve_span, strain_directions
from cabledrive.simulation.kernels.equal_segments import gain_series, stays_in_plane, step_equal_segments
from cabledrive.simulation.kernels.observe import observe
from cabledrive.simulation.kernels.segments import EXACT, segment_tensions
from cabledrive.simulation.kernels.shafts import SHAFTS, add_to
from cabledrive.simulation.kernels.steps import (
    keep_before,
    keep_extremes,
    note_slack,
    shaft_forces,
    tally_shafts,
    turn_shafts,
)
from cabledrive.simulation.plan import (
    COMPLIANCE,
    DRAG,
    FALL_U,
    FALL_W,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    RADIUS,
    Plan,
)
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import FORCE, NEW, OLD, Workspace

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
    if not plan.uniform or plan.law != EXACT:
        return _march_any(plan, state, work, torque, forces, every, rows, fields)
    series = gain_series(plan.rigidity, plan.segment[INVERSE_SPACING, 0])
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


@njit
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
        x[:], x_t[:] = work.before[0], work.before[1]
        motor[:], tallies[:] = work.before_motor, work.before_tallies
    return taken


@njit
def _step_equal(
    plan: Plan, state: State, work: Workspace, torque: Array, series: Array, planar: bool
) -> bool:
    x, x_t = state.x, state.x_t
    if planar:
        return step_equal_segments(plan, state, work, torque, series, x[0], None, x[2], x_t[0], None, x_t[2])
    return step_equal_segments(plan, state, work, torque, series, x[0], x[1], x[2], x_t[0], x_t[1], x_t[2])


@njit
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
        field[0] = work.before[0]


@njit
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


@njit
def _move_each(
    plan: Plan, x: Array, x_t: Array, motor: Array, tallies: Array, forces: Array, work: Workspace
) -> None:
    """Kick and drift with every node's own mass, carriages, forces on them and axial damping."""
    p, old, shaft = work.p, work.old, work.shaft
    _kick(plan, x_t, old, p, forces)
    if plan.axial_damping > 0.0:
        _damp_axially(plan, x, x_t, motor, tallies, work)
    else:
        _turn(plan, plan.shaft_matrices[0], x_t, motor, shaft)
    _tally_nodes(plan, x_t, old, tallies, forces)
    for axis in range(3):
        for i in range(x.shape[1]):
            x[axis, i] += plan.step * x_t[axis, i]


@njit
def _turn(plan: Plan, matrix: Array, x_t: Array, motor: Array, shaft: Array) -> None:
    back = plan.shaft_matrices[1]
    turn_shafts(plan.step, plan.closed, plan.segments, matrix, back, plan.shaft, motor, x_t, shaft)


@njit
def _kick(plan: Plan, x_t: Array, old: Array, p: Array, forces: Array) -> None:
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


@njit
def _tally_nodes(plan: Plan, x_t: Array, old: Array, tallies: Array, forces: Array) -> None:
    """Work of the forces and transverse loss over the step."""
    for k in range(plan.force.shape[0]):
        i, axis = plan.force[k, 0], plan.force[k, 1]
        add_to(tallies, FORCE_WORK, plan.step * forces[k] * 0.5 * (old[axis, i] + x_t[axis, i]))
    squares = 0.0
    for i in range(1, x_t.shape[1] - 1):
        drag = plan.node[DRAG, i]
        squares += drag * ((old[1, i] + x_t[1, i]) ** 2 + (old[2, i] + x_t[2, i]) ** 2)
    add_to(tallies, TRANSVERSE_LOSS, 0.25 * plan.step * squares)


@njit
def _damp_axially(plan: Plan, x: Array, x_t: Array, motor: Array, tallies: Array, work: Workspace) -> None:
    """Solve for the damping tensions of the segments together with the speeds of the shafts."""
    n = plan.segments
    direction, q, mean, shaft, matrix = work.direction, work.q, work.mean, work.shaft, work.matrix
    node = plan.node
    strain_directions(
        plan.law, plan.slack_strain, plan.tension_only, x, plan.segment[INVERSE_SPACING], direction
    )
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
    _turn(plan, matrix, x_t, motor, shaft)
    loss = 0.0
    for i in range(q.shape[1]):
        start = i // n
        end = 1 - start
        q[0, i] += 0.5 * q[1, i] * (shaft[OLD, start] + shaft[NEW, start])
        q[0, i] += 0.5 * q[2, i] * (shaft[OLD, end] + shaft[NEW, end])
        loss += plan.segment[COMPLIANCE, i] * q[0, i] ** 2
    add_to(tallies, AXIAL_LOSS, plan.step * loss)
    for axis in range(3):
        kick = node[KICK_U if axis == 0 else KICK_T]
        for i in range(1, q.shape[1]):
            x_t[axis, i] += kick[i] * (direction[axis, i] * q[0, i] - direction[axis, i - 1] * q[0, i - 1])
