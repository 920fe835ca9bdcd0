r"""Compiled motion of the coordinates of a network over one step, with implicit friction.

They obey

.. math:: \Bigl(\frac{M}{\Delta t} + \frac{C}{2}\Bigr) \dot q_+ + R^T\lambda
          = f + \Bigl(\frac{M}{\Delta t} - \frac{C}{2}\Bigr) \dot q_-, \qquad
          f = \sum B_a^T p_a - B_b^T p_b - K q + f_\text{motor}

with friction :math:`\lambda \in c\,\mathrm{Sgn}(R\dot q_+)` by projected Gauss-Seidel.
"""

from typing import Any

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_strict
from cabledrive.simulation.network import plan as at
from cabledrive.simulation.network.plan import NetworkPlan, NetworkState, NetworkWorkspace
from cabledrive.simulation.observe import add_to

MOST_SWEEPS = 200


@njit_strict
@for_kernels
def turn_network(plan: NetworkPlan, q_t: Array, work: NetworkWorkspace) -> None:
    """New speeds of the coordinates from the forces, Eq. (N.9)."""
    right, new, n = work.right, work.new, q_t.size
    for i in range(n):
        total = work.force[i]
        for k in range(n):
            total += plan.back[i, k] * q_t[k]
        right[i] = total
    for i in range(n):
        total = 0.0
        for k in range(n):
            total += plan.inverse[i, k] * right[k]
        new[i] = total
    rub(plan, work)


@njit_strict
@for_kernels
def rub(plan: Any, work: Any) -> None:
    """Friction of everything that rubs, and what it leaves of the speeds; of a prescribed one its bound."""
    new, count, n = work.new, plan.bound.size, work.new.size
    for k in range(count):
        work.friction[k] = 0.0
        work.bound[k] = plan.bound[k]
        before, behind = plan.wrap[k, 0], plan.wrap[k, 1]
        if before >= 0:  # Euler and Eytelwein: friction per tension of the slacker side
            entering = plan.piece[before, at.PRETENSION] + work.pull[before, 1, 0]
            leaving = plan.piece[behind, at.PRETENSION] + work.pull[behind, 0, 0]
            work.bound[k] *= max(min(entering, leaving), 0.0)
    for _ in range(MOST_SWEEPS if count > 0 else 0):
        change, size = 0.0, 0.0
        for k in range(count):
            speed = 0.0
            for i in range(n):
                speed += plan.rub[k, i] * new[i]
            old = work.friction[k]
            if plan.rub_own[k] == 0.0:
                if speed != 0.0:
                    work.friction[k] = work.bound[k] if speed > 0.0 else -work.bound[k]
                continue
            held = min(max(old + speed / plan.rub_own[k], -work.bound[k]), work.bound[k])
            if held != old:
                work.friction[k] = held
                for i in range(n):
                    new[i] -= plan.rub_mobility[i, k] * (held - old)
            change = max(change, abs(held - old))
            size = max(size, abs(held))
        if change <= 1e-15 * size:
            break


@njit_in_place
@for_kernels
def gather(plan: NetworkPlan, q: Array, torque: Array, work: NetworkWorkspace) -> None:
    """Forces on the coordinates: springs, motors and the ends of all pieces."""
    force, n = work.force, q.size
    for i in range(n):
        total = plan.rest[i]
        for k in range(n):
            total -= plan.stiffness[i, k] * q[k]
        force[i] = total
    for m in range(torque.size):
        for i in range(n):
            force[i] += plan.motor[m, i] * torque[m]
    for piece in range(plan.nodes.shape[0]):
        ropes = plan.piece[piece, at.ROPES]
        for side in range(2):
            sign = ropes if side == 0 else -ropes
            for axis in range(3):
                row = 6 * piece + 3 * side + axis
                pull = sign * work.pull[piece, side, axis]
                for entry in range(plan.row_start[row], plan.row_start[row + 1]):
                    force[plan.row_column[entry]] += plan.row_value[entry] * pull


@njit_in_place
@for_kernels
def place_ends(plan: NetworkPlan, q: Array, q_t: Array, x: Array, x_t: Array) -> None:
    """Ends of all pieces where the coordinates put them."""
    for piece in range(plan.nodes.shape[0]):
        for side in range(2):
            node = plan.nodes[piece, side]
            for axis in range(3):
                row = 6 * piece + 3 * side + axis
                place, speed = 0.0, 0.0
                for entry in range(plan.row_start[row], plan.row_start[row + 1]):
                    place += plan.row_value[entry] * q[plan.row_column[entry]]
                    speed += plan.row_value[entry] * q_t[plan.row_column[entry]]
                x[axis, node] = place
                x_t[axis, node] = speed


@njit_in_place
@for_kernels
def move_coordinates(plan: NetworkPlan, torque: Array, state: NetworkState, work: NetworkWorkspace) -> None:
    """New speeds and places of the coordinates, with the works and losses of the step."""
    q, q_t, new, step = state.q, state.q_t, work.new, plan.step
    gather(plan, q, torque, work)
    turn_network(plan, q_t, work)
    worked, viscous, coulomb = 0.0, 0.0, 0.0
    for i in range(q.size):
        mean = 0.5 * (q_t[i] + new[i])
        for m in range(torque.size):
            worked += plan.motor[m, i] * torque[m] * mean
        lost = 0.0
        for k in range(q.size):
            lost += plan.damping[i, k] * 0.5 * (q_t[k] + new[k])
        viscous += lost * mean
        for k in range(plan.bound.size):
            coulomb += work.friction[k] * plan.rub[k, i] * mean
    add_to(state.tallies, int(at.TORQUE_WORK), step * worked)
    if viscous != 0.0:
        add_to(state.tallies, int(at.VISCOUS_LOSS), step * viscous)
    if coulomb != 0.0:
        add_to(state.tallies, int(at.COULOMB_LOSS), step * coulomb)
    for i in range(q.size):
        q_t[i] = new[i]
        q[i] += step * new[i]


@njit_in_place
@for_kernels
def keep_network_extremes(plan: NetworkPlan, state: NetworkState) -> None:
    """Least and largest of each coordinate, largest deflection out of plane at the middle of each piece."""
    for i in range(state.q.size):
        state.extremes[0, i] = min(state.extremes[0, i], state.q[i])
        state.extremes[1, i] = max(state.extremes[1, i], state.q[i])
    for piece in range(plan.nodes.shape[0]):
        first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
        low, high = (first + last) // 2, (first + last + 1) // 2
        state.peaks[piece] = max(state.peaks[piece], abs(0.5 * (state.x[2, low] + state.x[2, high])))
