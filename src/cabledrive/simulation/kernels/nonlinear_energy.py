"""Compiled energy and components of the cable beyond the linear law, for the energy-conserving scheme."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.kernels.segments import EXACT, LINEAR, transverse_stretch
from cabledrive.simulation.plan import INVERSE_SPACING, KICK_T, KICK_U, SPACING, Plan
from cabledrive.simulation.workspace import Workspace


@njit_in_place
@for_kernels
def take_linear(plan: Plan, x: Array, p: Array, out: Array, sign: float) -> None:
    """Components plus or minus those of the linear law."""
    for axis in range(3):
        stiffness = plan.pretension + (plan.rigidity if axis == 0 else 0.0)
        for i in range(p.shape[1]):
            slope = (x[axis, i + 1] - x[axis, i]) * plan.segment[INVERSE_SPACING, i]
            out[axis, i] = p[axis, i] + sign * stiffness * slope


@njit_in_place
@for_kernels
def answer_of(plan: Plan, rest: Array) -> float:
    """How much the nodes answer to their nonlinear forces, sum of kick times force squared."""
    total = 0.0
    for axis in range(3):
        kick = plan.node[KICK_U if axis == 0 else KICK_T]
        for i in range(1, rest.shape[1]):
            total += kick[i] * (rest[axis, i] - rest[axis, i - 1]) ** 2
    return total


@njit_in_place
@for_kernels
def stretching(rest: Array, x_t: Array) -> float:
    """Power of nonlinear components on the differences of velocities."""
    total = 0.0
    for axis in range(3):
        for i in range(rest.shape[1]):
            total += rest[axis, i] * (x_t[axis, i + 1] - x_t[axis, i])
    return total


@njit_in_place
@for_kernels
def nonlinear_energy(plan: Plan, x: Array) -> float:
    """Elastic energy beyond that of the linear law."""
    total = 0.0
    rigidity = plan.rigidity + (0.0 if plan.law == EXACT else plan.pretension)
    if plan.law == LINEAR:
        return 0.0
    for i in range(x.shape[1] - 1):
        h = plan.segment[INVERSE_SPACING, i]
        u_x = (x[0, i + 1] - x[0, i]) * h
        slopes = transverse_stretch(plan.law, u_x, (x[1, i + 1] - x[1, i]) * h, (x[2, i + 1] - x[2, i]) * h)
        total += plan.segment[SPACING, i] * slopes * (2.0 * u_x + slopes)
    return 0.5 * rigidity * total


@njit_in_place
@for_kernels
def own_balance(plan: Plan, work: Workspace, after: Array, stored: float) -> float:
    """What the balance of this scheme has beyond that of Stoermer-Verlet; ``work.p`` holds the components."""
    x, before = work.before[0], work.before[1]
    take_linear(plan, x, work.p, work.p, -1.0)
    changed = 0.5 * (stretching(work.p, after) - stretching(work.p, before))
    return stored - nonlinear_energy(plan, x) - 0.5 * plan.step * changed
