r"""Compiled march of a cable of equal segments under the exact law: tension, kick and drift in one pass.

With :math:`y = h^2 z = \Delta u\,(2h + \Delta u) + \Delta v^2 + \Delta w^2` of a segment's ends and the gain
:math:`g = EA\,z\,s(z)`, s the series of `cabledrive.simulation.kernels.segments`, a segment carries

.. math:: h\,(p_u, p_v, p_w) = (T_0 + g)\,(\Delta u, \Delta v, \Delta w) + (g h, 0, 0)

above the pretension. The pass treats the rims like any other node; what it makes of them is put right after
it. All steps between two records are taken in one call, so that what does not change is set up once. Twin:
`cabledrive.simulation.readable.verlet`.
"""

from typing import TypeAlias

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inlined
from cabledrive.simulation.channels import BALANCE, TRANSVERSE_LOSS
from cabledrive.simulation.kernels.observe import record
from cabledrive.simulation.kernels.segments import C0, C1, C2, C3, C4, C5, C6, C7, LARGEST_Z
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
from cabledrive.simulation.plan import (
    DRAG,
    FALL_U,
    FALL_W,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    RADIUS,
    SPACING,
    Plan,
)
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import FORCE, NEW, OLD, Workspace

Series: TypeAlias = tuple[float, float, float, float, float, float, float, float]


@njit_inlined
def gain_series(rigidity: float, inverse_spacing: float) -> Series:
    """Coefficients of the gain in powers of y, from the first power on."""
    a = inverse_spacing * inverse_spacing
    b, c, d = a * a, a * a * a, a * a * a * a
    return (
        rigidity * C0 * a, rigidity * C1 * b, rigidity * C2 * c, rigidity * C3 * d,
        rigidity * C4 * d * a, rigidity * C5 * d * b, rigidity * C6 * d * c, rigidity * C7 * d * d,
    )  # fmt: skip


@njit_inlined
def safe_range(plan: Plan) -> tuple[float, float]:
    """Centre and half width of the y at which a segment is taut and the series holds."""
    slack_z = (1.0 + plan.slack_strain) ** 2 - 1.0
    square = plan.segment[SPACING, 0] ** 2
    lowest = max(slack_z, -LARGEST_Z) * square
    highest = LARGEST_Z * square
    return 0.5 * (highest + lowest), 0.5 * (highest - lowest)


@njit_in_place
@for_kernels
def gain_at(x: Array, i: int, series: Series, h: float) -> float:
    """Gain of segment i."""
    c0, c1, c2, c3, c4, c5, c6, c7 = series
    du = x[0, i + 1] - x[0, i]
    dv = x[1, i + 1] - x[1, i]
    dw = x[2, i + 1] - x[2, i]
    y = du * (2.0 * h + du) + dv * dv + dw * dw
    return y * (c0 + y * (c1 + y * (c2 + y * (c3 + y * (c4 + y * (c5 + y * (c6 + y * c7)))))))


@njit_inlined
def pulls_on_rims(x: Array, series: Series, h: float, pretension: float, segments: int, p: Array) -> float:
    """Axial components of the segments beside the rims, into their places in p; the gain of the first."""
    gain = 0.0
    ends = 2 * (p.shape[1] // segments)
    for back in range(ends):
        k = ends - 1 - back
        i = (k // 2) * segments + (k % 2) * (segments - 1)
        gain = gain_at(x, i, series, h)
        p[0, i] = (pretension + gain) * (x[0, i + 1] - x[0, i]) / h + gain
    return gain


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
def step_equal_segments(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
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
    last = p.shape[1]
    h, inverse = plan.segment[SPACING, 0], plan.segment[INVERSE_SPACING, 0]
    h2 = 2.0 * h
    centre, reach = safe_range(plan)
    fall_u, fall_w = plan.node[FALL_U], plan.node[FALL_W]
    kick_u, kick_t, keep = (
        plan.node[KICK_U, 1] * inverse,
        plan.node[KICK_T, 1] * inverse,
        plan.node[KEEP_T, 1],
    )
    loss = 0.25 * step * plan.node[DRAG, 1]
    matrix, back = plan.shaft_matrices[0], plan.shaft_matrices[1]
    per_radius = 1.0 / plan.shaft[RADIUS, 0]
    of_drive, of_load, of_motor = turn_freely(matrix, plan.shaft, shaft)
    series = gain_series(plan.rigidity, inverse)
    c0, c1, c2, c3, c4, c5, c6, c7 = series
    for j in range(torque.size):
        keep_extremes(n, plan.spans, plan.probe, x, motor, state.extremes)
        pull = pretension + pulls_on_rims(x, series, h, pretension, n, p)
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
        p_u, p_w = h * p[0, 0], pull * w[1]  # as if the first segment pulled from before as well
        p_v = pull * v[1] if v is not None else 0.0
        squares = 0.0
        outside = 0
        for i in range(last):
            du = u[i + 1] - u[i]
            dw = w[i + 1] - w[i]
            y = du * (h2 + du) + dw * dw
            if v is not None:
                dv = v[i + 1] - v[i]
                y += dv * dv
            gain = y * (c0 + y * (c1 + y * (c2 + y * (c3 + y * (c4 + y * (c5 + y * (c6 + y * c7)))))))
            outside += abs(y - centre) > reach
            pull = pretension + gain
            q = pull * du + gain * h
            speed = u_t[i] + fall_u[i] + kick_u * (q - p_u)
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
        if outside > 0:
            return False
        squares -= w_t[n] ** 2 if last > n else 0.0
        u[0], u[n], u_t[0], u_t[n] = drive, load, shaft[NEW, 0], shaft[NEW, 1]
        w[0], w[n], w_t[0], w_t[n] = 0.0, 0.0, 0.0, 0.0
        if v is not None and v_t is not None:
            squares -= v_t[n] ** 2 if last > n else 0.0
            v[0], v[n], v_t[0], v_t[n] = 0.0, 0.0, 0.0, 0.0
        if closed:
            u[last], u_t[last] = drive, shaft[NEW, 0]
        if loss > 0.0:
            add_to(tallies, int(TRANSVERSE_LOSS), loss * squares)
        tally_shafts(step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, tallies)
    return True


@njit_in_place
def march_equal_segments(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
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
    """March from step ``first``, the first of a record, from record to record.

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
            here = torque[first : first + 1] if part == 0 else torque[first + 1 : last]
            taken = step_equal_segments(plan, state, work, here, u, v, w, u_t, v_t, w_t)
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
