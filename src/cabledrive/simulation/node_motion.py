"""New speeds of nodes and shafts over a step, with friction and axial damping solved for, compiled."""

from math import sqrt, tanh

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_strict
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import (
    AXIAL_LOSS,
    FORCE_WORK,
    TRANSVERSE_LOSS,
)
from cabledrive.simulation.observe import (
    SHAFTS,
    add_to,
    copy_rows,
)
from cabledrive.simulation.plan import Plan, State, Workspace

MOST_SWEEPS = 100


@njit_in_place
@for_kernels
def move(
    plan: Plan, centred: Array | None, state: State, work: Workspace, push: float, forces: Array
) -> None:
    """New speeds of nodes and shafts under the components in ``work.p``; the motor moves on at once."""
    shaft_forces(plan, state, work, push)
    if centred is not None:
        kick_centred(plan, state.x, state.x_t, work.old, centred)
    else:
        kick_nodes(plan, state.x_t, work, forces)
    turn(plan, state.x_t, state.tallies, work)
    move_rims(plan, state, work.shaft)


@njit_in_place
@for_kernels
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


@njit_in_place
@for_kernels
def turn(plan: Plan, x_t: Array, tallies: Array, work: Workspace) -> None:
    """New speeds of the shafts, with axial damping those of the nodes as well."""
    if plan.axial_damping > 0.0:
        damp_axially(plan, x_t, tallies, work)
    else:
        speed_shafts(plan, plan.shaft_matrices[0], work.shaft)


@njit_in_place
@for_kernels
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


@njit_in_place
@for_kernels
def kick_centred(plan: Plan, x: Array, x_t: Array, old: Array, gained: Array) -> None:
    """New speeds from the equations of motion written out at the nodes, Eqs. (2.33) and (2.34)."""
    h, node = plan.segment[at.INVERSE_SPACING, 0], plan.node
    c_u2, c_w2 = (plan.rigidity + plan.pretension) / plan.density, plan.pretension / plan.density
    for i in range(1, x.shape[1] - 1):
        u_x, u_xx = 0.5 * h * (x[0, i + 1] - x[0, i - 1]), h * h * (x[0, i + 1] - 2.0 * x[0, i] + x[0, i - 1])
        v_x, v_xx = 0.5 * h * (x[1, i + 1] - x[1, i - 1]), h * h * (x[1, i + 1] - 2.0 * x[1, i] + x[1, i - 1])
        w_x, w_xx = 0.5 * h * (x[2, i + 1] - x[2, i - 1]), h * h * (x[2, i + 1] - 2.0 * x[2, i] + x[2, i - 1])
        # stretch, its derivative, T over rho and over the stretch; the linear law has neither
        bent = 0.0 if plan.law == at.LINEAR else 1.0
        stretch, strain_x = 1.0 + u_x + 0.5 * bent * (v_x * v_x + w_x * w_x), u_xx + v_x * v_xx + w_x * w_xx
        if plan.law == at.EXACT:
            stretch = sqrt((1.0 + u_x) ** 2 + v_x * v_x + w_x * w_x)
            strain_x = (strain_x + u_x * u_xx) / stretch
        if plan.law == at.EXACT or plan.law == at.WEAK:
            across = (c_w2 + c_u2 * (stretch - 1.0)) / stretch
            turning = (c_u2 - across) * strain_x / stretch
            along = turning * (1.0 + u_x) + across * u_xx
        else:
            across = c_w2 + bent * c_u2 * (stretch - 1.0)
            turning = bent * c_u2 * strain_x
            along = turning if bent > 0.0 else c_u2 * u_xx
        gained[0, i] = plan.step * along
        gained[1, i], gained[2, i] = turning * v_x + across * v_xx, turning * w_x + across * w_xx
    copy_rows(x_t, old)
    for i in range(1, x.shape[1] - 1):
        if node[at.KICK_U, i] > 0.0:  # no rim
            damped = plan.step * node[at.KICK_T, i] / node[at.KICK_U, i]
            x_t[0, i] += gained[0, i] + node[at.FALL_U, i]
            x_t[1, i] = node[at.KEEP_T, i] * x_t[1, i] + damped * gained[1, i]
            x_t[2, i] = node[at.KEEP_T, i] * x_t[2, i] + damped * gained[2, i] + node[at.FALL_W, i]


