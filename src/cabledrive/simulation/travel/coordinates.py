"""Compiled motion of bodies, pulleys and rotors over a step, with rope that comes onto drums."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.network.coordinates import rub
from cabledrive.simulation.observe import add_to
from cabledrive.simulation.travel.plan import (
    COULOMB_LOSS,
    DENSITY,
    DRUM,
    ROPES,
    TORQUE_WORK,
    VISCOUS_LOSS,
    WEIGHT_WORK,
    WOUND_ENERGY,
    TravelPlan,
    TravelState,
    TravelWorkspace,
)


@njit_in_place
@for_kernels
def fill_inverse(plan: TravelPlan, wound: Array, work: TravelWorkspace) -> None:
    """M with the rope on drums, M / step + C / 2, its inverse but for prescribed rotors, mobilities."""
    n, mass, matrix = plan.mass.shape[0], work.matrix[0], work.matrix[1]
    for i in range(n):
        for k in range(n):
            mass[i, k] = plan.mass[i, k]
    for s in range(plan.rim.shape[0]):
        for side in range(2):
            if plan.beyond[s, side] == DRUM:
                on_it = plan.piece[s, ROPES] * plan.piece[s, DENSITY] * wound[s, side]
                for i in range(n):
                    for k in range(n):
                        mass[i, k] += on_it * plan.turn[s, side, i] * plan.turn[s, side, k]
    for i in range(n):
        for k in range(n):
            matrix[i, k] = mass[i, k] / plan.step + 0.5 * plan.damping[i, k]
    invert(plan, work)
    for k in range(plan.bound.size):
        plan.rub_own[k] = 0.0
        for i in range(n):
            total = 0.0
            for m in range(n):
                total += plan.inverse[i, m] * plan.rub[k, m]
            plan.rub_mobility[i, k] = total
            plan.rub_own[k] += plan.rub[k, i] * total


@njit_in_place
@for_kernels
def invert(plan: TravelPlan, work: TravelWorkspace) -> None:
    """Inverse of a positive definite matrix by elimination, zero in the rows of prescribed rotors."""
    n, table = plan.mass.shape[0], work.elimination
    for i in range(n):
        for k in range(n):
            table[i, k] = work.matrix[1, i, k]
            table[i, n + k] = 1.0 if i == k else 0.0
    for m in range(plan.rotor.size if plan.prescribed else 0):
        own = plan.rotor[m]
        for k in range(n):
            table[own, k], table[k, own] = 0.0, 0.0
        table[own, own], table[own, n + own] = 1.0, 0.0
    for i in range(n):
        pivot = table[i, i]
        for k in range(2 * n):
            table[i, k] /= pivot
        for row in range(n):
            if row != i:
                factor = table[row, i]
                for k in range(2 * n):
                    table[row, k] -= factor * table[i, k]
    for i in range(n):
        for k in range(n):
            plan.inverse[i, k] = table[i, n + k]


@njit_in_place
@for_kernels
def gather_ends(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """Forces on the coordinates: springs, weights, the ropes' tensions, and the rope that runs over rims."""
    n = state.q.size
    for i in range(n):
        work.force[i], work.carried[i], work.fallen[i] = plan.rest[i], 0.0, 0.0
        for k in range(n):
            work.force[i] -= plan.stiffness[i, k] * state.q[k]
    for s in range(plan.rim.shape[0]):
        lines, density = plan.piece[s, ROPES], plan.piece[s, DENSITY]
        across = plan.gravity[1] * work.along[s, 0] - plan.gravity[0] * work.along[s, 1]
        hangs = 0.5 * lines * density * state.length[s] * across
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            cell = state.x_t[plan.cells[s] if side == 0 else plan.cells[s + 1] - 1]
            running, turning = lines * density * state.flow[s, side] / plan.step, 0.0
            for k in range(n):
                turning += plan.turn[s, side, k] * state.q_t[k]
            # Rope joins the rim with the speed of its cell, and leaves it with that of the rim.
            pull = sign * lines * work.pull[s, side, 0]
            pull += sign * 0.5 * running * (work.speed[s, side] - cell)
            for k in range(n):
                centre = work.rows[s, side, k] - plan.turn[s, side, k]
                work.force[k] += pull * work.rows[s, side, k]
                work.carried[k] -= sign * running * turning * centre
                work.fallen[k] += hangs * work.across[s, side, k]
    for k in range(n):
        work.force[k] += work.carried[k] + work.fallen[k]


@njit_in_place
@for_kernels
def turn_coordinates(plan: TravelPlan, state: TravelState, work: TravelWorkspace, given: Array) -> None:
    """New speeds of the coordinates, with the works and losses of the step.

    ``given``: torques of the rotors [N m], or their speeds over the step [rad/s] where they are prescribed.
    """
    n, old, new, matrix = state.q.size, state.q_t, work.new, work.matrix[1]
    gather_ends(plan, state, work)
    for m in range(given.size if not plan.prescribed else 0):
        work.force[plan.rotor[m]] += given[m]
    for i in range(n):
        total = work.force[i]
        for k in range(n):
            total += (2.0 * work.matrix[0, i, k] / plan.step - matrix[i, k]) * old[k]
        work.right[i] = total
    for i in range(n):
        total = 0.0
        for k in range(n):
            right = work.right[k]
            for m in range(given.size if plan.prescribed else 0):
                right -= matrix[k, plan.rotor[m]] * given[m]
            total += plan.inverse[i, k] * right
        new[i] = total
    for m in range(given.size if plan.prescribed else 0):
        new[plan.rotor[m]] = given[m]
    rub(plan, work)
    for m in range(given.size):
        own, torque = plan.rotor[m], given[m]
        if plan.prescribed:
            torque = -work.right[own]
            for k in range(n):
                torque += matrix[own, k] * new[k]
            for k in range(plan.bound.size):
                torque += plan.rub[k, own] * work.friction[k]
        work.torque[m] = torque
        add_to(state.tallies, int(TORQUE_WORK), 0.5 * plan.step * torque * (old[own] + new[own]))
    _count(plan, state, work)


@njit_in_place
@for_kernels
def _count(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """Losses and works of the coordinates over the step."""
    viscous, coulomb, turned, fallen = 0.0, 0.0, 0.0, 0.0
    for i in range(state.q.size):
        mean, lost = 0.5 * (state.q_t[i] + work.new[i]), 0.0
        for k in range(state.q.size):
            lost += plan.damping[i, k] * 0.5 * (state.q_t[k] + work.new[k])
        viscous += lost * mean
        for k in range(plan.bound.size):
            coulomb += work.friction[k] * plan.rub[k, i] * mean
        turned += work.carried[i] * mean
        fallen += work.fallen[i] * mean
    add_to(state.tallies, int(VISCOUS_LOSS), plan.step * viscous)
    add_to(state.tallies, int(COULOMB_LOSS), plan.step * coulomb)
    add_to(state.tallies, int(WOUND_ENERGY), -plan.step * turned)
    add_to(state.tallies, int(WEIGHT_WORK), plan.step * fallen)
