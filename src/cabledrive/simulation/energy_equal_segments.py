r"""Compiled step of the energy-conserving scheme on equal segments under the exact law: two passes.

With the gain g of `cabledrive.simulation.plan` a segment carries, beyond the linear law,

.. math:: h\,(r_u, r_v, r_w) = g\,(\Delta u, \Delta v, \Delta w) + (g h - EA\,\Delta u, 0, 0)

The first pass finds g, the nonlinear energy and how the force scale c depends on the velocities; it changes
nothing, so that a slack segment can still be left to the long loop. The second pass moves the nodes under the
linear forces plus c times the rest.
"""

from math import sqrt

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inlined
from cabledrive.simulation.channels import BALANCE, TRANSVERSE_LOSS
from cabledrive.simulation.energy_step import MOST_TRIALS, SETTLED, own_balance, sum_with_loss
from cabledrive.simulation.node_motion import move_rims, shaft_forces, speed_shafts
from cabledrive.simulation.observe import (
    add_to,
    copy_rows,
    keep_before,
    keep_extremes,
    tally_shafts,
)
from cabledrive.simulation.plan import (
    CENTRE,
    DRAG,
    DRIVE_LOST,
    FALL_U,
    FALL_W,
    FORCE,
    GAIN,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    LOAD_LOST,
    LOWER_SLACK,
    MOTOR_LOST,
    NEW,
    OLD,
    RADIUS,
    REACH,
    SHIFT,
    SPACING,
    STEPS,
    STORED,
    STORED_LOST,
    UPPER_SLACK,
    Plan,
    State,
    Workspace,
)
from cabledrive.simulation.taut import record_exact


@njit_inlined
def rest_at(u: Array, gain: Array, i: int, rigidity: float, h: float) -> float:
    """Axial component of segment i beyond the linear law."""
    return gain[i] + (gain[i] - rigidity) * (u[i + 1] - u[i]) / h


