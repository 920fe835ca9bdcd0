"""Compiled record of one instant: angles, tensions, energies, budget.

Called with the displacements at t_j and the velocities half a step before and after it. Twin:
`cabledrive.simulation.readable.observe`.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit
from cabledrive.simulation.channels import (
    ANGLE,
    AXIAL,
    BALANCE,
    FORCE_WORK,
    JOINT_ENERGY,
    LEAST_TENSION,
    MEAN_TENSION,
    SHAFT_ENERGY,
    SPEED,
    STRAIN,
    TALLIES,
    TORQUE,
    TORQUE_WORK,
    TRANSVERSE,
    WEIGHT_ENERGY,
    WIDTH,
    WORK,
)
from cabledrive.simulation.kernels.segments import LINEAR, segment_tensions, transverse_stretch
from cabledrive.simulation.plan import (
    CARRIAGE_MASS,
    INVERSE_SPACING,
    RADIUS,
    RIM_MASS,
    SPACING,
    WEIGHT_U,
    WEIGHT_W,
    Plan,
)


@njit
def observe(
    plan: Plan,
    before: Array,
    after: Array,
    motor_before: Array,
    motor_after: Array,
    tallies_before: Array,
    tallies_after: Array,
    torque: float,
    p: Array,
    tension: Array,
    row: Array,
) -> None:
    """Write one row of the record.

    ``before`` (2, 3, nodes) holds the displacements at t_j and the velocities before the step's kick,
    ``after`` (3, nodes) the velocities after it; ``p`` (3, segments) and ``tension`` (segments,) are work
    space. The energy in the balance is the mean of those of the two half steps beside t_j,

        H(t_j) + |d|^2 / 2 - step / 2 d . F,  d = (velocity after - velocity before) / 2,  F = -dV/dx,

    which leapfrog keeps to round-off for a linear drive, and to a bounded remainder for the others.
    """
    for column in range(row.size):
        row[column] = 0.0
    segment_tensions(
        plan.law, plan.tension_only, plan.pretension, plan.rigidity,
        before[0], plan.segment[INVERSE_SPACING], p,
    )  # fmt: skip
    energy = 0.0
    for span in range(plan.spans):
        energy += _observe_span(plan, before, after, p, tension, span, row)
    energy += _observe_weight(plan, before, after, row)
    energy += _observe_shafts(plan, before, after, motor_before, motor_after, row)
    row[TORQUE] = torque
    for column in range(AXIAL, WEIGHT_ENERGY + 1):
        energy += row[column]
    for k in range(TALLIES):
        row[WORK + k] = 0.5 * (tallies_before[0, k] + tallies_after[0, k])
        energy += -row[WORK + k] if k in (TORQUE_WORK, FORCE_WORK) else row[WORK + k]
    row[BALANCE] = energy
    for probe in range(plan.probe.shape[0]):
        i = int(plan.probe[probe, 0])
        share = plan.probe[probe, 1]
        for axis in range(3):
            ends = before[0, axis, i], before[0, axis, i + 1]
            row[WIDTH + 3 * probe + axis] = (1.0 - share) * ends[0] + share * ends[1]


@njit
def _observe_span(
    plan: Plan, before: Array, after: Array, p: Array, tension: Array, span: int, row: Array
) -> float:
    """Tensions and energies of the cable of one span; returns its part of the balance's correction."""
    first, last = span * plan.segments, (span + 1) * plan.segments
    spacing, inverse_spacing = plan.segment[SPACING], plan.segment[INVERSE_SPACING]
    length, mean, stored = _strain_sums(plan, before[0], spacing, inverse_spacing, tension, first, last)
    least = tension[first]
    for i in range(first, last):
        least = min(least, tension[i])
    row[MEAN_TENSION + span] = mean / length
    row[LEAST_TENSION + span] = least
    row[STRAIN + span] = stored
    correction = 0.0
    for axis in range(3):
        kinetic, part = _motion_sums(
            plan.density, plan.step, before[1, axis], after[axis], p[axis],
            spacing, plan.node[CARRIAGE_MASS], first, last,
        )  # fmt: skip
        row[AXIAL + span if axis == 0 else TRANSVERSE + span] += kinetic
        correction += part
    return correction


