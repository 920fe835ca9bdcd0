"""Steps under a law that is handed in: a formula compiled apart from the kernel and called by address."""

from typing import Any

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit_in_place
from cabledrive.simulation.kernels.steps import keep_extremes, shaft_forces, tally_shafts
from cabledrive.simulation.kernels.verlet import move_each
from cabledrive.simulation.plan import INVERSE_SPACING, RADIUS, Plan
from cabledrive.simulation.state import LOWER_SLACK, STEPS, UPPER_SLACK, State
from cabledrive.simulation.workspace import Workspace


@njit_in_place
def components_under(law: Any, numbers: Array, x: Array, inverse_spacing: Array, p: Array) -> int:
    """Components above the pretension of all segments by a law; the number of slack ones."""
    return law(numbers, x, inverse_spacing, p)


@njit_in_place
def steps_under(
    law: Any, numbers: Array, plan: Plan, state: State, work: Workspace, torque: Array, forces: Array
) -> int:
    """Take a step per entry of ``torque``, up to one at whose start a segment is or was slack.

    ``law(numbers, x, 1 / spacing, p)`` writes the components above the pretension of all segments into ``p``
    and returns how many are slack. Returns the number of steps taken.
    """
    x, x_t, motor, tallies = state.x, state.x_t, state.motor, state.tallies
    inverse_spacing, radius = plan.segment[INVERSE_SPACING], plan.shaft[RADIUS, 0]
    for j in range(torque.size):
        slack = law(numbers, x, inverse_spacing, work.p)
        if slack > 0 or state.counts[UPPER_SLACK] + state.counts[LOWER_SLACK] > 0:
            return j
        keep_extremes(plan.segments, plan.spans, plan.probe, x, motor, state.extremes)
        push = torque[j] / radius
        shaft_forces(
            plan.closed, plan.segments, plan.joint_stiffness, plan.shaft, plan.node, x, x_t, motor, work.p,
            plan.driven, push, work.shaft,
        )  # fmt: skip
        move_each(plan, x, x_t, motor, tallies, forces[j], work)
        tally_shafts(plan.step, plan.joint_damping, plan.shaft, plan.driven, push, work.shaft, tallies)
        state.counts[STEPS] += 1
    return int(torque.size)
