r"""Axial dampers of ropes, and compiled steps of damped ropes while all is taut, under the exact law.

A damper :math:`\beta = b(1+\varepsilon_0)/h` in each segment acts on the mean speeds V over a step, which its
tension q itself changes: with the directions d of the segments

.. math:: \frac{q_i}{\beta_i} = d_{i+1/2}\cdot(V_{i+1} - V_i), \qquad
          V_i = V_i^* + \tfrac{g_i}{2}(q_i d_{i+1/2} - q_{i-1} d_{i-1/2}), \qquad g = \Delta t/m.

Where :math:`|d| = 1`, the matrix S of q differs from that of a straight rope by
:math:`1 - \cos` of the angles between neighbours alone. It is taken for one: eliminated once, from both ends
of a piece to its middle; directions of the rates and of the tensions stay those of the moving rope.

Components and directions of the segments come
from one polynomial: with the gain g of `cabledrive.simulation.plan`, 1 over the stretch is 1 - g / EA. What
the dampers take is the power of the tensions that act,

.. math:: \sum_i q_i\,d\cdot(V^*_{i+1} - V^*_i) - \tfrac12 \sum_i g_i\,|q_i d_{i+1/2} - q_{i-1} d_{i-1/2}|^2 .
"""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_inner
from cabledrive.parameters.arrays import Integers
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import AXIAL_LOSS, FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.coordinates import advance, gather, place_ends, turn
from cabledrive.simulation.node_motion import end_speed
from cabledrive.simulation.observe import add_to, keep_extremes
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import add_pulls, end_pulls, series, taut_range

STIFFEST = 500.0
"""Largest eigenvalue of the dampers over a step up to which the matrix of the straight rope is taken."""
TINY = 1e-20
"""Answers below this share are none: nothing is left of them in a sum."""
UNDAMPED, AS_STRAIGHT, AS_BENT = range(3)
"""How segments are damped where they point: not, with the matrix of straight ropes, or with their own."""
BEFORE, BEHIND, INVERSE, TO_START, TO_END = range(5)
"""Rows of the table of the dampers."""
RATE, HALF_SOLVED, TENSION = range(3)
"""Rows of `Workspace.damp` that the dampers use."""
MOST_TRIALS, SETTLED = 20, 1e-9

Rows = tuple[Array, Array]
Plane = tuple[Array, Array, Array, Array]
Out = tuple[Array, Array] | None


class Dampers(NamedTuple):
    """The eliminated matrices of all pieces, and what they do to the coordinates."""

    # (5, nodes - 1): shares of the elimination of the segment before, up to the middle, and of that behind,
    # from there on; 1 / pivot; answers to unit rates of the first and of the last segment [N s/m]
    table: Array
    loss: Array  # (n, n): of the coordinates' speeds [N s/m]
    stiffest: float  # largest eigenvalue of the dampers over a step; negative where nothing is damped

    def how(self, *, exact: bool) -> int:
        """How segments are damped under the exact law, or under another."""
        if self.stiffest < 0.0:
            return UNDAMPED
        return AS_STRAIGHT if exact and self.stiffest <= STIFFEST else AS_BENT