@njit_in_place
@for_kernels
def step_equal_segments(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    gain: Array,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> int:
    """Take a step for each entry of ``torque``, up to one at whose start a segment is slack or out of range.

    ``gain`` (segments,) is work space; rows and the missing v are as in `taut`. Returns the number
    of steps taken.
    """
    x, x_t, motor, tallies, p, shaft = state.x, state.x_t, state.motor, state.tallies, work.p, work.shaft
    extra, n, step, closed = state.extra, plan.segments, plan.step, plan.closed
    pretension, rigidity = plan.pretension, plan.rigidity
    stiffness = pretension + rigidity
    last = p.shape[1]
    h, inverse = plan.segment[SPACING, 0], plan.segment[INVERSE_SPACING, 0]
    h2, square, per_rigidity = 2.0 * h, h * h, 1.0 / rigidity
    run = plan.run[0]
    centre, reach = run[CENTRE], run[REACH]
    fall_u, fall_w = plan.node[FALL_U], plan.node[FALL_W]
    kick_u, kick_t = plan.node[KICK_U, 1] * inverse, plan.node[KICK_T, 1] * inverse
    keep = plan.node[KEEP_T, 1]
    wave_u, wave_t, kept = kick_u * stiffness, kick_t * pretension, 1.0 + keep
    loss = 0.25 * step * plan.node[DRAG, 1]
    per_radius = 1.0 / plan.shaft[RADIUS, 0]
    c0, c1, c2, c3 = run[GAIN], run[GAIN + 1], run[GAIN + 2], run[GAIN + 3]
    c4, c5, c6, c7 = run[GAIN + 4], run[GAIN + 5], run[GAIN + 6], run[GAIN + 7]
    for j in range(torque.size):
        stretched, along, met, square_u, square_t = 0.0, 0.0, 0.0, 0.0, 0.0
        outside = 0
        d_u, d_v, d_w = u[1] - u[0], 0.0, w[1] - w[0]
        y = d_u * (h2 + d_u) + d_w * d_w
        if v is not None:
            d_v = v[1] - v[0]
            y += d_v * d_v
        g = y * (c0 + y * (c1 + y * (c2 + y * (c3 + y * (c4 + y * (c5 + y * (c6 + y * c7)))))))
        r_u, r_v, r_w = (g - rigidity) * d_u + g * h, g * d_v, g * d_w  # nothing acts on node 0
        for i in range(last):
            du = u[i + 1] - u[i]
            dw = w[i + 1] - w[i]
            y = du * (h2 + du) + dw * dw
            if v is not None:
                dv = v[i + 1] - v[i]
                y += dv * dv
            g = y * (c0 + y * (c1 + y * (c2 + y * (c3 + y * (c4 + y * (c5 + y * (c6 + y * c7)))))))
            gain[i] = g
            outside += abs(y - centre) > reach
            strain = y - per_rigidity * g * (square + y)  # h^2 lambda
            stretched += strain * strain
            along += du * du
            rest = (g - rigidity) * du + g * h
            force = rest - r_u
            met += force * (2.0 * u_t[i] + fall_u[i] + wave_u * (du - d_u))
            square_u += force * force
            r_u, d_u = rest, du
            if v is not None and v_t is not None:
                rest = g * dv
                force = rest - r_v
                met += force * (kept * v_t[i] + wave_t * (dv - d_v))
                square_t += force * force
                r_v, d_v = rest, dv
            rest = g * dw
            force = rest - r_w
            met += force * (kept * w_t[i] + fall_w[i] + wave_t * (dw - d_w))
            square_t += force * force
            r_w, d_w = rest, dw
        if outside > 0:
            return j
        if closed:  # node n is a rim
            start, stop = n - 1, n
            force = (rest_at(u, gain, stop, rigidity, h) - rest_at(u, gain, start, rigidity, h)) * h
            jump = (u[stop + 1] - u[stop]) - (u[stop] - u[start])
            met -= force * (2.0 * u_t[n] + fall_u[n] + wave_u * jump)
            square_u -= force * force
            if v is not None:
                force = gain[stop] * v[stop + 1] + gain[start] * v[start]
                met -= force * wave_t * (v[stop + 1] + v[start])
                square_t -= force * force
            force = gain[stop] * w[stop + 1] + gain[start] * w[start]
            met -= force * (fall_w[n] + wave_t * (w[stop + 1] + w[start]))
            square_t -= force * force
        met, answer = met * inverse, (kick_u * square_u + kick_t * square_t) * inverse
        energy = 0.5 * rigidity * inverse * (stretched * inverse * inverse - along)
        while min(energy, extra[STORED]) + extra[SHIFT] < 0.5 * extra[SHIFT]:
            extra[SHIFT] *= 2.0
        root = sqrt(2.0 * (energy + extra[SHIFT]))
        psi = sqrt(2.0 * (extra[STORED] + extra[SHIFT]))

        keep_extremes(plan, x, motor, state.extremes)
        for k in range(2 * plan.spans):
            i = (k // 2) * n + (k % 2) * (n - 1)
            p[0, i] = stiffness * (u[i + 1] - u[i]) * inverse
        push = torque[j] * per_radius
        shaft_forces(plan, x, x_t, motor, p, push, shaft)
        on_drive, on_load = rest_at(u, gain, 0, rigidity, h), -rest_at(u, gain, n - 1, rigidity, h)
        if closed:
            on_drive -= rest_at(u, gain, last - 1, rigidity, h)
            on_load += rest_at(u, gain, n, rigidity, h)
        drive_force, load_force = shaft[FORCE, 0], shaft[FORCE, 1]
        scale = 0.5 * step / root
        change, result, c = 0.0, 0.0, 1.0
        for trial in range(MOST_TRIALS):
            c = (psi + 0.5 * change) / root
            shaft[FORCE, 0], shaft[FORCE, 1] = drive_force + c * on_drive, load_force + c * on_load
            speed_shafts(plan, plan.shaft_matrices[0], shaft)
            rims = on_drive * (shaft[OLD, 0] + shaft[NEW, 0]) + on_load * (shaft[OLD, 1] + shaft[NEW, 1])
            result = -scale * (met + c * answer + rims)
            if abs(result - change) <= SETTLED * abs(result) or trial == MOST_TRIALS - 1:
                break
            change += (result - change) / (1.0 + 0.5 * scale / root * answer)
        place = motor[0]
        move_rims(plan, motor, x_t, shaft)
        motor[0] = sum_with_loss(extra, MOTOR_LOST, place, step * shaft[NEW, 2])
        extra[STORED] = sum_with_loss(extra, STORED_LOST, extra[STORED], result * (psi + 0.5 * change))
        drive = sum_with_loss(extra, DRIVE_LOST, u[0], step * shaft[NEW, 0])
        load = sum_with_loss(extra, LOAD_LOST, u[n], step * shaft[NEW, 1])

        softer = rigidity * (1.0 - c)
        pull = pretension + c * gain[0]
        p_u, p_v, p_w = (pull + softer) * (u[1] - u[0]) + c * gain[0] * h, 0.0, pull * w[1]
        if v is not None:
            p_v = pull * v[1]
        squares = 0.0
        for i in range(last):
            g = c * gain[i]
            pull = pretension + g
            du = u[i + 1] - u[i]
            q = (pull + softer) * du + g * h
            speed = u_t[i] + fall_u[i] + kick_u * (q - p_u)
            p_u = q
            u_t[i] = speed
            u[i] += step * speed
            if v is not None and v_t is not None:
                q = pull * (v[i + 1] - v[i])
                speed = keep * v_t[i] + kick_t * (q - p_v)
                p_v = q
                twice = speed + v_t[i]
                squares += twice * twice
                v_t[i] = speed
                v[i] += step * speed
            q = pull * (w[i + 1] - w[i])
            speed = keep * w_t[i] + fall_w[i] + kick_t * (q - p_w)
            p_w = q
            twice = speed + w_t[i]
            squares += twice * twice
            w_t[i] = speed
            w[i] += step * speed
        squares -= w_t[n] ** 2 if closed else 0.0
        u[0], u[n], u_t[0], u_t[n] = drive, load, shaft[NEW, 0], shaft[NEW, 1]
        w[0], w[n], w_t[0], w_t[n] = 0.0, 0.0, 0.0, 0.0
        if v is not None and v_t is not None:
            squares -= v_t[n] ** 2 if closed else 0.0
            v[0], v[n], v_t[0], v_t[n] = 0.0, 0.0, 0.0, 0.0
        if closed:
            u[last], u_t[last] = drive, shaft[NEW, 0]
        if loss > 0.0:
            add_to(tallies, int(TRANSVERSE_LOSS), loss * squares)
        tally_shafts(plan, push, shaft, tallies)
    return torque.size


@njit_in_place
def integrate_equal_segments(
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
    """Integrate from step ``first``, the first of a record, from record to record.

    Returns the step it comes to, the end or one at whose start a segment is slack or out of range; and
    whether the energy is finite.
    """
    x_t, motor, tallies = state.x_t, state.motor, state.tallies
    gain = work.q[3]
    j = first
    while j < torque.size:
        stop = min(torque.size, j - j % every + every)
        recording = j % every == 0
        stored = state.extra[STORED]
        if recording:
            stop = j + 1
            keep_before(state, work)
        taken = step_equal_segments(plan, state, work, torque[j:stop], gain, u, v, w, u_t, v_t, w_t)
        j += taken
        state.counts[STEPS] += taken
        if taken > 0:
            state.counts[UPPER_SLACK] = 0
            state.counts[LOWER_SLACK] = 0
        if j < stop:
            return j, True
        if recording:
            row = rows[(j - 1) // every]
            record_exact(plan, work, x_t, motor, tallies, torque[j - 1], row)
            row[BALANCE] += own_balance(plan, work, x_t, 0.5 * (stored + state.extra[STORED]))
            if fields.shape[0] > 0:
                copy_rows(work.before[0], fields[(j - 1) // every])
            if not abs(row[BALANCE]) < 1e300:
                return j, False
    return j, True
