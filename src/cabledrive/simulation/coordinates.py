r"""Compiled motion of the coordinates over one step, with implicit friction.

They obey

.. math:: \Bigl(\frac{M}{\Delta t} + \frac{C}{2}\Bigr) \dot q_+ + R^T\lambda
          = f + \Bigl(\frac{M}{\Delta t} - \frac{C}{2}\Bigr) \dot q_-, \qquad
          f = \sum B_a^T p_a - B_b^T p_b - K q + f_\text{motor}

with friction :math:`\lambda \in c\,\mathrm{Sgn}(R\dot q_+)`, or
:math:`c \tanh(R(\dot q_- + \dot q_+)/2s)`, by projected Gauss-Seidel.
"""

from math import sqrt, tanh
from typing import Any

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_inner, njit_strict
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import COULOMB_LOSS, JOINT_LOSS, TORQUE_WORK, VISCOUS_LOSS
from cabledrive.simulation.observe import add_to
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import add_pulls

MOST_SWEEPS = 200


@njit_strict
@for_kernels
def dot(a: Array, b: Array) -> float:
    """Sum of the products of two rows, in their order."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@njit_inner
def gather(plan: Plan, q: Array, torque: Array, work: Workspace) -> None:
    """Forces on the coordinates: springs, weights, motors and the ends of all pieces."""
    force = work.force
    for i in range(q.size):
        force[i] = plan.rest[i] - dot(plan.stiffness[i], q) + dot(plan.motor[:, i], torque)
    add_pulls(plan, work, force)


@njit_strict
@for_kernels
def turn(plan: Plan, q_t: Array, inverse: Array, mobility: Array, own: Array, work: Workspace) -> None:
    """New speeds of the coordinates from the forces, Eq. (N.9); what sticks stands still."""
    right, new, n = work.right, work.new, q_t.size
    for i in range(n):
        right[i] = work.force[i] - dot(plan.loss[i], q_t)
    for i in range(n):  # added to the old speeds: with M times them rounding would grow step by step
        new[i] = q_t[i] + dot(inverse[i], right)
    rub(plan, q_t, mobility, own, work)
    for k in range(plan.bound.size):
        if plan.stick[k] >= 0 and plan.smooth[k] == 0.0 and abs(work.friction[k]) < work.bound[k]:
            new[plan.stick[k]] = 0.0


@njit_strict
@for_kernels
def rub(plan: Any, q_t: Array, mobility: Array, own: Array, work: Any) -> None:
    """Friction of everything that rubs, and what it leaves of the speeds; of a prescribed one its bound."""
    new, count, n = work.new, plan.bound.size, work.new.size
    for k in range(count):
        work.friction[k] = 0.0
        work.bound[k] = plan.bound[k]
        before, behind = plan.wrap[k, 0], plan.wrap[k, 1]
        if before >= 0:  # Euler and Eytelwein: friction per tension of the slacker side
            work.bound[k] *= min(end_tension(plan, work, before, 1), end_tension(plan, work, behind, 0))
    for _ in range(MOST_SWEEPS if count > 0 else 0):
        change, size = 0.0, 0.0
        for k in range(count):
            speed, slow, old = dot(plan.rub[k], new), dot(plan.rub[k], q_t), work.friction[k]
            if own[k] == 0.0:
                if speed != 0.0:
                    work.friction[k] = work.bound[k] if speed > 0.0 else -work.bound[k]
                continue
            if plan.smooth[k] > 0.0:
                free = speed / own[k] + old
                held = free - smoothed(1.0 / own[k], free, work.bound[k], plan.smooth[k], slow) / own[k]
            else:
                held = min(max(old + speed / own[k], -work.bound[k]), work.bound[k])
            if held != old:
                work.friction[k] = held
                for i in range(n):
                    new[i] -= mobility[i, k] * (held - old)
            change = max(change, abs(held - old))
            size = max(size, abs(held))
        if change <= 1e-15 * size or count == 1:
            break


@njit_inner
def end_tension(plan: Any, work: Any, piece: int, side: int) -> float:
    """Tension of one rope at an end of a piece, 0 where it pushes."""
    pull = work.pull[piece, side]
    along = plan.piece[piece, at.PRETENSION] + pull[0]
    return sqrt(along * along + pull[1] * pull[1] + pull[2] * pull[2]) if along > 0.0 else 0.0


@njit_strict
@for_kernels
def smoothed(inertia: float, rest: float, coulomb: float, smooth: float, old: float) -> float:
    """New speed under tanh friction at the mean speed: Newton on a monotone function, kept in its bracket."""
    total = rest + inertia * old  # 2 inertia mean + coulomb tanh(mean / smooth) = total
    low, high = (total - coulomb) / (2.0 * inertia), (total + coulomb) / (2.0 * inertia)
    mean = min(max(old, low), high)
    for _ in range(60):
        push = tanh(mean / smooth)
        excess, width = 2.0 * inertia * mean + coulomb * push - total, high - low
        low, high = (low, mean) if excess > 0.0 else (mean, high)
        better = mean - excess / (2.0 * inertia + coulomb * (1.0 - push * push) / smooth)
        if not low < better < high or 2.0 * (high - low) > width > smooth:  # from side to side of the bend
            better = 0.5 * (low + high)
        if abs(better - mean) <= 1e-15 * abs(better):
            break
        mean = better
    return 2.0 * mean - old


@njit_inner
def invert(matrix: Array, plan: Any, inverse: Array, mobility: Array, own: Array) -> None:
    """Inverse of a matrix without what is fixed or prescribed, and what friction does with it."""
    a, n = inverse, matrix.shape[0]
    for i in range(n):
        for j in range(n):
            a[i, j] = matrix[i, j] * plan.moves[i] * plan.moves[j]
    for k in range(n):
        if plan.moves[k] == 0.0:
            continue
        pivot = 1.0 / a[k, k]
        for i in range(n):
            if i != k:
                share = a[i, k] * pivot
                for j in range(n):
                    a[i, j] -= share * a[k, j]
                a[i, k] = -share
        for j in range(n):
            a[k, j] *= pivot
        a[k, k] = pivot
    for k in range(plan.bound.size):
        own[k] = 0.0
        for i in range(n):
            total = 0.0
            for j in range(n):
                total += a[i, j] * plan.rub[k, j]
            mobility[i, k] = total
            own[k] += plan.rub[k, i] * total


@njit_inner
def place_ends(plan: Plan, q: Array, q_t: Array, x: Array, x_t: Array) -> None:
    """Ends of all pieces where the coordinates put them."""
    for piece in range(plan.nodes.shape[0]):
        for side in range(2):
            node = plan.nodes[piece, side]
            for axis in range(3):
                row = 6 * piece + 3 * side + axis
                x[axis, node], x_t[axis, node] = end_moved(plan, row, q), end_moved(plan, row, q_t)
                if side == 1:
                    x[axis, node] += plan.piece[piece, at.END + axis]


@njit_inner
def end_moved(plan: Plan, row: int, q: Array) -> float:
    """Motion of an end of a piece along one of its directions, `Plan`'s row, by that of the coordinates."""
    moved = 0.0
    for entry in range(plan.row_start[row], plan.row_start[row + 1]):
        moved += plan.row_value[entry] * q[plan.row_column[entry]]
    return moved


@njit_inner
def advance(plan: Plan, state: State, torque: Array, work: Workspace) -> None:
    """Speeds and places of the coordinates after the step, with works and losses over it."""
    q, q_t, new, right, n = state.q, state.q_t, work.new, work.right, state.q.size
    worked, viscous, joint, coulomb = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        right[i] = 0.5 * (q_t[i] + new[i])
    for i in range(n):
        worked += dot(plan.motor[:, i], torque) * right[i]
        viscous += dot(plan.damping[0, i], right) * right[i]
        joint += dot(plan.damping[1, i], right) * right[i]
        coulomb += dot(work.friction, plan.rub[:, i]) * right[i]
    add_to(state.tallies, int(TORQUE_WORK), plan.step * worked)
    add_to(state.tallies, int(VISCOUS_LOSS), plan.step * viscous)
    add_to(state.tallies, int(JOINT_LOSS), plan.step * joint)
    add_to(state.tallies, int(COULOMB_LOSS), plan.step * coulomb)
    for i in range(n):
        q_t[i] = new[i]
        q[i] += plan.step * new[i]
