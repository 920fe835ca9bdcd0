r"""Compiled steps of spans whose lengths change, and the record of one instant.

A span holds the unstretched length L in n cells. Over a step the length :math:`\phi_a` runs in at its start
and :math:`\phi_b` out at its end, with the strain of the span from which it comes (a rope that sticks to its
rim). The cells keep their shares of L, so rope runs through them:

.. math:: \Phi_i = (1 - \xi_i)\phi_a + \xi_i\phi_b, \qquad
          x_i \leftarrow x_i + \Delta t\,v_i - D_a - (1 + \varepsilon_i)\Phi_i, \qquad \text{Eq. (N.12)}

with the advance :math:`D_a` of the point of contact along the span and the mean strain
:math:`\varepsilon_i` of the segments beside a cell, by which the strain energy that runs past it is exact.
"""

from math import atan2, log, sqrt

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place, njit_inner
from cabledrive.simulation.coordinates import dot
from cabledrive.simulation.observe import add_to
from cabledrive.simulation.plan import DONE, NOT_FINITE, SLACK
from cabledrive.simulation.travel import plan as at
from cabledrive.simulation.travel.cells import (
    damp_spans,
    fill_inverse,
    kick_cells,
    pull_spans,
    turn_coordinates,
)
from cabledrive.simulation.travel.plan import TravelPlan, TravelState, TravelWorkspace

# Rows of TravelWorkspace.kept: speeds of the rope and of q half a step before, tallies, lengths of spans.
ROPE_SPEED, SPEED, TALLY, LENGTH = range(4)


@njit_inner
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
        springs += (0.5 * dot(plan.stiffness[i], state.q) - plan.rest[i]) * state.q[i]
    for s in range(spans):
        first, last = plan.cells[s] + s, plan.cells[s + 1] + s
        work.kept[LENGTH, s] = state.length[s]
        cell, mean, least, stored = state.length[s] / (last - first), 0.0, 1e300, 0.0
        for j in range(first, last + 1):
            share = 0.5 if j in (first, last) else 1.0
            pull = work.tension[j] + work.damped[j]
            mean += share * pull / (last - first)
            stored += 0.5 * share * cell * work.tension[j] ** 2 / plan.piece[s, at.RIGIDITY]
            least = min(least, pull)
        row[tension + s], row[tension + spans + s] = mean, least
        row[tension + 2 * spans + s] = work.free[s]
        strained += plan.piece[s, at.ROPES] * stored
    energies = tension + 3 * spans
    row[energies + 2], row[energies + 3] = strained, springs


@njit_inner
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
        mass = plan.piece[s, at.ROPES] * plan.piece[s, at.DENSITY] * work.kept[LENGTH, s] / (last - first)
        for i in range(first, last):
            ropes += 0.5 * mass * work.kept[ROPE_SPEED, i] * state.x_t[i]
    for i in range(n):
        row[n + i] = 0.5 * (work.kept[SPEED, i] + state.q_t[i])
        bodies += 0.5 * dot(work.matrix[0, i], state.q_t) * work.kept[SPEED, i]
    for m in range(motors):
        row[2 * n + m] = work.torque[m]
    row[energies], row[energies + 1] = ropes, bodies
    balance = ropes + bodies + row[energies + 2] + row[energies + 3]
    for k in range(at.TALLIES):
        value = 0.5 * (work.kept[TALLY, k] + state.tallies[0, k])
        row[energies + 4 + k] = value
        balance += -value if k in (at.TORQUE_WORK, at.WEIGHT_WORK) else value
    row[energies + 4 + at.TALLIES] = balance
    return abs(balance) < 1e300


