r"""Compiled steps of ropes between coordinates: one loop for every law, machine and method.

One step: components of all segments from the displacements, velocities half a step on, displacements a step
on. The methods differ in what kicks the nodes: differences of the components (Stoermer-Verlet), the equations
of motion written out at the nodes (node-centred), or components scaled so that energy is conserved,

.. math:: c_j = \frac{\psi_{j+1/2} + \psi_{j-1/2}}{2\sqrt{2(V(x_j) + C)}}, \qquad
          E_{j+1/2} - E_{j-1/2} = -c_j F(x_j)\cdot\frac{x_{j+1} - x_{j-1}}{2}, \qquad \psi = \sqrt{2(E + C)}

for the energy V beyond the linear one and its forces F, Eqs. (L.1)-(L.3).
"""

from math import sqrt
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inner, njit_strict
from cabledrive.simulation import damped as of
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import AXIAL_LOSS
from cabledrive.simulation.coordinates import advance, gather, place_ends
from cabledrive.simulation.node_motion import finish, kick_nodes, move, turn_and_damp
from cabledrive.simulation.observe import add_to, balance_of, copy_rows, keep_before, keep_extremes, observe
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import (
    add_pulls,
    components,
    end_pulls,
    gradients,
    note_slack,
    strain_directions,
    strains,
    transverse_stretch,
)

MOST_TRIALS, SETTLED = 20, 1e-12


@njit_inner
def step_with_energy(
    plan: Plan, state: State, extra: Array, work: Workspace, torque: Array, forces: Array
) -> None:
    """One step: the nodes answer linearly to the force scale, coordinates and dampers are tried."""
    x, x_t, q, q_t, rest = state.x, state.x_t, state.q, state.q_t, work.rest
    last, free, old, n = x.shape[1] - 1, work.free, work.old, state.q.size
    add_linear(plan, x, work.p, rest, -1.0)
    energy = nonlinear_energy(plan, x)
    while min(energy, extra[at.STORED]) + extra[at.SHIFT] < 0.5 * extra[at.SHIFT]:
        extra[at.SHIFT] *= 2.0
    root, psi = sqrt(2.0 * (energy + extra[at.SHIFT])), sqrt(2.0 * (extra[at.STORED] + extra[at.SHIFT]))
    scale = 0.5 * plan.step / root
    for axis in range(3):
        for i in range(last):
            work.p[axis, i] -= rest[axis, i]
    kick_nodes(plan, x_t, work, forces)
    end_pulls(plan, work.p, work)
    gather(plan, q, torque, work)
    end_pulls(plan, rest, work)
    for i in range(n):
        work.trial[0, i], work.trial[1, i] = work.force[i], 0.0
    add_pulls(plan, work, work.trial[1])
    met, answer, damped = 0.0, 0.0, plan.axial != of.UNDAMPED
    one = np.uintp(1)  # an index that might be negative would keep from taking many nodes at once
    for piece in range(plan.nodes.shape[0]):
        ropes, start = plan.piece[piece, at.ROPES], np.uintp(plan.nodes[piece, 0])
        for axis in range(3):
            kick, own_met, own_answer = plan.node[at.KICK_U if axis == 0 else at.KICK_T], 0.0, 0.0
            pull, slow, speed = rest[axis], old[axis], x_t[axis]
            for number in range(np.uintp(plan.nodes[piece, 1]) - start - one):
                before = start + number
                node = before + one
                force = pull[node] - pull[before] if kick[node] > 0.0 else 0.0
                own_met += force * (slow[node] + speed[node])
                own_answer += kick[node] * force * force
            met += ropes * own_met
            answer += ropes * own_answer
    if damped:
        copy_rows(x_t, free)
    change, result, c = 0.0, 0.0, 1.0
    for trial in range(MOST_TRIALS):
        c = (psi + 0.5 * change) / root
        for i in range(n):
            work.force[i] = work.trial[0, i] + c * work.trial[1, i]
        work.lost[:] = 0.0
        if damped:
            scaled_kick(plan, free, x_t, rest, c)
        turn_and_damp(plan, q_t, x_t, work.lost, work)
        if damped:
            place_ends(plan, q, work.new, x, x_t)
            result = scale * (power(plan, rest, old) + power(plan, rest, x_t))
        else:
            moved = met + c * answer
            for i in range(n):
                moved += work.trial[1, i] * (q_t[i] + work.new[i])
            result = -scale * moved
        if abs(result - change) <= SETTLED * abs(result) or trial == MOST_TRIALS - 1:
            break
        change += (result - change) / (1.0 + 0.5 * scale / root * answer)
    if not damped:
        scaled_kick(plan, x_t, x_t, rest, c)
    if damped:
        add_to(state.tallies, int(AXIAL_LOSS), work.lost[0, int(AXIAL_LOSS)])
    extra[at.STORED] = sum_with_loss(extra, at.STORED_LOST, extra[at.STORED], result * (psi + 0.5 * change))
    # A rim turns far while forces on it are large: what rounding takes there would be work nobody does.
    for i in range(n):
        work.trial[0, i] = sum_with_loss(extra, at.PLACES_LOST + i, q[i], plan.step * work.new[i])


@njit_inner
def scaled_kick(plan: Plan, free: Array, x_t: Array, rest: Array, c: float) -> None:
    """Velocities after the kick of the components beyond the linear law, scaled by ``c``."""
    for axis in range(3):
        kick = plan.node[at.KICK_U if axis == 0 else at.KICK_T]
        for i in range(1, rest.shape[1]):
            x_t[axis, i] = free[axis, i] + c * kick[i] * (rest[axis, i] - rest[axis, i - 1])