@njit_in_place
@for_kernels
def shaft_forces(plan: Plan, state: State, work: Workspace, push: float) -> None:
    """Speeds of drive pulley, load pulley and motor before the step, and the forces on them, at the rim."""
    x, x_t, motor, p, shaft = state.x, state.x_t, state.motor, work.p, work.shaft
    n, end, weight, holding = plan.segments, p.shape[1], plan.node[at.WEIGHT_U], plan.shaft[at.HOLDING]
    shaft[at.OLD, 0], shaft[at.OLD, 1], shaft[at.OLD, 2] = x_t[0, 0], x_t[0, n], motor[1]
    twisted = plan.joint_stiffness * (x[0, 0] - motor[0])
    shaft[at.FORCE, 0] = p[0, 0] + weight[0] - twisted - holding[0] * x[0, 0]
    shaft[at.FORCE, 1] = weight[n] - p[0, n - 1]
    shaft[at.FORCE, 2] = twisted - holding[2] * motor[0]
    if plan.closed:
        shaft[at.FORCE, 0] -= p[0, end - 1]
        shaft[at.FORCE, 1] += p[0, n]
    shaft[at.FORCE, plan.driven] += push


@njit_in_place
@for_kernels
def speed_shafts(plan: Plan, matrix: Array, shaft: Array) -> None:
    """New speeds of the shafts from the forces on them."""
    for i in range(SHAFTS):
        shaft[at.RIGHT, i] = shaft[at.FORCE, i]
        for k in range(SHAFTS):
            shaft[at.RIGHT, i] += plan.shaft_matrices[1, i, k] * shaft[at.OLD, k]
    solve_shafts(matrix, plan.shaft, shaft)


@njit_in_place
@for_kernels
def move_rims(plan: Plan, state: State, shaft: Array) -> None:
    """New speeds of the shafts to rim nodes and motor, which moves on at once."""
    state.motor[1] = shaft[at.NEW, 2]
    state.motor[0] += plan.step * shaft[at.NEW, 2]
    state.x_t[0, 0], state.x_t[0, plan.segments] = shaft[at.NEW, 0], shaft[at.NEW, 1]
    if plan.closed:
        state.x_t[0, state.x_t.shape[1] - 1] = shaft[at.NEW, 0]


@njit_strict
@for_kernels
def solve_shafts(matrix: Array, table: Array, shaft: Array) -> None:
    """Speeds after the step: matrix @ new + friction = right, by coordinate descent on a convex function.

    Friction in ``coulomb * Sgn(new)``, or ``coulomb * tanh((old + new) / 2 / smoothing speed)``.
    """
    coupled = matrix[0, 1] != 0.0 or matrix[0, 2] != 0.0 or matrix[1, 2] != 0.0
    for i in range(SHAFTS):
        shaft[at.NEW, i] = shaft[at.OLD, i] * table[at.TURNS, i]
        shaft[at.FRICTION, i] = 0.0
    for _ in range(MOST_SWEEPS if coupled else 1):
        change, size = 0.0, 0.0
        for i in range(SHAFTS):
            if table[at.TURNS, i] == 0.0:
                continue
            rest, coulomb = shaft[at.RIGHT, i], table[at.COULOMB, i]
            for k in range(SHAFTS):
                rest -= 0.0 if k == i else matrix[i, k] * shaft[at.NEW, k]
            if table[at.SMOOTH, i] > 0.0:
                speed = _smoothed(matrix[i, i], rest, coulomb, table[at.SMOOTH, i], shaft[at.OLD, i])
            else:
                speed = (rest - min(max(rest, -coulomb), coulomb)) / matrix[i, i]
            if coulomb > 0.0:
                shaft[at.FRICTION, i] = rest - matrix[i, i] * speed
            change = max(change, abs(speed - shaft[at.NEW, i]))
            size = max(size, abs(speed))
            shaft[at.NEW, i] = speed
        if change <= 1e-15 * size:
            break


