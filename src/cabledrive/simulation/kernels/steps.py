"""Compiled parts of a step that every chain method shares: shafts, slack, extremes, tallies."""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inlined
from cabledrive.simulation.channels import COULOMB_LOSS, JOINT_LOSS, TALLIES, TORQUE_WORK, VISCOUS_LOSS
from cabledrive.simulation.kernels.segments import segment_strain
from cabledrive.simulation.kernels.shafts import SHAFTS, add_to, solve_shafts
from cabledrive.simulation.plan import (
    COULOMB,
    HOLDING,
    INVERSE_SPACING,
    TURNS,
    VISCOUS,
    WEIGHT_U,
    Plan,
)
from cabledrive.simulation.runs import Integers
from cabledrive.simulation.state import EVENTS, MOST_EVENTS, STEPS, UPPER_SLACK
from cabledrive.simulation.workspace import FORCE, FRICTION, NEW, OLD, RIGHT


@njit_inlined
def keep_extremes(segments: int, spans: int, probe: Array, x: Array, motor: Array, extremes: Array) -> None:
    """Least and largest place of each shaft's rim, largest size of v and w at each midpoint, every step."""
    for k in range(3):
        place = x[0, 0] if k == 0 else x[0, segments] if k == 1 else motor[0]
        extremes[2 * k] = min(extremes[2 * k], place)
        extremes[2 * k + 1] = max(extremes[2 * k + 1], place)
    for span in range(spans):
        i = int(probe[span, 0])
        share = probe[span, 1]
        for axis in range(1, 3):
            size = abs((1.0 - share) * x[axis, i] + share * x[axis, i + 1])
            extremes[5 + 2 * span + axis] = max(extremes[5 + 2 * span + axis], size)


@njit_in_place
@for_kernels
def copy_rows(source: Array, target: Array) -> None:
    """Copy an array of rows into another of the same shape."""
    for row in range(source.shape[0]):
        for i in range(source.shape[1]):
            target[row, i] = source[row, i]


@njit_inlined
def keep_before(
    x: Array,
    x_t: Array,
    motor: Array,
    tallies: Array,
    before: Array,
    before_motor: Array,
    before_tallies: Array,
) -> None:
    """Keep what a record needs from before the kick."""
    for axis in range(3):
        for i in range(x.shape[1]):
            before[0, axis, i] = x[axis, i]
            before[1, axis, i] = x_t[axis, i]
    for i in range(2):
        before_motor[i] = motor[i]
        for k in range(TALLIES):
            before_tallies[i, k] = tallies[i, k]


@njit_in_place
@for_kernels
def note_slack(plan: Plan, x: Array, events: Array, counts: Integers) -> None:
    """Note where and when a span goes slack that was taut at the step before."""
    for span in range(plan.spans):
        least = 0.0
        place = -1
        for i in range(span * plan.segments, (span + 1) * plan.segments):
            above = segment_strain(plan.law, x, plan.segment[INVERSE_SPACING], i) - plan.slack_strain
            if above < least:
                least = above
                place = i - span * plan.segments
        if place >= 0 and counts[UPPER_SLACK + span] == 0:
            if counts[EVENTS] < MOST_EVENTS:
                event = events[counts[EVENTS]]
                event[0] = counts[STEPS]
                event[1] = span
                event[2] = place
                event[3] = (plan.rigidity + plan.pretension) * least
            counts[EVENTS] += 1
        counts[UPPER_SLACK + span] = 1 if place >= 0 else 0


@njit_inlined
def shaft_forces(
    closed: bool,
    segments: int,
    joint_stiffness: float,
    table: Array,
    node: Array,
    x: Array,
    x_t: Array,
    motor: Array,
    p: Array,
    driven: int,
    rim_torque: float,
    shaft: Array,
) -> None:
    """Speeds of the shafts before the step, and the forces on them at its time.

    ``table`` holds the shafts' numbers, see `Plan`.
    """
    shaft[OLD, 0] = x_t[0, 0]
    shaft[OLD, 1] = x_t[0, segments]
    shaft[OLD, 2] = motor[1]
    twisted = joint_stiffness * (x[0, 0] - motor[0])
    shaft[FORCE, 0] = p[0, 0] + node[WEIGHT_U, 0] - twisted - table[HOLDING, 0] * x[0, 0]
    shaft[FORCE, 1] = node[WEIGHT_U, segments] - p[0, segments - 1]
    shaft[FORCE, 2] = twisted - table[HOLDING, 2] * motor[0]
    if closed:
        shaft[FORCE, 0] -= p[0, p.shape[1] - 1]
        shaft[FORCE, 1] += p[0, segments]
    shaft[FORCE, driven] += rim_torque