@njit
def _strain_sums(
    plan: Plan, x: Array, spacing: Array, inverse_spacing: Array, tension: Array, first: int, last: int
) -> tuple[float, float, float]:
    """Length of a span, integral of its tension, energy stored in it; writes the tensions themselves."""
    stiffness = plan.rigidity + plan.pretension
    slack_energy = -0.5 * plan.pretension * plan.pretension / stiffness
    length, mean, stored = 0.0, 0.0, 0.0
    for i in range(first, last):
        u_x = (x[0, i + 1] - x[0, i]) * inverse_spacing[i]
        v_x = (x[1, i + 1] - x[1, i]) * inverse_spacing[i]
        w_x = (x[2, i + 1] - x[2, i]) * inverse_spacing[i]
        slopes = transverse_stretch(plan.law, u_x, v_x, w_x)
        strain = u_x if plan.law == LINEAR else u_x + slopes
        pull = plan.pretension + stiffness * strain
        density = plan.pretension * slopes + 0.5 * stiffness * strain * strain
        if plan.tension_only and pull < 0.0:
            pull = 0.0
            density = slack_energy - plan.pretension * u_x
        tension[i] = pull
        length += spacing[i]
        mean += pull * spacing[i]
        stored += density * spacing[i]
    return length, mean, stored


@njit
def _motion_sums(
    density: float,
    step: float,
    old: Array,
    new: Array,
    p: Array,
    spacing: Array,
    carriage: Array,
    first: int,
    last: int,
) -> tuple[float, float]:
    """Kinetic energy of one direction in a span, and its part of the correction.

    The half cells at both ends of a segment are counted with it.
    """
    cells, carried, cell_changes, carried_changes, pull = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(first, last):
        start, end = 0.5 * (new[i] - old[i]), 0.5 * (new[i + 1] - old[i + 1])
        start_speed, end_speed = old[i] + start, old[i + 1] + end
        cells += spacing[i] * (start_speed * start_speed + end_speed * end_speed)
        carried += carriage[i] * start_speed * start_speed
        cell_changes += spacing[i] * (start * start + end * end)
        carried_changes += carriage[i] * start * start
        pull += p[i] * (start - end)  # a segment pulls its ends together
    kinetic = 0.25 * density * cells + 0.5 * carried
    return kinetic, 0.25 * density * cell_changes + 0.5 * carried_changes - 0.5 * step * pull


@njit
def _observe_weight(plan: Plan, before: Array, after: Array, row: Array) -> float:
    """Potential energy of the weight; its part of the correction."""
    energy, rate = 0.0, 0.0
    for i in range(before.shape[2] - 1 if plan.closed else before.shape[2]):
        weight_u, weight_w = plan.node[WEIGHT_U, i], plan.node[WEIGHT_W, i]
        energy -= weight_u * before[0, 0, i] + weight_w * before[0, 2, i]
        rate += weight_u * (after[0, i] - before[1, 0, i]) + weight_w * (after[2, i] - before[1, 2, i])
    row[WEIGHT_ENERGY] = energy
    return -0.25 * plan.step * rate


@njit
def _observe_shafts(
    plan: Plan, before: Array, after: Array, motor_before: Array, motor_after: Array, row: Array
) -> float:
    """Angles, speeds and energies of the shafts and the joint; their part of the correction."""
    correction = 0.0
    drive_change = 0.0
    change = 0.0
    for k in range(3):
        node = 0 if k == 0 else plan.segments
        place = before[0, 0, node] if k < 2 else motor_before[0]
        old = before[1, 0, node] if k < 2 else motor_before[1]
        new = after[0, node] if k < 2 else motor_after[1]
        change = 0.5 * (new - old)
        speed = old + change
        half = 0.5 * plan.shaft[RIM_MASS, k]
        row[ANGLE + k] = place / plan.shaft[RADIUS, k]
        row[SPEED + k] = speed / plan.shaft[RADIUS, k]
        row[SHAFT_ENERGY + k] = half * speed * speed
        correction += half * change * change
        if k == 0:
            drive_change = change
    if plan.driven == 2:
        twist = before[0, 0, 0] - motor_before[0]
        row[JOINT_ENERGY] = 0.5 * plan.joint_stiffness * twist * twist
        correction += 0.5 * plan.step * plan.joint_stiffness * twist * (drive_change - change)
    else:
        row[ANGLE + 2] = row[ANGLE]
        row[SPEED + 2] = row[SPEED]
    return correction