def eliminated(nodes: Integers, compliance: Array, kick: Array, ropes: Array, ends: Array) -> Dampers:
    """Eliminate the dampers of all pieces.

    ``compliance``, (nodes - 1,): h over b (1 + eps0) [m/s / N], 0 where nothing is damped; ``kick``,
    (nodes,): speed gained along u per force over a step; ``ends``, (pieces, 2, n): motion of both ends along.
    """
    from scipy.linalg import solveh_banded

    table, loss, stiffest = np.zeros((5, compliance.size)), np.zeros((ends.shape[-1],) * 2), -1.0
    for (first, last), count, (start, end) in zip(nodes, ropes, ends, strict=True):
        if compliance[first] == 0.0:
            continue
        half = 0.5 * kick[first : last + 1]
        half[[0, -1]] = 0.0
        pivot = compliance[first:last] + half[:-1] + half[1:]
        stiffest = max(stiffest, float((4.0 * (half[:-1] + half[1:]) / compliance[first:last]).max()))
        own, units = table[:, first:last], np.zeros((2, last - first))
        units[0, 0] = units[1, -1] = 1.0
        bands = np.stack([np.append(0.0, -half[1:-1]), pivot])
        answers = solveh_banded(bands, units.T).T if last - first > 1 else units / pivot
        own[TO_START:] = np.where(np.abs(answers) < TINY * np.abs(answers).max(), 0.0, answers)
        size, middle = last - first, (last - first - 1) // 2
        for i in range(1, middle + 1):
            own[BEFORE, i] = half[i] / pivot[i - 1]
            pivot[i] -= own[BEFORE, i] * half[i]
        for i in range(size - 2, middle - 1, -1):
            own[BEHIND, i] = half[i + 1] / pivot[i + 1]
            pivot[i] -= own[BEHIND, i] * half[i + 1]
        own[INVERSE] = 1.0 / pivot
        first_row = own[TO_END, 0] * end - own[TO_START, 0] * start
        last_row = own[TO_END, -1] * end - own[TO_START, -1] * start
        loss += count * (np.outer(end, last_row) - np.outer(start, first_row))
    return Dampers(table, loss, stiffest)


@njit_inner
def point(span: tuple[int, int], numbers: tuple[float, float], inverse: Array, place: Rows, p: Rows, d: Rows,
          out: tuple[Array, Array, Array] | None) -> int:  # fmt: skip
    """Components above the pretension and directions of a piece; how many segments leave the range."""
    pretension, rigidity = numbers
    (u, w), (p_u, p_w), (d_u, d_w) = place, p, d
    (_, centre, reach), outside = taut_range(pretension, rigidity), 0
    # Unsigned: an index that might be negative would keep the compiler from taking several nodes at once.
    one, start = np.uintp(1), np.uintp(span[0])
    for k in range(np.uintp(span[1]) - start):
        i = start + k
        after, h = i + one, inverse[i]
        u_x, w_x = (u[after] - u[i]) * h, (w[after] - w[i]) * h
        z = u_x * (2.0 + u_x) + w_x * w_x
        if out is not None:
            v_x = (out[0][after] - out[0][i]) * h
            z += v_x * v_x
        gain = series(z, z)
        outside += abs(z - centre) > reach
        shrink, pull = 1.0 - gain, pretension + rigidity * gain
        p_u[i], p_w[i] = pretension * u_x + rigidity * gain * (1.0 + u_x), pull * w_x
        d_u[i], d_w[i] = (1.0 + u_x) * shrink, w_x * shrink
        if out is not None:
            out[1][i], out[2][i] = pull * v_x, v_x * shrink
    return outside


@njit_inner
def coast(p: Array, kick: Array, keep: Array | None, fall: Array | None, speed: Array, mean: Array) -> None:
    """Mean speeds of all inner nodes over the step without the dampers."""
    one = np.uintp(1)
    for before in range(np.uintp(p.size) - one):
        i = before + one
        kicked = kick[i] * (p[i] - p[before])
        if fall is not None:
            kicked += fall[i]
        kept = speed[i]
        if keep is not None:
            kept = 0.5 * (kept + keep[i] * kept)
        mean[i] = kept + 0.5 * kicked


@njit_inner
def stretch_rates(d: Rows, mean: Rows, out: Rows | None, rate: Array) -> None:
    """Rates at which the segments lengthen without dampers, the ends of pieces as fast as they were."""
    (d_u, d_w), (m_u, m_w) = d, mean
    one = np.uintp(1)
    for i in range(np.uintp(rate.size)):
        after = i + one
        own = d_u[i] * (m_u[after] - m_u[i]) + d_w[i] * (m_w[after] - m_w[i])
        if out is not None:
            own += out[0][i] * (out[1][after] - out[1][i])
        rate[i] = own


