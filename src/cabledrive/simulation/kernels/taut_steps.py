r"""Compiled time integration of a taut cable under the exact law: tension, kick and drift in one pass.

A segment carries

.. math:: h\,(p_u, p_v, p_w) = (T_0 + g)\,(\Delta u, \Delta v, \Delta w) + (g h, 0, 0)

above the pretension, with the differences of displacements of its ends and the gain g of
`cabledrive.simulation.runs`. The pass goes over runs of equal segments and treats every node inside a run
alike; the rims, and the stops with a mass of their own or a force, are put right after it. All steps between
two records are taken in one call.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.channels import BALANCE, TRANSVERSE_LOSS
from cabledrive.simulation.kernels.observe import record
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.kernels.steps import (
    copy_rows,
    keep_before,
    keep_extremes,
    move_rims,
    shaft_forces,
    tally_shafts,
    turn_freely,
    turn_shafts,
)
from cabledrive.simulation.kernels.stops import kick_stops, move_stops, pulls_beside
from cabledrive.simulation.plan import (
    FALL_W,
    RADIUS,
    Plan,
)
from cabledrive.simulation.runs import CENTRE, GAIN, KEPT, LOSS, REACH, RUN_FALL_U, SPEED_T, SPEED_U, H
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import FORCE, NEW, OLD, Workspace


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
    matrix, back = plan.shaft_matrices[0], plan.shaft_matrices[1]
    per_radius = 1.0 / plan.shaft[RADIUS, 0]
    of_drive, of_load, of_motor = turn_freely(matrix, plan.shaft, shaft)
    for j in range(torque.size):
        keep_extremes(n, plan.spans, plan.probe, x, motor, state.extremes)
        pulls_beside(plan, x, p)
        push = torque[j] * per_radius
        shaft_forces(
            closed, n, plan.joint_stiffness, plan.shaft, plan.node, x, x_t, motor, p, plan.driven, push, shaft
        )
        if of_drive >= 0.0:
            shaft[NEW, 0] = of_drive * (shaft[FORCE, 0] + back[0, 0] * shaft[OLD, 0])
            shaft[NEW, 1] = of_load * (shaft[FORCE, 1] + back[1, 1] * shaft[OLD, 1])
            shaft[NEW, 2] = of_motor * (shaft[FORCE, 2] + back[2, 2] * shaft[OLD, 2])
            move_rims(step, closed, n, motor, x_t, shaft)
        else:
            turn_shafts(step, closed, n, matrix, back, plan.shaft, motor, x_t, shaft)
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
                first, last, plan.run[k], pretension, step, h * p[0, first], h * p[1, first], h * p[2, first],
                fall_w, u, v, w, u_t, v_t, w_t,
            )  # fmt: skip
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
        tally_shafts(step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, tallies)
    return True


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
        keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)
        row = rows[first // every]
        taken = False
        for part in range(2):
            start, stop = (first, first + 1) if part == 0 else (first + 1, last)
            here, pushed = torque[start:stop], forces[start:stop]
            taken = step_taut(plan, state, work, here, pushed, u, v, w, u_t, v_t, w_t)
            if not taken:
                break
            if part == 0:
                record(plan, work, x_t, motor, tallies, torque[first], row)
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
