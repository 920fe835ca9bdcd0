"""Compiled record of one instant: angles, tensions, energies, budget.

Called with the displacements at t_j and the velocities half a step before and after it.
"""

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place, njit_inlined
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
    HOLDING,
    INVERSE_SPACING,
    RADIUS,
    RIM_MASS,
    SPACING,
    WEIGHT_U,
    WEIGHT_W,
    Plan,
)
from cabledrive.simulation.workspace import ENERGY, TENSION, Workspace


@njit_in_place
@for_kernels
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
    stored: Array,
    row: Array,
) -> None:
    """Write one row of the record.

    ``before`` (2, 3, nodes) holds the displacements at t_j and the velocities before the step's kick,
    ``after`` (3, nodes) the velocities after it; ``p`` (3, segments) the components of the segments,
    ``tension`` (segments,) their tension and ``stored`` (segments,) their energy per length. The energy in
    the balance is the mean of those of the two half steps beside t_j::

        H(t_j) + |d|^2 / 2 - step / 2 d . F,  d = (velocity after - velocity before) / 2,  F = -dV/dx,

    which leapfrog keeps to round-off for a linear drive, and to a bounded remainder for the others.
    """
    for column in range(row.size):
        row[column] = 0.0
    energy = 0.0
    for span in range(plan.spans):
        energy += _observe_span(plan, before, after, p, tension, stored, span, row)
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


@njit_inlined
def record(
    plan: Plan, work: Workspace, after: Array, motor: Array, tallies: Array, torque: float, row: Array
) -> None:
    """Write the record of the step before which ``work.before`` was kept, under a law of the kernels."""
    x = work.before[0]
    segment_tensions(
        plan.law, plan.tension_only, plan.pretension, plan.rigidity, x, plan.segment[INVERSE_SPACING], work.p
    )
    strain_energies(plan, x, work.q[TENSION], work.q[ENERGY])
    record_given(plan, work, after, motor, tallies, torque, row)


@njit_in_place
def record_given(
    plan: Plan, work: Workspace, after: Array, motor: Array, tallies: Array, torque: float, row: Array
) -> None:
    """As `record`, with components in ``work.p``, tension and energy per length in rows of ``work.q``."""
    observe(
        plan, work.before, after, work.before_motor, motor, work.before_tallies, tallies,
        torque, work.p, work.q[TENSION], work.q[ENERGY], row,
    )  # fmt: skip


@njit_in_place
def _observe_span(
    plan: Plan, before: Array, after: Array, p: Array, tension: Array, stored: Array, span: int, row: Array
) -> float:
    """Tensions and energies of the cable of one span; returns its part of the balance's correction."""
    first, last = span * plan.segments, (span + 1) * plan.segments
    spacing = plan.segment[SPACING, first:last]
    length, mean, energy = _sums(spacing, tension[first:last], stored[first:last])
    row[MEAN_TENSION + span] = mean / length
    row[LEAST_TENSION + span] = least_of(tension[first:last])
    row[STRAIN + span] = energy
    correction = 0.0
    for axis in range(3):
        kinetic, changed, pull = _motion_sums(
            0.5 * plan.density, before[1, axis, first : last + 1], after[axis, first : last + 1],
            p[axis, first:last], spacing, plan.node[CARRIAGE_MASS, first : last + 1],
        )  # fmt: skip
        row[AXIAL + span if axis == 0 else TRANSVERSE + span] += kinetic
        correction += changed - 0.5 * plan.step * pull
    return correction


@njit_in_place
def _sums(spacing: Array, tension: Array, stored: Array) -> tuple[float, float, float]:
    """Length of a span, integral of its tension, energy stored in it."""
    length, mean, energy = 0.0, 0.0, 0.0
    for i in range(spacing.size):
        length += spacing[i]
        mean += tension[i] * spacing[i]
        energy += stored[i] * spacing[i]
    return length, mean, energy