@njit_inner
def end_tensions(table: Array, span: tuple[int, int], rate: Array) -> tuple[float, float]:
    """Tensions of the dampers at both ends of a piece: answers to the rates near them, a block at a time."""
    a, b, to_start, to_end, block = 0.0, 0.0, table[TO_START], table[TO_END], np.uintp(64)
    first, last = np.uintp(span[0]), np.uintp(span[1])
    low, high = first, last
    while low < last and to_start[low] != 0.0:
        size = min(block, last - low)
        for k in range(size):
            a += to_start[low + k] * rate[low + k]
        low += size
    while high > first and to_end[high - np.uintp(1)] != 0.0:
        size = min(block, high - first)
        high -= size
        for k in range(size):
            b += to_end[high + k] * rate[high + k]
    return a, b


@njit_inner
def solve(table: Array, firsts: tuple[int, int], size: int, right: Array, y: Array, q: Array) -> None:
    """Tensions of the dampers of two pieces of equal size, from both ends of both to their middles.

    Each recurrence waits for its own last number: four at a time take hardly longer than one.
    """
    before, behind, inverse = table[BEFORE], table[BEHIND], table[INVERSE]
    one, left = np.uintp(1), np.uintp((size - 1) // 2)
    one_start, two_start = np.uintp(firsts[0]), np.uintp(firsts[1])
    one_end, two_end = one_start + np.uintp(size) - one, two_start + np.uintp(size) - one
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    for k in range(left):
        i, j, m, n = one_start + k, one_end - k, two_start + k, two_end - k
        a = right[i] + before[i] * a
        b = right[j] + behind[j] * b
        c = right[m] + before[m] * c
        d = right[n] + behind[n] * d
        y[i], y[j], y[m], y[n] = a, b, c, d
    i, m = one_start + left, two_start + left
    j, n, odd = i + one, m + one, size % 2 == 1
    if not odd:  # the end of a piece has one more
        b, d = right[j] + behind[j] * b, right[n] + behind[n] * d
        y[j], y[n] = b, d
    a, c = right[i] + before[i] * a + behind[i] * b, right[m] + before[m] * c + behind[m] * d
    a, c = inverse[i] * a, inverse[m] * c
    q[i], q[m], b, d = a, c, a, c
    if not odd:
        b, d = inverse[j] * y[j] + behind[i] * a, inverse[n] * y[n] + behind[m] * c
        q[j], q[n] = b, d
    for number in range(left):
        back = left - one - number
        i, j, m, n = one_start + back, one_end - back, two_start + back, two_end - back
        a = inverse[i] * y[i] + before[i + one] * a
        b = inverse[j] * y[j] + behind[j - one] * b
        c = inverse[m] * y[m] + before[m + one] * c
        d = inverse[n] * y[n] + behind[n - one] * d
        q[i], q[j], q[m], q[n] = a, b, c, d


@njit_inner
def pull_back(span: tuple[int, int], q: Array, kick: Array, step: float, d: Array, mean: Array, place: Array,
              speed: Array, drag: Array | None, rate: Array | None) -> tuple[float, float]:  # fmt: skip
    """Speeds and places of a piece's inner nodes after the step.

    Returns sums: half of the dampers' forces times what they gain, less their tensions times the rates, where
    these are given; drag times the square of twice the mean speed.
    """
    forced, squares, one, start = 0.0, 0.0, np.uintp(1), np.uintp(span[0])
    for k in range(np.uintp(span[1]) - start - one):
        before = start + k
        i = before + one
        force = d[i] * q[i] - d[before] * q[before]
        gained = kick[i] * force
        forced += 0.5 * gained * force
        if rate is not None:
            forced -= q[i] * rate[i]
        twice = 2.0 * mean[i] + gained
        if drag is not None:
            squares += drag[i] * twice * twice
        new = twice - speed[i]
        speed[i] = new
        place[i] += step * new
    if rate is not None:
        forced -= q[span[0]] * rate[span[0]]
    return forced, squares


@njit_inner
def turn_damped(plan: Plan, state: State, torque: Array, work: Workspace) -> None:
    """New speeds of the coordinates, and what the ends of the pieces add to the rates of their segments.

    The matrix of the coordinates holds the answers of straight ropes. What true directions change of them is
    a small force by what the speeds gain, tried until it stays.
    """
    base, tried, force, n = work.trial[0], work.trial[1], work.force, state.q.size
    for piece in range(plan.nodes.shape[0]):
        span = plan.nodes[piece, 0], plan.nodes[piece, 1]
        work.ends[piece, 0], work.ends[piece, 1] = end_tensions(plan.damper, span, work.damp[RATE])
    end_pulls(plan, work.p, work)
    gather(plan, state.q, torque, work)
    for i in range(n):
        base[i], tried[i], work.new[i] = force[i], np.inf, state.q_t[i]
    for _ in range(MOST_TRIALS):
        for i in range(n):
            force[i] = 0.0
            for k in range(n):
                force[i] += 0.5 * plan.dampers[i, k] * (work.new[k] - state.q_t[k])
        pull_by_ends(plan, state.q_t, work)
        change, size = 0.0, 0.0
        for i in range(n):
            change, size = max(change, abs(force[i] - tried[i])), max(size, abs(force[i]))
            tried[i] = force[i]
            force[i] += base[i]
        if change <= SETTLED * size:
            break
        turn(plan, state.q_t, plan.inverse, plan.rub_mobility, plan.rub_own, work)


@njit_inner
def pull_by_ends(plan: Plan, q_t: Array, work: Workspace) -> None:
    """Tensions of the dampers at the ends of all pieces by the speeds there, and what these do to q."""
    d, table, ends, nodes = work.direction, plan.damper, work.ends, plan.nodes
    for piece in range(nodes.shape[0]):
        first, last, own = nodes[piece, 0], nodes[piece, 1] - 1, ends[piece]
        own[2] = -end_speed(plan, piece, 0, q_t, work, -0.5)
        own[3] = end_speed(plan, piece, 1, q_t, work, -0.5)
        own[4] = own[0] + table[TO_START, first] * own[2] + table[TO_START, last] * own[3]
        own[5] = own[1] + table[TO_END, first] * own[2] + table[TO_END, last] * own[3]
        for axis in range(3):
            work.pull[piece, 0, axis] = own[4] * d[axis, first]
            work.pull[piece, 1, axis] = own[5] * d[axis, last]
    add_pulls(plan, work, work.force)
    end_pulls(plan, work.p, work)  # wraps rub under elastic tensions, which no speed of the step changes


@njit_inner
def solve_all(plan: Plan, work: Workspace) -> None:
    """Tensions of all dampers, from rates to which the ends of the pieces add theirs."""
    nodes, rate, count = plan.nodes, work.damp[RATE], plan.nodes.shape[0]
    for piece in range(count):
        rate[nodes[piece, 0]] += work.ends[piece, 2]
        rate[nodes[piece, 1] - 1] += work.ends[piece, 3]
    piece = 0
    while piece < count:  # two of equal size at once; one alone takes both places
        size, second = nodes[piece, 1] - nodes[piece, 0], min(piece + 1, count - 1)
        if nodes[second, 1] - nodes[second, 0] != size:
            second = piece
        firsts = nodes[piece, 0], nodes[second, 0]
        solve(plan.damper, firsts, size, rate, work.damp[HALF_SOLVED], work.damp[TENSION])
        piece = second + 1
    for number in range(count):  # what the coordinates felt, to the last digit
        work.damp[TENSION, nodes[number, 0]] = work.ends[number, 4]
        work.damp[TENSION, nodes[number, 1] - 1] = work.ends[number, 5]


@njit_inner
def step_damped(
    plan: Plan, state: State, work: Workspace, inputs: tuple[Array, Array], plane: Plane, out: Out
) -> bool:
    """Take a step for each entry of the torque; without v the cable stays in the plane of the pulleys.

    Returns False as soon as a segment is found slack or out of the range of the series; the state is then of
    no use.
    """
    torque, forces = inputs
    u, w, u_t, w_t = plane
    x, x_t, node, nodes = state.x, state.x_t, plan.node, plan.nodes
    p_u, p_v, p_w = work.p[0], work.p[1], work.p[2]
    d_u, d_v, d_w = work.direction[0], work.direction[1], work.direction[2]
    m_u, m_v, m_w = work.mean[0], work.mean[1], work.mean[2]
    rate, q, inverse, step = work.damp[RATE], work.damp[TENSION], plan.segment[at.INVERSE_SPACING], plan.step
    kick_u, kick_t, keep, drag = node[at.KICK_U], node[at.KICK_T], node[at.KEEP_T], node[at.DRAG]
    for j in range(torque.shape[0]):
        keep_extremes(plan, state)
        outside = 0
        for piece in range(nodes.shape[0]):
            span = nodes[piece, 0], nodes[piece, 1]
            numbers = plan.piece[piece, at.PRETENSION], plan.piece[piece, at.RIGIDITY]
            if out is not None:
                outside += point(span, numbers, inverse, (u, w), (p_u, p_w), (d_u, d_w), (out[0], p_v, d_v))
            else:
                outside += point(span, numbers, inverse, (u, w), (p_u, p_w), (d_u, d_w), None)
        if outside > 0:
            return False
        coast(p_u, kick_u, None, node[at.FALL_U], u_t, m_u)
        coast(p_w, kick_t, keep, node[at.FALL_W], w_t, m_w)
        if out is not None:
            coast(p_v, kick_t, keep, None, out[1], m_v)
        worked = 0.0
        for k in range(plan.force.shape[0]):
            i, axis = plan.force[k, 0], plan.force[k, 1]
            work.mean[axis, i] += 0.5 * (kick_u if axis == 0 else kick_t)[i] * forces[j, k]
            worked += forces[j, k] * x_t[axis, i]
        for piece in range(nodes.shape[0]):
            for axis in range(3):
                for side in range(2):
                    work.mean[axis, nodes[piece, side]] = x_t[axis, nodes[piece, side]]
        if out is not None:
            stretch_rates((d_u, d_w), (m_u, m_w), (d_v, m_v), rate)
        else:
            stretch_rates((d_u, d_w), (m_u, m_w), None, rate)
        turn_damped(plan, state, torque[j], work)
        solve_all(plan, work)
        lost, squares = 0.0, 0.0
        for piece in range(nodes.shape[0]):
            span = nodes[piece, 0], nodes[piece, 1]
            f_u, _ = pull_back(span, q, kick_u, step, d_u, m_u, u, u_t, None, rate)
            f_w, of_w = pull_back(span, q, kick_t, step, d_w, m_w, w, w_t, drag, None)
            forced, squares = f_u + f_w, squares + of_w
            if out is not None:
                f_v, of_v = pull_back(span, q, kick_t, step, d_v, m_v, out[0], out[1], drag, None)
                forced, squares = forced + f_v, squares + of_v
            lost -= plan.piece[piece, at.ROPES] * forced
        add_to(state.tallies, int(AXIAL_LOSS), step * lost)
        for k in range(plan.force.shape[0]):
            worked += forces[j, k] * x_t[plan.force[k, 1], plan.force[k, 0]]
        if plan.force.shape[0] > 0:
            add_to(state.tallies, int(FORCE_WORK), 0.5 * step * worked)
        if squares > 0.0:
            add_to(state.tallies, int(TRANSVERSE_LOSS), 0.25 * step * squares)
        advance(plan, state, torque[j], work)
        place_ends(plan, state.q, state.q_t, x, x_t)
    return True