@njit_inlined
def speed_shafts(matrix: Array, back: Array, table: Array, shaft: Array) -> None:
    """New speeds of the shafts from the forces."""
    for i in range(SHAFTS):
        shaft[RIGHT, i] = shaft[FORCE, i] + back[i, i] * shaft[OLD, i]
    shaft[RIGHT, 0] += back[0, 2] * shaft[OLD, 2]  # the joint's damping
    shaft[RIGHT, 2] += back[2, 0] * shaft[OLD, 0]
    solve_shafts(matrix, table, shaft)


@njit_inlined
def turn_shafts(
    step: float,
    closed: bool,
    segments: int,
    matrix: Array,
    back: Array,
    table: Array,
    motor: Array,
    x_t: Array,
    shaft: Array,
) -> None:
    """New speeds of the shafts, and of the rim nodes, from the forces; the motor moves on at once."""
    speed_shafts(matrix, back, table, shaft)
    move_rims(step, closed, segments, motor, x_t, shaft)


@njit_inlined
def move_rims(step: float, closed: bool, segments: int, motor: Array, x_t: Array, shaft: Array) -> None:
    """New speeds of the shafts to the rim nodes and the motor, which moves on at once."""
    motor[1] = shaft[NEW, 2]
    motor[0] += step * shaft[NEW, 2]
    x_t[0, 0] = shaft[NEW, 0]
    x_t[0, segments] = shaft[NEW, 1]
    if closed:
        x_t[0, x_t.shape[1] - 1] = shaft[NEW, 0]


@njit_inlined
def turn_freely(matrix: Array, table: Array, shaft: Array) -> tuple[float, float, float]:
    """New speed per force of each shaft that neither rubs nor twists a joint; negative if one does.

    Sets the friction to zero, for good if none is negative.
    """
    coupled = matrix[0, 1] != 0.0 or matrix[0, 2] != 0.0 or matrix[1, 2] != 0.0
    rubbing = False
    for i in range(SHAFTS):
        shaft[FRICTION, i] = 0.0
        rubbing = rubbing or table[COULOMB, i] > 0.0
    if coupled or rubbing:
        return -1.0, -1.0, -1.0
    drive = 1.0 / matrix[0, 0] if table[TURNS, 0] > 0.0 else 0.0
    load = 1.0 / matrix[1, 1] if table[TURNS, 1] > 0.0 else 0.0
    motor = 1.0 / matrix[2, 2] if table[TURNS, 2] > 0.0 else 0.0
    return drive, load, motor


@njit_inlined
def tally_shafts(
    step: float,
    joint_damping: float,
    table: Array,
    driven: int,
    rim_torque: float,
    shaft: Array,
    tallies: Array,
) -> None:
    """Work of the torque, and what friction and joint damping take over the step."""
    viscous = 0.0
    coulomb = 0.0
    for i in range(SHAFTS):
        shaft[RIGHT, i] = 0.5 * (shaft[OLD, i] + shaft[NEW, i])
        viscous += table[VISCOUS, i] * shaft[RIGHT, i] ** 2
        coulomb += shaft[FRICTION, i] * shaft[RIGHT, i]
    twist_rate = shaft[RIGHT, 0] - shaft[RIGHT, 2]
    add_to(tallies, int(TORQUE_WORK), step * rim_torque * shaft[RIGHT, driven])
    if viscous > 0.0:
        add_to(tallies, int(VISCOUS_LOSS), step * viscous)
    if coulomb != 0.0:
        add_to(tallies, int(COULOMB_LOSS), step * coulomb)
    if joint_damping > 0.0:
        add_to(tallies, int(JOINT_LOSS), step * joint_damping * twist_rate * twist_rate)