@njit_strict
def _smoothed(inertia: float, rest: float, coulomb: float, smooth: float, old: float) -> float:
    """New speed under tanh friction at the mean speed: Newton on a monotone function, kept in its bracket."""
    total = rest + inertia * old  # 2 inertia mean + coulomb tanh(mean / smooth) = total
    low, high = (total - coulomb) / (2.0 * inertia), (total + coulomb) / (2.0 * inertia)
    mean = min(max(old, low), high)
    for _ in range(60):
        push = tanh(mean / smooth)
        excess = 2.0 * inertia * mean + coulomb * push - total
        low, high = (low, mean) if excess > 0.0 else (mean, high)
        better = mean - excess / (2.0 * inertia + coulomb * (1.0 - push * push) / smooth)
        if not low < better < high:
            better = 0.5 * (low + high)
        if abs(better - mean) <= 1e-15 * abs(better):
            break
        mean = better
    return 2.0 * mean - old


@njit_in_place
@for_kernels
def damp_axially(plan: Plan, x_t: Array, tallies: Array, work: Workspace) -> None:
    r"""Kelvin-Voigt damping, implicit: an unknown tension per segment, together with the shafts' speeds.

    The damping tension of a segment, :math:`q = \beta\,d\cdot\Delta V`, acts along :math:`d` of
    `strain_directions`; V is the mean velocity, which q itself changes. Each span answers to the speeds of
    its rims with :math:`q = q_0 + q_a V_a + q_b V_b`.
    """
    n, d, q, shaft, matrix, node = plan.segments, work.direction, work.q, work.shaft, work.matrix, plan.node
    for axis in range(3):
        for i in range(x_t.shape[1]):
            work.mean[axis, i] = 0.5 * (work.old[axis, i] + x_t[axis, i])
    copy_rows(plan.shaft_matrices[0], matrix)
    for span in range(plan.spans):
        first, last, start, end = span * n, (span + 1) * n, span, 1 - span  # and the shafts at its ends
        solve_span(plan, first, last, work)
        for side in range(2):
            own = start if side == 0 else end
            segment = first if side == 0 else last - 1
            pull = d[0, segment] if side == 0 else -d[0, segment]
            to_start, to_end = 0.5 * pull * q[1, segment], 0.5 * pull * q[2, segment]
            shaft[at.FORCE, own] += (
                pull * q[0, segment] + to_start * shaft[at.OLD, start] + to_end * shaft[at.OLD, end]
            )
            matrix[own, start] -= to_start
            matrix[own, end] -= to_end
    speed_shafts(plan, matrix, shaft)
    loss = 0.0
    for i in range(q.shape[1]):
        start = i // n
        q[0, i] += 0.5 * q[1, i] * (shaft[at.OLD, start] + shaft[at.NEW, start])
        q[0, i] += 0.5 * q[2, i] * (shaft[at.OLD, 1 - start] + shaft[at.NEW, 1 - start])
        loss += plan.segment[at.COMPLIANCE, i] * q[0, i] ** 2
    add_to(tallies, int(AXIAL_LOSS), plan.step * loss)
    for axis in range(3):
        kick = node[at.KICK_U if axis == 0 else at.KICK_T]
        for i in range(1, q.shape[1]):
            x_t[axis, i] += kick[i] * (d[axis, i] * q[0, i] - d[axis, i - 1] * q[0, i - 1])


@njit_in_place
@for_kernels
def solve_span(plan: Plan, first: int, last: int, work: Workspace) -> None:
    """Damping tensions of a span, tridiagonal: constant part, answers to its rims' unit speeds, pivots."""
    d, q, link = work.direction, work.q, 0.0
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
        q[1, i] = 0.0 if i > first else -d[0, i]
        q[2, i] = 0.0 if i < last - 1 else d[0, i]
        if i > first:  # eliminate the segment before
            share = link / q[3, i - 1]
            own -= share * link
            for k in range(3):
                q[k, i] -= share * q[k, i - 1]
        q[3, i] = own
    for i in range(last - 1, first - 1, -1):
        link = 0.0
        for axis in range(3):
            if i < last - 1:
                link -= (
                    0.5
                    * plan.node[at.KICK_U if axis == 0 else at.KICK_T, i + 1]
                    * d[axis, i]
                    * d[axis, i + 1]
                )
        for k in range(3):
            q[k, i] -= link * q[k, min(i + 1, last - 1)]
            q[k, i] /= q[3, i]
