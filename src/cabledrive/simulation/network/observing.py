"""Compiled record of one instant of a network: coordinates, tensions, energies, budget."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.network.plan import (
    DENSITY,
    PRETENSION,
    RIGIDITY,
    ROPES,
    TALLIES,
    TORQUE_WORK,
    H,
    NetworkPlan,
)
from cabledrive.simulation.network.state import NetworkState, NetworkWorkspace
from cabledrive.simulation.segment_laws import segment_energy, segment_tensions


@njit_in_place
@for_kernels
def record_network(
    plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace, torque: Array, row: Array
) -> bool:
    """Write one row, see `cabledrive.simulation.network.channels`; whether its balance is finite.

    The energy in the balance is the mean of those of the two half steps beside the instant, which leapfrog
    keeps to round-off for a linear machine: H + d . d / 2 - step/2 d . F with half the change d of the
    speeds.
    """
    n, pieces, motors = state.q.size, plan.nodes.shape[0], torque.size
    ropes_energy, strain, correction = 0.0, 0.0, 0.0
    tension, middle = 2 * n + motors, 2 * n + motors + 2 * pieces
    for piece in range(pieces):
        first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
        x = work.before[0]
        segment_tensions(
            plan.law,
            plan.tension_only,
            plan.piece[piece, PRETENSION],
            plan.piece[piece, RIGIDITY],
            x[:, first : last + 1],
            plan.inverse_spacing[first:last],
            work.p[:, first:last],
        )
        kinetic, changed = rope_motion(plan, piece, work, state.x_t)
        mean, least, stored = rope_strain(plan, piece, work)
        ropes_energy += kinetic
        correction += changed
        strain += stored
        row[tension + piece] = mean
        row[tension + pieces + piece] = least
        low, high = (first + last) // 2, (first + last + 1) // 2
        for axis in range(3):
            row[middle + 3 * piece + axis] = 0.5 * (x[axis, low] + x[axis, high])
    energies = middle + 3 * pieces
    bodies, springs, part = coordinate_energies(plan, state, work)
    for i in range(n):
        row[i] = work.before_q[0, i]
        row[n + i] = 0.5 * (work.before_q[1, i] + state.q_t[i])
    for m in range(motors):
        row[2 * n + m] = torque[m]
    row[energies] = ropes_energy
    row[energies + 1] = bodies
    row[energies + 2] = strain
    row[energies + 3] = springs
    balance = ropes_energy + bodies + strain + springs + correction + part
    for k in range(TALLIES):
        value = 0.5 * (work.before_tallies[0, k] + state.tallies[0, k])
        row[energies + 4 + k] = value
        balance += -value if k == TORQUE_WORK else value
    row[energies + 4 + TALLIES] = balance
    return abs(balance) < 1e300


@njit_in_place
@for_kernels
def rope_motion(plan: NetworkPlan, piece: int, work: NetworkWorkspace, after: Array) -> tuple[float, float]:
    """Kinetic energy of a piece's inner nodes; their part of the correction."""
    half = 0.5 * plan.piece[piece, DENSITY] * plan.run[piece, H]
    kinetic, correction = 0.0, 0.0
    for axis in range(3):
        for i in range(plan.nodes[piece, 0] + 1, plan.nodes[piece, 1]):
            old = work.before[1, axis, i]
            change = 0.5 * (after[axis, i] - old)
            kinetic += half * (old + change) ** 2
            correction += half * change * change
            correction -= 0.5 * plan.step * change * (work.p[axis, i] - work.p[axis, i - 1])
    return plan.piece[piece, ROPES] * kinetic, plan.piece[piece, ROPES] * correction


@njit_in_place
@for_kernels
def rope_strain(plan: NetworkPlan, piece: int, work: NetworkWorkspace) -> tuple[float, float, float]:
    """Mean and least tension of one rope of a piece, and the energy that all its ropes store."""
    x, h = work.before[0], plan.run[piece, H]
    pretension = plan.piece[piece, PRETENSION]
    stiffness = pretension + plan.piece[piece, RIGIDITY]
    first, last = plan.nodes[piece, 0], plan.nodes[piece, 1]
    mean, least, stored = 0.0, 1e300, 0.0
    for i in range(first, last):
        pull, density = segment_energy(
            plan.law, plan.tension_only, pretension, stiffness, x, plan.inverse_spacing, i
        )
        mean += pull
        least = min(least, pull)
        stored += density * h
    return mean / (last - first), least, plan.piece[piece, ROPES] * stored


@njit_in_place
@for_kernels
def coordinate_energies(
    plan: NetworkPlan, state: NetworkState, work: NetworkWorkspace
) -> tuple[float, float, float]:
    """Kinetic energy of bodies, pulleys and half cells; energy of springs; part of the correction."""
    n = state.q.size
    kinetic, springs, correction = 0.0, 0.0, 0.0
    for i in range(n):
        work.right[i] = plan.rest[i]
        for k in range(n):
            work.right[i] -= plan.stiffness[i, k] * work.before_q[0, k]
            mean = 0.5 * (work.before_q[1, i] + state.q_t[i]) * 0.5 * (work.before_q[1, k] + state.q_t[k])
            change = 0.5 * (state.q_t[i] - work.before_q[1, i]) * 0.5 * (state.q_t[k] - work.before_q[1, k])
            kinetic += 0.5 * plan.mass[i, k] * mean
            correction += 0.5 * plan.mass[i, k] * change
            springs += 0.5 * plan.stiffness[i, k] * work.before_q[0, i] * work.before_q[0, k]
        springs -= plan.rest[i] * work.before_q[0, i]
    for piece in range(plan.nodes.shape[0]):
        for side in range(2):
            segment = plan.nodes[piece, 0] if side == 0 else plan.nodes[piece, 1] - 1
            sign = plan.piece[piece, ROPES] if side == 0 else -plan.piece[piece, ROPES]
            for axis in range(3):
                row = 6 * piece + 3 * side + axis
                for entry in range(plan.row_start[row], plan.row_start[row + 1]):
                    work.right[plan.row_column[entry]] += sign * plan.row_value[entry] * work.p[axis, segment]
    for i in range(n):
        correction -= 0.25 * plan.step * (state.q_t[i] - work.before_q[1, i]) * work.right[i]
    return kinetic, springs, correction
