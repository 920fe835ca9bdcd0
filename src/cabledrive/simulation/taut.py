r"""Compiled time integration of a taut cable under the exact law: tension, kick and drift in one pass.

A segment carries

.. math:: h\,(p_u, p_v, p_w) = (T_0 + g)\,(\Delta u, \Delta v, \Delta w) + (g h, 0, 0)

above the pretension, with the differences of displacements of its ends and the gain g of
`cabledrive.simulation.plan`. The pass goes over runs of equal segments and treats every node inside a run
alike; the rims, and the stops with a mass of their own or a force, are put right after it. All steps between
two records are taken in one call.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place, njit_inner
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.coordinates import advance, gather, place_ends, turn
from cabledrive.simulation.damped import Out, Plane, step_damped
from cabledrive.simulation.observe import add_to, copy_rows, keep_before, keep_extremes, observe
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import components, end_pulls, rope_of, segment_tensions, strains

BEFORE, AFTER, PLACE = range(3)

Pulls = tuple[float, float, float]
Lines = tuple[Plane, Out]


@njit_inner
def pulls_beside(plan: Plan, x: Array, p: Array) -> None:
    """Components of the segments beside rims and stops, into their places in p."""
    inverse = plan.segment[at.INVERSE_SPACING]
    for k in range(plan.beside.shape[0]):
        here = plan.beside[k, 0], plan.beside[k, 0] + 1
        segment_tensions(rope_of(plan, plan.beside[k, 1]), here, x, inverse, p)


@njit_inner
def kick_stops(plan: Plan, state: State, work: Workspace, forces: Array) -> None:
    """Speeds of the stops after a step, from the components beside them; kept until the pass is over."""
    x, x_t, p, stop, node = state.x, state.x_t, work.p, work.stop, plan.node
    for k in range(plan.stop.size):
        i = plan.stop[k]
        for axis in range(3):
            stop[BEFORE, axis, k] = x_t[axis, i]
            stop[PLACE, axis, k] = x[axis, i]
            kick = node[at.KICK_U, i] if axis == 0 else node[at.KICK_T, i]
            kept = 1.0 if axis == 0 else node[at.KEEP_T, i]
            stop[AFTER, axis, k] = kept * x_t[axis, i] + kick * (p[axis, i] - p[axis, i - 1])
            for number in range(plan.force.shape[0]):
                if plan.force[number, 0] == i and plan.force[number, 1] == axis:
                    stop[AFTER, axis, k] += kick * forces[number]
        stop[AFTER, 0, k] += node[at.FALL_U, i]
        stop[AFTER, 2, k] += node[at.FALL_W, i]


@njit_inner
def move_stops(plan: Plan, state: State, work: Workspace, forces: Array) -> None:
    """Write the stops' speeds and places over what the pass left there; work of forces, transverse loss."""
    x, x_t, stop, tallies = state.x, state.x_t, work.stop, state.tallies
    squares = 0.0
    for k in range(plan.stop.size):
        i = plan.stop[k]
        for axis in range(3):
            speed = stop[AFTER, axis, k]
            x_t[axis, i] = speed
            x[axis, i] = stop[PLACE, axis, k] + plan.step * speed
            twice = stop[BEFORE, axis, k] + speed
            if axis > 0:
                squares += plan.node[at.DRAG, i] * twice * twice
            for number in range(plan.force.shape[0]):
                if plan.force[number, 0] == i and plan.force[number, 1] == axis:
                    add_to(tallies, int(FORCE_WORK), 0.5 * plan.step * forces[number] * twice)
    add_to(tallies, int(TRANSVERSE_LOSS), 0.25 * plan.step * squares)


def rows_of(plan: Plan, state: State) -> Lines:
    """Rows of displacements and velocities as the quick loops take them: of u and w, and of v.

    None for v where nothing has left the plane of the pulleys and no force can push it out.
    """
    (u, v, w), (u_t, v_t, w_t) = state.x, state.x_t
    beside = plan.row_column[np.repeat(np.arange(plan.row_start.size - 1), np.diff(plan.row_start)) % 3 == 1]
    leaves = v.any() or v_t.any() or (plan.force[:, 1] == 1).any() or plan.motor[:, beside].any()
    return (u, w, u_t, w_t), (v, v_t) if leaves else None


