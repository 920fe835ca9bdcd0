"""Readable record of one instant: angles, tensions, energies, budget."""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.simulation.channels import (
    ANGLE,
    AXIAL,
    BALANCE,
    COLUMN,
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

ENERGIES = slice(AXIAL, WEIGHT_ENERGY + 1)


def observe_reference(
    plan: Plan,
    law: CableLaw,
    before: Array,
    after: Array,
    motor: Array,
    tallies: Array,
    torque: float,
    row: Array,
) -> None:
    """Write one row of the record; ``motor``, ``tallies`` (2, ...): before the kick and after it."""
    x, old, new = before[0], before[1], after
    change, velocity = 0.5 * (new - old), 0.5 * (new + old)
    rims = [0, plan.segments]
    gradients = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING]
    spacing = plan.segment[SPACING].reshape(plan.spans, -1)
    tension = law.tension(*gradients).reshape(plan.spans, -1)
    stored = law.energy_density(*gradients).reshape(plan.spans, -1)
    cells = _cell_masses(plan)
    last = -1 if plan.closed else None
    here = slice(0, plan.spans)

    row[:] = 0.0
    row[ANGLE : ANGLE + 3] = np.array([*x[0, rims], motor[0, 0]]) / plan.shaft[RADIUS]
    shaft_change = np.array([*change[0, rims], 0.5 * (motor[1, 1] - motor[0, 1])])
    shaft_speed = np.array([*velocity[0, rims], 0.5 * (motor[1, 1] + motor[0, 1])])
    row[SPEED : SPEED + 3] = shaft_speed / plan.shaft[RADIUS]
    row[TORQUE] = torque
    row[MEAN_TENSION : MEAN_TENSION + 2][here] = np.sum(tension * spacing, axis=1) / np.sum(spacing, axis=1)
    row[LEAST_TENSION : LEAST_TENSION + 2][here] = np.min(tension, axis=1)
    row[AXIAL : AXIAL + 2][here] = np.sum(0.5 * cells * velocity[0] ** 2, axis=1)
    row[TRANSVERSE : TRANSVERSE + 2][here] = np.sum(
        0.5 * cells * (velocity[1] ** 2 + velocity[2] ** 2), axis=1
    )
    row[STRAIN : STRAIN + 2][here] = np.sum(stored * spacing, axis=1)
    row[SHAFT_ENERGY : SHAFT_ENERGY + 3] = 0.5 * plan.shaft[RIM_MASS] * shaft_speed**2
    twist = x[0, 0] - motor[0, 0] if plan.driven == 2 else 0.0
    places = np.array([*x[0, rims], motor[0, 0]])
    held = plan.shaft[HOLDING] * places
    row[JOINT_ENERGY] = 0.5 * plan.joint_stiffness * twist**2 + 0.5 * held @ places
    weight = plan.node[[WEIGHT_U, WEIGHT_W]]
    row[WEIGHT_ENERGY] = -np.sum((weight * x[[0, 2]])[:, :last])
    if plan.driven != 2:
        row[COLUMN["motor_angle"]], row[COLUMN["motor_speed"]] = row[ANGLE], row[SPEED]

    excess = np.stack(law.excess_components(*gradients))
    inertia = 0.5 * np.sum(cells * np.sum(change**2, axis=0)) + 0.5 * plan.shaft[RIM_MASS] @ shaft_change**2
    pull = -np.sum(excess * np.diff(change, axis=1)) + np.sum((weight * change[[0, 2]])[:, :last])
    pull -= plan.joint_stiffness * twist * (shaft_change[0] - shaft_change[2]) + held @ shaft_change
    row[WORK : WORK + TALLIES] = 0.5 * (tallies[0, 0] + tallies[1, 0])
    works = row[WORK + TORQUE_WORK] + row[WORK + FORCE_WORK]
    losses = np.sum(row[WORK : WORK + TALLIES]) - works
    row[BALANCE] = np.sum(row[ENERGIES]) + inertia - 0.5 * plan.step * pull + losses - works
    for number, (segment, share) in enumerate(plan.probe):
        i = int(segment)
        row[WIDTH + 3 * number : WIDTH + 3 * number + 3] = (1.0 - share) * x[:, i] + share * x[:, i + 1]


def _cell_masses(plan: Plan) -> Array:
    """Mass of the cable and the carriages of each span at each node, shape (spans, nodes)."""
    mass = np.zeros((plan.spans, plan.node.shape[1]))
    for span in range(plan.spans):
        first, last = span * plan.segments, (span + 1) * plan.segments
        half = 0.5 * plan.density * plan.segment[SPACING, first:last]
        mass[span, first:last] += half + plan.node[CARRIAGE_MASS, first:last]
        mass[span, first + 1 : last + 1] += half
    return mass
