"""Compiled record of one instant of a run in which bodies travel."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.travel.plan import (
    DENSITY,
    RIGIDITY,
    ROPES,
    TALLIES,
    TORQUE_WORK,
    WEIGHT_WORK,
    TravelPlan,
    TravelState,
    TravelWorkspace,
)

# Rows of TravelWorkspace.kept: speeds of the rope and of q half a step before, tallies, lengths of spans.
ROPE_SPEED, SPEED, TALLY, LENGTH = range(4)


@njit_in_place
@for_kernels
def note_places(plan: TravelPlan, state: TravelState, work: TravelWorkspace, row: Array) -> None:
    """Write what a row holds of places and tensions, and keep what `note_speeds` needs from before."""
    n, spans, motors = state.q.size, plan.rim.shape[0], plan.rotor.size
    for i in range(state.x.size):
        work.kept[ROPE_SPEED, i] = state.x_t[i]
    for k in range(state.tallies.shape[1]):
        work.kept[TALLY, k] = state.tallies[0, k]
    springs, strained, tension = 0.0, 0.0, 2 * n + motors
    for i in range(n):
        row[i] = state.q[i]
        work.kept[SPEED, i] = state.q_t[i]
        springs -= plan.rest[i] * state.q[i]
        for k in range(n):
            springs += 0.5 * plan.stiffness[i, k] * state.q[i] * state.q[k]
    for s in range(spans):
        first, last = plan.cells[s] + s, plan.cells[s + 1] + s
        work.kept[LENGTH, s] = state.length[s]
        cell, mean, least, stored = state.length[s] / (last - first), 0.0, 1e300, 0.0
        for j in range(first, last + 1):
            share = 0.5 if j in (first, last) else 1.0
            pull = work.tension[j] + work.damped[j]
            mean += share * pull / (last - first)
            stored += 0.5 * share * cell * work.tension[j] ** 2 / plan.piece[s, RIGIDITY]
            least = min(least, pull)
        row[tension + s], row[tension + spans + s] = mean, least
        row[tension + 2 * spans + s] = work.free[s]
        strained += plan.piece[s, ROPES] * stored
    energies = tension + 3 * spans
    row[energies + 2], row[energies + 3] = strained, springs


@njit_in_place
@for_kernels
def note_speeds(plan: TravelPlan, state: TravelState, work: TravelWorkspace, row: Array) -> bool:
    """Write the rest of a row after its step; whether its balance is finite.

    The kinetic energies are products of the speeds half a step before and after: with them leapfrog keeps the
    energy of a linear machine to round-off.
    """
    n, spans, motors = state.q.size, plan.rim.shape[0], plan.rotor.size
    energies = 2 * n + motors + 3 * spans
    ropes, bodies = 0.0, 0.0
    for s in range(spans):
        first, last = plan.cells[s], plan.cells[s + 1]
        mass = plan.piece[s, ROPES] * plan.piece[s, DENSITY] * work.kept[LENGTH, s] / (last - first)
        for i in range(first, last):
            ropes += 0.5 * mass * work.kept[ROPE_SPEED, i] * state.x_t[i]
    for i in range(n):
        row[n + i] = 0.5 * (work.kept[SPEED, i] + state.q_t[i])
        for k in range(n):
            bodies += 0.5 * work.matrix[0, i, k] * work.kept[SPEED, i] * state.q_t[k]
    for m in range(motors):
        row[2 * n + m] = work.torque[m]
    row[energies], row[energies + 1] = ropes, bodies
    balance = ropes + bodies + row[energies + 2] + row[energies + 3]
    for k in range(TALLIES):
        value = 0.5 * (work.kept[TALLY, k] + state.tallies[0, k])
        row[energies + 4 + k] = value
        balance += -value if k in (TORQUE_WORK, WEIGHT_WORK) else value
    row[energies + 4 + TALLIES] = balance
    return abs(balance) < 1e300