@njit_strict
@for_kernels
def sum_with_loss(extra: Array, number: int, value: float, amount: float) -> float:
    """Value plus amount, and what rounding took away last time; keeps what it takes away now."""
    amount -= extra[number]
    total = value + amount
    extra[number] = (total - value) - amount
    return total


@njit_inner
def add_linear(plan: Plan, x: Array, p: Array, out: Array, sign: float) -> None:
    """Components plus or minus those of the linear law."""
    for piece in range(plan.nodes.shape[0]):
        for axis in range(3):
            along = plan.piece[piece, at.RIGIDITY] if axis == 0 else 0.0
            stiffness = sign * (plan.piece[piece, at.PRETENSION] + along)
            start, inverse = np.uintp(plan.nodes[piece, 0]), plan.segment[at.INVERSE_SPACING]
            place, given, made = x[axis], p[axis], out[axis]
            for k in range(np.uintp(plan.nodes[piece, 1]) - start):
                i = start + k
                made[i] = given[i] + stiffness * (place[i + np.uintp(1)] - place[i]) * inverse[i]


@njit_inner
def power(plan: Plan, rest: Array, x_t: Array) -> float:
    """Power of components of all ropes on the differences of velocities."""
    total = 0.0
    for piece in range(plan.nodes.shape[0]):
        own, start = 0.0, np.uintp(plan.nodes[piece, 0])
        for axis in range(3):
            for k in range(np.uintp(plan.nodes[piece, 1]) - start):
                i = start + k
                own += rest[axis, i] * (x_t[axis, i + np.uintp(1)] - x_t[axis, i])
        total += plan.piece[piece, at.ROPES] * own
    return total


@njit_inner
def nonlinear_energy(plan: Plan, x: Array) -> float:
    """Elastic energy beyond that of the linear law."""
    energy = 0.0
    if plan.law == at.LINEAR:
        return 0.0
    for piece in range(plan.nodes.shape[0]):
        total, rigidity = 0.0, plan.piece[piece, at.RIGIDITY]
        rigidity += 0.0 if plan.law == at.EXACT else plan.piece[piece, at.PRETENSION]
        h, inverse = plan.segment[at.SPACING], plan.segment[at.INVERSE_SPACING]
        start = np.uintp(plan.nodes[piece, 0])
        for k in range(np.uintp(plan.nodes[piece, 1]) - start):
            i = start + k
            u_x, v_x, w_x = gradients(x, inverse, i)  # type: ignore[arg-type]  # unsigned
            slopes = transverse_stretch(plan.law, u_x, v_x, w_x)
            total += h[i] * slopes * (2.0 * u_x + slopes)
        energy += 0.5 * plan.piece[piece, at.ROPES] * rigidity * total
    return energy


@njit_inner
def own_balance(plan: Plan, work: Workspace, after: Array, stored: float) -> float:
    """What the balance of this scheme has beyond that of Stoermer-Verlet; ``work.p`` holds the components."""
    x = work.before[0]
    add_linear(plan, x, work.p, work.p, -1.0)
    changed = 0.5 * (power(plan, work.p, after) - power(plan, work.p, work.before[1]))
    return stored - nonlinear_energy(plan, x) - 0.5 * plan.step * changed


@njit_in_place
def integrate(
    law: Any,
    numbers: Array,
    centred: Array | None,
    extra: Array | None,
    given: bool,
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """Take a step per row of ``torque``, recording the first of every ``every`` into the next row; 0: none.

    ``law``, ``numbers``: None, or the formula of a law of one's own and its numbers, whose steps end where a
    segment is or was slack; ``centred``: given for the node-centred scheme, Eqs. (2.32) and (2.35)-(2.38),
    ``extra``: numbers of the energy-conserving one, None of others, which then compile without them;
    ``given``: whether what the law gives for the first step is in ``work`` already.
    Returns DONE, SLACK (before the step at whose start a span is slack) or NOT_FINITE (after its record).
    """
    x, x_t = state.x, state.x_t
    for j in range(torque.shape[0]):
        recording, known = every > 0 and j % every == 0, given and j == 0
        keep_extremes(plan, state)
        if recording:
            keep_before(state, work)
        if not known:
            slack = components(law, numbers, plan, x, work.p)
            if slack > 0 or state.slack.any():
                if law is not None:
                    return at.SLACK
                note_slack(plan, state)
                if plan.stop_when_slack and slack > 0:
                    return at.SLACK
            if plan.axial != of.UNDAMPED:
                strain_directions(plan, x, work.direction)
        stored = 0.0
        if extra is not None:
            stored = 0.5 * extra[at.STORED]
            step_with_energy(plan, state, extra, work, torque[j], forces[j])
            stored += 0.5 * extra[at.STORED]
        else:
            move(plan, centred, state, work, torque[j], forces[j])
        finish(plan, state, work, forces[j])
        advance(plan, state, torque[j], work)
        if extra is not None:  # with what rounding took of the places
            for i in range(state.q.size):
                state.q[i] = work.trial[0, i]
        place_ends(plan, state.q, state.q_t, x, x_t)
        state.counts[at.STEPS] += 1
        if recording:
            row = rows[j // every]
            if not known:
                strains(plan, work.before[0], work.damp[at.TENSION], work.damp[at.ENERGY])
            if extra is not None:
                components(law, numbers, plan, work.before[0], work.p)
            balance = observe(plan, state, work, torque[j], row)
            if extra is not None:
                more = own_balance(plan, work, x_t, stored)
                balance += more
                row[balance_of(plan)] += more
            if fields.shape[0] > 0:
                copy_rows(work.before[0], fields[j // every])
            if not abs(balance) < 1e300:
                return at.NOT_FINITE
    return at.DONE
