"""Compiled steps of a loop or a line: one loop for every law, drive and method.

One step: components of all segments from the displacements, velocities half a step on, displacements a step
on. The methods differ in what kicks the nodes: differences of the components (Stoermer-Verlet), the equations
of motion written out at the nodes (node-centred), or components scaled so that energy is conserved.
"""

from typing import Any

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import (
    BALANCE,
)
from cabledrive.simulation.energy_step import own_balance, step_with_energy
from cabledrive.simulation.node_motion import finish, move
from cabledrive.simulation.observe import copy_rows, keep_before, keep_extremes, observe, tally_shafts
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
    """Take a step per entry of ``torque``, recording the first of every ``every`` into the next row; 0: none.

    ``law``, ``numbers``: None, or the formula of a law of one's own and its numbers, whose steps end where a
    segment is or was slack; ``centred``: room of the node-centred scheme, Eqs. (2.32) and (2.35)-(2.38),
    ``extra``: numbers of the energy-conserving one, None of others, which then compile without them;
    ``given``: whether what the law gives for the first step is in ``work`` already.
    Returns DONE, SLACK (before the step at whose start a span is slack) or NOT_FINITE (after its record).
    """
    x, x_t = state.x, state.x_t
    for j in range(torque.size):
        recording, known = every > 0 and j % every == 0, given and j == 0
        keep_extremes(plan, state)
        if recording:
            keep_before(state, work)
        if not known:
            slack = components(law, numbers, plan, x, work.p)
            if slack > 0 or state.counts[at.UPPER_SLACK] + state.counts[at.LOWER_SLACK] > 0:
                if law is not None:
                    return at.SLACK
                note_slack(plan, state)
                if plan.stop_when_slack and slack > 0:
                    return at.SLACK
            if plan.axial_damping > 0.0:
                strain_directions(plan, x, work.direction)
        push, stored = torque[j] / plan.shaft[at.RADIUS, 0], 0.0
        if extra is not None:
            stored = 0.5 * extra[at.STORED]
            step_with_energy(plan, state, extra, work, push, forces[j])
            stored += 0.5 * extra[at.STORED]
        else:
            move(plan, centred, state, work, push, forces[j])
            finish(plan, state, work, forces[j])
        tally_shafts(plan, push, work.shaft, state.tallies)
        state.counts[at.STEPS] += 1
        if recording:
            row = rows[j // every]
            if not known:
                strains(plan, work.before[0], work.q[at.TENSION], work.q[at.ENERGY])
            if extra is not None:
                components(law, numbers, plan, work.before[0], work.p)
            observe(plan, state, work, torque[j], row)
            if extra is not None:
                row[BALANCE] += own_balance(plan, work, x_t, stored)
            if fields.shape[0] > 0:
                copy_rows(work.before[0], fields[j // every])
            if not abs(row[BALANCE]) < 1e300:
                return at.NOT_FINITE
    return at.DONE
