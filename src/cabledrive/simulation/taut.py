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
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.channels import BALANCE, FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.node_motion import move_rims, shaft_forces, speed_shafts
from cabledrive.simulation.observe import add_to, copy_rows, keep_before, keep_extremes, observe, tally_shafts
from cabledrive.simulation.plan import (
    CENTRE,
    DRAG,
    ENERGY,
    EXACT,
    FALL_U,
    FALL_W,
    GAIN,
    INVERSE_SPACING,
    KEEP_T,
    KEPT,
    KICK_T,
    KICK_U,
    LOSS,
    LOWER_SLACK,
    NEW,
    RADIUS,
    REACH,
    RUN_FALL_U,
    SPEED_T,
    SPEED_U,
    STEPS,
    TENSION,
    UPPER_SLACK,
    H,
    Plan,
    State,
    Workspace,
)
from cabledrive.simulation.segment_laws import segment_tensions, strains

BEFORE, AFTER, PLACE = range(3)


@njit_in_place
@for_kernels
def pulls_beside(plan: Plan, x: Array, p: Array) -> None:
    """Components of the segments beside rims and stops, into their places in p."""
    for k in range(plan.beside.size):
        i = plan.beside[k]
        one = slice(i, i + 1)
        segment_tensions(
            EXACT,
            False,
            plan.pretension,
            plan.rigidity,
            x[:, i : i + 2],
            plan.segment[INVERSE_SPACING, one],
            p[:, one],
        )


@njit_in_place
@for_kernels
def kick_stops(plan: Plan, x: Array, x_t: Array, p: Array, forces: Array, j: int, stop: Array) -> None:
    """Speeds of the stops after step ``j``, from the components beside them; kept until the pass is over."""
    node = plan.node
    for k in range(plan.stop.size):
        i = plan.stop[k]
        for axis in range(3):
            stop[BEFORE, axis, k] = x_t[axis, i]
            stop[PLACE, axis, k] = x[axis, i]
            kick = node[KICK_U, i] if axis == 0 else node[KICK_T, i]
            kept = 1.0 if axis == 0 else node[KEEP_T, i]
            stop[AFTER, axis, k] = kept * x_t[axis, i] + kick * (p[axis, i] - p[axis, i - 1])
            for number in range(plan.force.shape[0]):
                if plan.force[number, 0] == i and plan.force[number, 1] == axis:
                    stop[AFTER, axis, k] += kick * forces[j, number]
        stop[AFTER, 0, k] += node[FALL_U, i]
        stop[AFTER, 2, k] += node[FALL_W, i]


@njit_in_place
@for_kernels
def move_stops(plan: Plan, x: Array, x_t: Array, forces: Array, j: int, stop: Array, tallies: Array) -> None:
    """Write the stops' speeds and places over what the pass left there; work of forces, transverse loss."""
    squares = 0.0
    for k in range(plan.stop.size):
        i = plan.stop[k]
        for axis in range(3):
            speed = stop[AFTER, axis, k]
            x_t[axis, i] = speed
            x[axis, i] = stop[PLACE, axis, k] + plan.step * speed
            twice = stop[BEFORE, axis, k] + speed
            if axis > 0:
                squares += plan.node[DRAG, i] * twice * twice
            for number in range(plan.force.shape[0]):
                if plan.force[number, 0] == i and plan.force[number, 1] == axis:
                    add_to(tallies, int(FORCE_WORK), 0.5 * plan.step * forces[j, number] * twice)
    add_to(tallies, int(TRANSVERSE_LOSS), 0.25 * plan.step * squares)


def rows_of(state: State) -> tuple[Array, Array | None, Array, Array, Array | None, Array]:
    """Rows of displacements and velocities as the quick loops take them.

    Returns u, v, w and their velocities; None for v and its velocity where nothing has left the plane of the
    pulleys, since then nothing does.
    """
    (u, v, w), (u_t, v_t, w_t) = state.x, state.x_t
    if v.any() or v_t.any():
        return u, v, w, u_t, v_t, w_t
    return u, None, w, u_t, None, w_t