@njit_in_place
@for_kernels
def strain_energies(plan: Plan, x: Array, tension: Array, stored: Array) -> None:
    """Tension and energy per length of all segments under a law of the kernels."""
    pretension, stiffness = plan.pretension, plan.pretension + plan.rigidity
    inverse_spacing = plan.segment[INVERSE_SPACING]
    for i in range(tension.size):
        u_x = (x[0, i + 1] - x[0, i]) * inverse_spacing[i]
        v_x = (x[1, i + 1] - x[1, i]) * inverse_spacing[i]
        w_x = (x[2, i + 1] - x[2, i]) * inverse_spacing[i]
        slopes = transverse_stretch(plan.law, u_x, v_x, w_x)
        strain = u_x if plan.law == LINEAR else u_x + slopes
        pull = pretension + stiffness * strain
        density = pretension * slopes + 0.5 * stiffness * strain * strain
        if plan.tension_only and pull < 0.0:
            pull = 0.0
            density = -pretension * (0.5 * pretension / stiffness + u_x)
        tension[i] = pull
        stored[i] = density


@njit_in_place
@for_kernels
def least_of(values: Array) -> float:
    """Least of some numbers; four at once, since the compiler keeps minima in order."""
    a = b = c = d = values[0]
    for k in range(values.size // 4):
        a = min(a, values[4 * k])
        b = min(b, values[4 * k + 1])
        c = min(c, values[4 * k + 2])
        d = min(d, values[4 * k + 3])
    for i in range(values.size - values.size % 4, values.size):
        a = min(a, values[i])
    return min(min(a, b), min(c, d))


@njit_in_place
def _motion_sums(
    half_density: float, old: Array, new: Array, p: Array, spacing: Array, carriage: Array
) -> tuple[float, float, float]:
    """Kinetic energies of mean velocity and of half its change in one direction of a span, and what pulls.

    The span has the half cells next to its rims.
    """
    end = spacing.size
    kinetic, changed, pull = 0.0, 0.0, 0.0
    for i in range(1, end):
        half_mass = half_density * 0.5 * (spacing[i - 1] + spacing[i]) + 0.5 * carriage[i]
        change, speed = 0.5 * (new[i] - old[i]), 0.5 * (new[i] + old[i])
        kinetic += half_mass * speed * speed
        changed += half_mass * change * change
        pull += change * (p[i] - p[i - 1])
    start_change, end_change = 0.5 * (new[0] - old[0]), 0.5 * (new[end] - old[end])
    start_half, end_half = 0.5 * half_density * spacing[0], 0.5 * half_density * spacing[end - 1]
    kinetic += start_half * (old[0] + start_change) ** 2 + end_half * (old[end] + end_change) ** 2
    changed += start_half * start_change**2 + end_half * end_change**2
    pull += start_change * p[0] - end_change * p[end - 1]
    return kinetic, changed, pull


@njit_in_place
def _observe_weight(plan: Plan, before: Array, after: Array, row: Array) -> float:
    """Potential energy of the weight; its part of the correction."""
    energy, rate = 0.0, 0.0
    for i in range(before.shape[2] - 1 if plan.closed else before.shape[2]):
        weight_u, weight_w = plan.node[WEIGHT_U, i], plan.node[WEIGHT_W, i]
        energy -= weight_u * before[0, 0, i] + weight_w * before[0, 2, i]
        rate += weight_u * (after[0, i] - before[1, 0, i]) + weight_w * (after[2, i] - before[1, 2, i])
    row[WEIGHT_ENERGY] = energy
    return -0.25 * plan.step * rate


@njit_in_place
def _observe_shafts(
    plan: Plan, before: Array, after: Array, motor_before: Array, motor_after: Array, row: Array
) -> float:
    """Angles, speeds and energies of the shafts, joint and holding spring; their part of the correction."""
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
        held = plan.shaft[HOLDING, k] * place
        row[JOINT_ENERGY] += 0.5 * held * place
        correction += 0.5 * plan.step * held * change
        if k == 0:
            drive_change = change
    if plan.driven == 2:
        twist = before[0, 0, 0] - motor_before[0]
        row[JOINT_ENERGY] += 0.5 * plan.joint_stiffness * twist * twist
        correction += 0.5 * plan.step * plan.joint_stiffness * twist * (drive_change - change)
    else:
        row[ANGLE + 2] = row[ANGLE]
        row[SPEED + 2] = row[SPEED]
    return correction