@njit_inner
def lay_spans(plan: TravelPlan, q: Array, work: TravelWorkspace) -> int:
    """Directions, free lengths and rows of all spans; the span that has no tangent, or -1.

    As Eq. (N.1).
    """
    for s in range(plan.rim.shape[0]):
        centre, frame = plan.centre[s], plan.frame[s]
        dx = centre[1, 0] - centre[0, 0] + dot(frame[1, 0], q) - dot(frame[0, 0], q)
        dy = centre[1, 1] - centre[0, 1] + dot(frame[1, 1], q) - dot(frame[0, 1], q)
        offset = plan.rim[s, 1] - plan.rim[s, 0]
        squared = dx * dx + dy * dy
        if not squared > offset * offset:
            return s
        free = sqrt(squared - offset * offset)
        tx, ty = (free * dx + offset * dy) / squared, (free * dy - offset * dx) / squared
        work.free[s], work.along[s, 0], work.along[s, 1] = free, tx, ty
        for side in range(2):
            for k in range(q.size):
                fx, fy = plan.frame[s, side, 0, k], plan.frame[s, side, 1, k]
                work.rows[s, side, k] = tx * fx + ty * fy + plan.turn[s, side, k]
                work.across[s, side, k] = tx * fy - ty * fx
    return -1


@njit_inner
def strain_at(plan: TravelPlan, work: TravelWorkspace, s: int, side: int) -> float:
    """Strain of a span beside one of its ends."""
    j = plan.cells[s] + s if side == 0 else plan.cells[s + 1] + s
    return work.tension[j] / plan.piece[s, at.RIGIDITY]


@njit_inner
def pass_end(
    plan: TravelPlan, state: TravelState, work: TravelWorkspace, s: int, side: int, run: float
) -> float:
    """Unstretched length that passes an end of a span, with the energies it takes along.

    ``run``: stretched length in the direction of travel [m].
    """
    own = strain_at(plan, work, s, side)
    there, lines = plan.beyond[s, side], plan.piece[s, at.ROPES]
    enters = run > 0.0 if side == 0 else run < 0.0
    carried = strain_at(plan, work, there, 1 - side) if enters and there >= 0 else own
    passed = run / (1.0 + carried)
    out = passed if side == 1 else -passed
    half = 0.5 * plan.piece[s, at.RIGIDITY] * lines
    add_to(state.tallies, int(at.WOUND_ENERGY), out * half * carried * carried)
    if enters:
        add_to(state.tallies, int(at.CREEP_LOSS), abs(passed) * half * (carried - own) ** 2)
    if there == at.DRUM:
        state.wound[s, side] += out
    else:
        kinetic = 0.5 * plan.piece[s, at.DENSITY] * lines * work.speed[s, side] ** 2
        add_to(state.tallies, int(at.WOUND_ENERGY), out * kinetic)
    return passed