@njit_in_place
@for_kernels
def move_run(
    first: int,
    last: int,
    run: Array,
    pretension: float,
    step: float,
    p_u: float,
    p_v: float,
    p_w: float,
    fall_w: Array,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> tuple[int, float]:
    """Kick and drift of all nodes of a run but its last, before which the pulls h p act on the first.

    Returns how many segments are slack or out of the range of the series, and the sum of the squares of twice
    the mean transverse velocities.
    """
    h, kick_u, kick_t, keep = run[H], run[SPEED_U], run[SPEED_T], run[KEPT]
    h2, centre, reach, fall_u = 2.0 * h, run[CENTRE], run[REACH], run[RUN_FALL_U]
    c0, c1, c2, c3 = run[GAIN], run[GAIN + 1], run[GAIN + 2], run[GAIN + 3]
    c4, c5, c6, c7 = run[GAIN + 4], run[GAIN + 5], run[GAIN + 6], run[GAIN + 7]
    squares = 0.0
    outside = 0
    # Unsigned: an index that might be negative would keep the compiler from taking several nodes at once.
    one, start = np.uintp(1), np.uintp(first)
    for k in range(np.uintp(last) - start):
        i = start + k
        after = i + one
        du = u[after] - u[i]
        dw = w[after] - w[i]
        y = du * (h2 + du) + dw * dw
        if v is not None:
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
        if v is not None and v_t is not None:
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


@njit_in_place
@for_kernels
def step_taut(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> bool:
    """Take a step for each entry of ``torque``; without v the cable stays in the plane of the pulleys.

    The rows of the state are arguments of their own: only then does the compiler see that they do not
    overlap, and takes several nodes at once. Returns False as soon as a segment is found slack or out of the
    range of the series; the state is then of no use.
    """
    x, x_t, motor, tallies, p, shaft = state.x, state.x_t, state.motor, state.tallies, work.p, work.shaft
    n, step, closed, pretension = plan.segments, plan.step, plan.closed, plan.pretension
    end = p.shape[1]
    fall_w = plan.node[FALL_W]
    per_radius = 1.0 / plan.shaft[RADIUS, 0]
    for j in range(torque.size):
        keep_extremes(plan, x, motor, state.extremes)
        pulls_beside(plan, x, p)
        push = torque[j] * per_radius
        shaft_forces(plan, x, x_t, motor, p, push, shaft)
        speed_shafts(plan, plan.shaft_matrices[0], shaft)
        move_rims(plan, motor, x_t, shaft)
        drive, load = u[0] + step * shaft[NEW, 0], u[n] + step * shaft[NEW, 1]
        if plan.stop.size > 0:
            kick_stops(plan, x, x_t, p, forces, j, work.stop)
        loss = 0.0
        outside = 0
        for k in range(plan.runs.shape[0]):
            first, last = plan.runs[k, 0], plan.runs[k, 1]
            h = plan.run[k, H]
            old_v, old_w = x_t[1, first], x_t[2, first]
            # The first node of a run is a rim or a stop: as if the first segment pulled from before as well.
            beyond, squares = move_run(
                first,
                last,
                plan.run[k],
                pretension,
                step,
                h * p[0, first],
                h * p[1, first],
                h * p[2, first],
                fall_w,
                u,
                v,
                w,
                u_t,
                v_t,
                w_t,
            )
            outside += beyond
            # What the pass counted at its first node and at a rim inside the run is no motion of the cable.
            squares -= (x_t[1, first] + old_v) ** 2 + (x_t[2, first] + old_w) ** 2
            if first < n and n < last:
                squares -= x_t[1, n] ** 2 + x_t[2, n] ** 2
            loss += plan.run[k, LOSS] * squares
        if outside > 0:
            return False
        u[0], u[n], u_t[0], u_t[n] = drive, load, shaft[NEW, 0], shaft[NEW, 1]
        w[0], w[n], w_t[0], w_t[n] = 0.0, 0.0, 0.0, 0.0
        if v is not None and v_t is not None:
            v[0], v[n], v_t[0], v_t[n] = 0.0, 0.0, 0.0, 0.0
        if closed:
            u[end], u_t[end] = drive, shaft[NEW, 0]
        if plan.stop.size > 0:
            move_stops(plan, x, x_t, forces, j, work.stop, tallies)
        if loss > 0.0:
            add_to(tallies, int(TRANSVERSE_LOSS), loss)
        tally_shafts(plan, push, shaft, tallies)
    return True


@njit_in_place
@for_kernels
def record_exact(
    plan: Plan, work: Workspace, after: Array, motor: Array, tallies: Array, torque: float, row: Array
) -> None:
    """Write the record of the step before which ``work.before`` was kept, under the exact law."""
    x = work.before[0]
    strains(plan, x, work.q[TENSION], work.q[ENERGY])
    given = plan.pretension, plan.rigidity, x, plan.segment[INVERSE_SPACING], work.p
    segment_tensions(EXACT, plan.tension_only, *given)
    observe(plan, work, after, motor, tallies, torque, row)


@njit_in_place
def integrate_taut(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
    first: int,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> tuple[int, bool]:
    """Integrate from step ``first``, the first of a record, from record to record.

    Returns the step it comes to, the end or the first of a record before which a segment is slack or out of
    range, with the state as it is there; and whether the energy is finite.
    """
    x, x_t, motor, tallies = state.x, state.x_t, state.motor, state.tallies
    while first < torque.size:
        last = min(first + every, torque.size)
        keep_before(state, work)
        row = rows[first // every]
        taken = False
        for part in range(2):
            start, stop = (first, first + 1) if part == 0 else (first + 1, last)
            here, pushed = torque[start:stop], forces[start:stop]
            taken = step_taut(plan, state, work, here, pushed, u, v, w, u_t, v_t, w_t)
            if not taken:
                break
            if part == 0:
                record_exact(plan, work, x_t, motor, tallies, torque[first], row)
        if not taken:
            copy_rows(work.before[0], x)
            copy_rows(work.before[1], x_t)
            copy_rows(work.before_tallies, tallies)
            motor[0], motor[1] = work.before_motor[0], work.before_motor[1]
            return first, True
        if fields.shape[0] > 0:
            copy_rows(work.before[0], fields[first // every])
        state.counts[STEPS] += last - first
        state.counts[UPPER_SLACK] = 0
        state.counts[LOWER_SLACK] = 0
        if not abs(row[BALANCE]) < 1e300:
            return last, False
        first = last
    return first, True