@njit_inner
def move_run(plan: Plan, k: int, pulls: Pulls, plane: Plane, out: Out) -> tuple[int, float]:
    """Kick and drift of all nodes of a run but its last, before which the pulls h p act on the first.

    Returns how many segments are slack or out of the range of the series, and the sum of the squares of twice
    the mean transverse velocities.
    """
    u, w, u_t, w_t = plane
    if out is not None:
        v, v_t = out
    p_u, p_v, p_w = pulls
    run, step, fall_w = plan.run[k], plan.step, plan.node[at.FALL_W]
    pretension = run[at.PULL]
    first, last = plan.runs[k, 0], plan.runs[k, 1]
    h, kick_u, kick_t, keep = run[at.H], run[at.SPEED_U], run[at.SPEED_T], run[at.KEPT]
    h2, centre, reach, fall_u = 2.0 * h, run[at.CENTRE], run[at.REACH], run[at.RUN_FALL_U]
    c0, c1, c2, c3 = run[at.GAIN], run[at.GAIN + 1], run[at.GAIN + 2], run[at.GAIN + 3]
    c4, c5, c6, c7 = run[at.GAIN + 4], run[at.GAIN + 5], run[at.GAIN + 6], run[at.GAIN + 7]
    outside, squares = 0, 0.0
    # Unsigned: an index that might be negative would keep the compiler from taking several nodes at once.
    one, start = np.uintp(1), np.uintp(first)
    for k in range(np.uintp(last) - start):
        i = start + k
        after = i + one
        du = u[after] - u[i]
        dw = w[after] - w[i]
        y = du * (h2 + du) + dw * dw
        if out is not None:
            dv = v[after] - v[i]
            y += dv * dv
        gain = y * (c0 + y * (c1 + y * (c2 + y * (c3 + y * (c4 + y * (c5 + y * (c6 + y * c7)))))))
        outside += abs(y - centre) > reach
        pull = pretension + gain
        q = pull * du + gain * h
        speed = u_t[i] + fall_u + kick_u * (q - p_u)
        p_u = q
        u_t[i] = speed
        u[i] += step * speed
        if out is not None:
            q = pull * dv
            speed = keep * v_t[i] + kick_t * (q - p_v)
            p_v = q
            twice = speed + v_t[i]
            squares += twice * twice
            v_t[i] = speed
            v[i] += step * speed
        q = pull * dw
        speed = keep * w_t[i] + fall_w[i] + kick_t * (q - p_w)
        p_w = q
        twice = speed + w_t[i]
        squares += twice * twice
        w_t[i] = speed
        w[i] += step * speed
    return outside, squares


@njit_inner
def step_taut(
    plan: Plan, state: State, work: Workspace, inputs: tuple[Array, Array], plane: Plane, out: Out
) -> bool:
    """Take a step for each entry of the torque; without v the cable stays in the plane of the pulleys.

    The rows of the state are arguments of their own: only then does the compiler see that they do not
    overlap, and takes several nodes at once. Returns False as soon as a segment is found slack or out of the
    range of the series; the state is then of no use.
    """
    torque, forces = inputs
    x, x_t, p = state.x, state.x_t, work.p
    for j in range(torque.shape[0]):
        keep_extremes(plan, state)
        pulls_beside(plan, x, p)
        end_pulls(plan, p, work)
        gather(plan, state.q, torque[j], work)
        turn(plan, state.q_t, plan.inverse, plan.rub_mobility, plan.rub_own, work)
        if plan.stop.size > 0:
            kick_stops(plan, state, work, forces[j])
        loss = 0.0
        outside = 0
        for k in range(plan.runs.shape[0]):
            first, h = plan.runs[k, 0], plan.run[k, at.H]
            old_v, old_w = x_t[1, first], x_t[2, first]
            # The first node of a run is a rim or a stop: as if the first segment pulled from before as well.
            pulls = h * p[0, first], h * p[1, first], h * p[2, first]
            beyond, squares = move_run(plan, k, pulls, plane, out)
            outside += beyond
            # What the pass counted at its first node is no motion of the cable.
            squares -= (x_t[1, first] + old_v) ** 2 + (x_t[2, first] + old_w) ** 2
            loss += plan.run[k, at.LOSS] * squares
        if outside > 0:
            return False
        advance(plan, state, torque[j], work)
        place_ends(plan, state.q, state.q_t, x, x_t)
        if plan.stop.size > 0:
            move_stops(plan, state, work, forces[j])
        if loss > 0.0:
            add_to(state.tallies, int(TRANSVERSE_LOSS), loss)
    return True


@njit_in_place
def integrate_taut(
    plan: Plan,
    state: State,
    work: Workspace,
    inputs: tuple[Array, Array],
    record: tuple[int, Array, Array],
    lines: Lines,
    damped: Array | None,
) -> tuple[int, bool]:
    """Integrate from record to record, the first step that of a record.

    ``record``: every how many steps, and the rows and fields that get them. Returns the steps taken, all or
    up to the record before which a segment is slack or out of range, with the state as it is there; and
    whether the energy is finite.
    """
    x, x_t, tallies = state.x, state.x_t, state.tallies
    (torque, forces), (every, rows, fields), first = inputs, record, 0
    while first < torque.shape[0]:
        last = min(first + every, torque.shape[0])
        keep_before(state, work)
        row = rows[first // every]
        taken, balance = False, 0.0
        for part in range(2):
            start, stop = (first, first + 1) if part == 0 else (first + 1, last)
            given = torque[start:stop], forces[start:stop]
            if damped is None:
                taken = step_taut(plan, state, work, given, lines[0], lines[1])
            else:
                taken = step_damped(plan, state, work, given, lines[0], lines[1])
            if not taken:
                break
            if part == 0:
                strains(plan, work.before[0], work.damp[at.TENSION], work.damp[at.ENERGY])
                components(None, plan.bound, plan, work.before[0], work.p)
                balance = observe(plan, state, work, torque[first], row)
        if not taken:
            copy_rows(work.before[0], x)
            copy_rows(work.before[1], x_t)
            copy_rows(work.before_tallies, tallies)
            for i in range(state.q.size):
                state.q[i], state.q_t[i] = work.before_q[0, i], work.before_q[1, i]
            return first, True
        if fields.shape[0] > 0:
            copy_rows(work.before[0], fields[first // every])
        state.counts[at.STEPS] += last - first
        state.slack[:] = 0
        if not abs(balance) < 1e300:
            return last, False
        first = last
    return first, True