@njit_inner
def move_cells(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> None:
    """Places of the rope a step on, Eq. (N.12)."""
    for s in range(plan.rim.shape[0]):
        first, last = plan.cells[s], plan.cells[s + 1]
        n = last - first
        ax, ay, bx, by = work.before[s, 0], work.before[s, 1], work.along[s, 0], work.along[s, 1]
        turned = atan2(ax * by - ay * bx, ax * bx + ay * by)
        advance = plan.rim[s, 0] * turned  # of the point of contact along the span
        frame_x, frame_y = dot(plan.frame[s, 0, 0], state.q_t), dot(plan.frame[s, 0, 1], state.q_t)
        advance += 0.5 * plan.step * ((ax + bx) * frame_x + (ay + by) * frame_y)
        runs_in = plan.step * dot(plan.turn[s, 0], state.q_t)
        runs_out = plan.step * dot(plan.turn[s, 1], state.q_t)
        for side in range(2):  # speeds of the rims at the middle of the step, for the energy they carry
            work.speed[s, side] = dot(work.rows[s, side], state.q_t)
        state.flow[s, 0], state.flow[s, 1] = 0.0, 0.0
        if plan.rim[s, 0] != 0.0:
            state.flow[s, 0] = pass_end(plan, state, work, s, 0, runs_in - plan.rim[s, 0] * turned)
        if plan.rim[s, 1] != 0.0:
            state.flow[s, 1] = pass_end(plan, state, work, s, 1, runs_out - plan.rim[s, 1] * turned)
        for i in range(first, last):
            share, j = (i - first + 0.5) / n, i + s
            passing = (1.0 - share) * state.flow[s, 0] + share * state.flow[s, 1]
            strain = 0.5 * (work.tension[j] + work.tension[j + 1]) / plan.piece[s, at.RIGIDITY]
            state.x[i] += plan.step * state.x_t[i] - advance - (1.0 + strain) * passing
        state.length[s] += state.flow[s, 0] - state.flow[s, 1]


@njit_inner
def watch(plan: TravelPlan, state: TravelState, work: TravelWorkspace) -> int:
    """Extremes of the state, and whether it has left what the step or the pulleys allow."""
    for k in range(state.q.size):
        state.extremes[0, k] = min(state.extremes[0, k], state.q[k])
        state.extremes[1, k] = max(state.extremes[1, k], state.q[k])
    for s in range(plan.rim.shape[0]):
        state.reached[0, s] = min(state.reached[0, s], work.free[s])
        if work.free[s] < plan.shortest[s]:
            state.events[0, 0], state.events[0, 1] = s, work.free[s]
            return at.TOO_SHORT
        there = plan.beyond[s, 1]
        if there < 0:
            continue
        wrap = plan.piece[s, at.WRAP]
        for sign, own in ((1.0, there), (-1.0, s)):
            ax, ay = plan.bearing[own, 0], plan.bearing[own, 1]
            bx, by = work.along[own, 0], work.along[own, 1]
            turned = atan2(ax * by - ay * bx, ax * bx + ay * by)
            wrap += sign * turned * (1.0 if plan.rim[s, 1] > 0.0 else -1.0)
        if wrap < -1e-9:
            state.events[0, 0], state.events[0, 1] = s, wrap
            return at.OFF_THE_PULLEY
        momentum = plan.piece[s, at.DENSITY] * (state.flow[s, 1] / plan.step) ** 2
        one, other = work.pull[s, 1, 0] - momentum, work.pull[there, 0, 0] - momentum
        if wrap > 1e-6 and one > 0.0 and other > 0.0:
            state.reached[1, s] = max(state.reached[1, s], abs(log(one / other)) / wrap)
    return DONE


@njit_inner
def step_travel(plan: TravelPlan, state: TravelState, work: TravelWorkspace, given: Array) -> int:
    """One step; ``given``: torques of the motors [N m], or speeds over the step where they are prescribed."""
    slack = pull_spans(plan, state, work)
    if slack >= 0:
        state.events[0, 0], state.events[0, 1] = slack, 0.0
        return SLACK
    damp_spans(plan, state, work)
    found = watch(plan, state, work)
    if found != DONE:
        return found
    if plan.winds:
        fill_inverse(plan, state.wound, work)
    turn_coordinates(plan, state, work, given)
    kick_cells(plan, state, work)
    for k in range(state.q.size):
        state.q_t[k] = work.new[k]
        state.q[k] += plan.step * work.new[k]
    for s in range(plan.rim.shape[0]):
        work.before[s, 0], work.before[s, 1] = work.along[s, 0], work.along[s, 1]
    lost = lay_spans(plan, state.q, work)
    if lost >= 0:
        state.events[0, 0] = lost
        return at.NO_SPAN
    move_cells(plan, state, work)
    state.counts[0] += 1
    return DONE


@njit_in_place
def integrate_travel(
    plan: TravelPlan,
    state: TravelState,
    work: TravelWorkspace,
    given: Array,
    every: int,
    rows: Array,
) -> int:
    """Take a step per row of ``given``, recording the first of every ``every``."""
    if lay_spans(plan, state.q, work) >= 0:
        return at.NO_SPAN
    fill_inverse(plan, state.wound, work)
    for j in range(given.shape[0]):
        recorded = j % every == 0
        if recorded:
            pull_spans(plan, state, work)
            damp_spans(plan, state, work)
            note_places(plan, state, work, rows[j // every])
        code = step_travel(plan, state, work, given[j])
        if code != DONE:
            return code
        if recorded and not note_speeds(plan, state, work, rows[j // every]):
            return NOT_FINITE
    return DONE
