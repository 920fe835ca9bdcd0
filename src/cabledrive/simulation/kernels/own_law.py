"""Steps under a law that is handed in: a formula compiled apart from the kernel and called by address."""

from typing import Any

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.simulation.kernels.steps import keep_before, keep_extremes, shaft_forces, tally_shafts
from cabledrive.simulation.kernels.verlet import move_each
from cabledrive.simulation.plan import INVERSE_SPACING, RADIUS, Plan
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import Workspace


@njit_in_place
def components_under(law: Any, numbers: Array, x: Array, inverse_spacing: Array, p: Array) -> int:
    """Components above the pretension of all segments by a law; the number of slack ones."""
    return law(numbers, x, inverse_spacing, p)


@njit_in_place
def step_given(plan: Plan, state: State, work: Workspace, torque: float, forces: Array) -> None:
    """One step under the components in ``work.p``, damped along ``work.direction``."""
    push = torque / plan.shaft[RADIUS, 0]
    shaft_forces(
        plan.closed, plan.segments, plan.joint_stiffness, plan.shaft, plan.node, state.x, state.x_t,
        state.motor, work.p, plan.driven, push, work.shaft,
    )  # fmt: skip
    move_each(plan, state.x, state.x_t, state.motor, state.tallies, forces, work)
    tally_shafts(plan.step, plan.joint_damping, plan.shaft, plan.driven, push, work.shaft, state.tallies)
    state.counts[STEPS] += 1


@njit_in_place
def keep_instant(plan: Plan, state: State, work: Workspace) -> None:
    """Extremes, and what a record needs from before the kick."""
    x, x_t, motor, tallies = state.x, state.x_t, state.motor, state.tallies
    keep_extremes(plan.segments, plan.spans, plan.probe, x, motor, state.extremes)
    keep_before(x, x_t, motor, tallies, work.before, work.before_motor, work.before_tallies)


@njit_in_place
def steps_under(
    law: Any, numbers: Array, plan: Plan, state: State, work: Workspace, torque: Array, forces: Array
) -> int:
    """Take a step per entry of ``torque``, up to one at whose start a segment is or was slack.

    ``law(numbers, x, 1 / spacing, p)`` writes the components above the pretension of all segments into ``p``
    and returns how many are slack. Returns the number of steps taken.
    """
    for j in range(torque.size):
        slack = law(numbers, state.x, plan.segment[INVERSE_SPACING], work.p)
        if slack > 0 or state.counts[UPPER_SLACK] + state.counts[LOWER_SLACK] > 0:
            return j
        keep_extremes(plan.segments, plan.spans, plan.probe, state.x, state.motor, state.extremes)
        step_given(plan, state, work, torque[j], forces[j])
    return int(torque.size)
