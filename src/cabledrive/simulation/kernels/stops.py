"""Compiled motion of the stops, nodes with a mass of their own or a force; tensions beside them and rims."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inlined
from cabledrive.simulation.channels import FORCE_WORK, TRANSVERSE_LOSS
from cabledrive.simulation.kernels.segments import C0, C1, C2, C3, C4, C5, C6, C7
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.plan import DRAG, FALL_U, FALL_W, INVERSE_SPACING, KEEP_T, KICK_T, KICK_U, Plan
from cabledrive.simulation.workspace import AFTER, BEFORE, PLACE


@njit_inlined
def pulls_beside(plan: Plan, x: Array, p: Array) -> None:
    """Components of the segments beside rims and stops, into their places in p."""
    for k in range(plan.beside.size):
        i = plan.beside[k]
        inverse = plan.segment[INVERSE_SPACING, i]
        u_x = (x[0, i + 1] - x[0, i]) * inverse
        v_x = (x[1, i + 1] - x[1, i]) * inverse
        w_x = (x[2, i + 1] - x[2, i]) * inverse
        z = u_x * (2.0 + u_x) + v_x * v_x + w_x * w_x
        series = C0 + z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * (C6 + z * C7))))))
        gain = plan.rigidity * z * series
        across = plan.pretension + gain
        p[0, i] = across * u_x + gain
        p[1, i] = across * v_x
        p[2, i] = across * w_x


@njit_in_place
@for_kernels
def kick_stops(plan: Plan, x: Array, x_t: Array, p: Array, forces: Array, j: int, stop: Array) -> None:
    """Speeds of the stops after step ``j``, from the components beside them; kept until the pass is over."""
    node = plan.node
    for k in range(plan.stop.size):
        i = plan.stop[k]
        for axis in range(3):
            stop[BEFORE, axis, k] = x_t[axis, i]
            stop[PLACE, axis, k] = x[axis, i]
            kick = node[KICK_U, i] if axis == 0 else node[KICK_T, i]
            kept = 1.0 if axis == 0 else node[KEEP_T, i]
            stop[AFTER, axis, k] = kept * x_t[axis, i] + kick * (p[axis, i] - p[axis, i - 1])
            for number in range(plan.force.shape[0]):
                if plan.force[number, 0] == i and plan.force[number, 1] == axis:
                    stop[AFTER, axis, k] += kick * forces[j, number]
        stop[AFTER, 0, k] += node[FALL_U, i]
        stop[AFTER, 2, k] += node[FALL_W, i]


@njit_in_place
@for_kernels
def move_stops(plan: Plan, x: Array, x_t: Array, forces: Array, j: int, stop: Array, tallies: Array) -> None:
    """Write the stops' speeds and places over what the pass left there; work of forces, transverse loss."""
    squares = 0.0
    for k in range(plan.stop.size):
        i = plan.stop[k]
        for axis in range(3):
            speed = stop[AFTER, axis, k]
            x_t[axis, i] = speed
            x[axis, i] = stop[PLACE, axis, k] + plan.step * speed
            twice = stop[BEFORE, axis, k] + speed
            if axis > 0:
                squares += plan.node[DRAG, i] * twice * twice
            for number in range(plan.force.shape[0]):
                if plan.force[number, 0] == i and plan.force[number, 1] == axis:
                    add_to(tallies, int(FORCE_WORK), 0.5 * plan.step * forces[j, number] * twice)
    add_to(tallies, int(TRANSVERSE_LOSS), 0.25 * plan.step * squares)
