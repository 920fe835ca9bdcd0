"""Compiled steps of ropes between coordinates: one loop for every law, machine and method.

One step: components of all segments from the displacements, velocities half a step on, displacements a step
on. The methods differ in what kicks the nodes: differences of the components (Stoermer-Verlet), the equations
of motion written out at the nodes (node-centred), or components scaled so that energy is conserved.
"""

from typing import Any

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.simulation import plan as at
from cabledrive.simulation.coordinates import advance, place_ends
from cabledrive.simulation.energy_step import own_balance, place_compensated, step_with_energy
from cabledrive.simulation.node_motion import finish, move
from cabledrive.simulation.observe import balance_of, copy_rows, keep_before, keep_extremes, observe
from cabledrive.simulation.plan import Plan, State, Workspace
from cabledrive.simulation.segment_laws import components, note_slack, strain_directions, strains


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
    segment is or was slack; ``centred``: room of the node-centred scheme, Eqs. (2.32) and (2.35)-(2.38),
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
            if plan.axial == at.TRUE_DIRECTIONS:
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
        if extra is not None:
            place_compensated(state, work)
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
