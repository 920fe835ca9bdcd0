"""Readable record of one instant: angles, tensions, energies, budget."""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.simulation.channels import FORCE_WORK, TALLIES, TORQUE_WORK
from cabledrive.simulation.plan import INVERSE_SPACING, MASS, SPACING, WEIGHT_U, WEIGHT_W, Plan


def balance_of(plan: Plan) -> int:
    """Column of the balance."""
    return 5 * len(plan.nodes) + 3 * len(plan.probe) + 3 + TALLIES


def observe_reference(
    plan: Plan,
    law: CableLaw,
    before: Array,
    after: Array,
    q: Array,
    q_t: Array,
    tallies: Array,
    torque: Array,
    row: Array,
) -> None:
    """Write one row; ``q_t``, ``tallies`` (2, ...): before the kick and after it."""
    x, old, new = before[0], before[1], after
    change, velocity = 0.5 * (new - old), 0.5 * (new + old)
    turned, turning = 0.5 * (q_t[1] - q_t[0]), 0.5 * (q_t[1] + q_t[0])
    spans = len(plan.nodes)
    gradients = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING]
    spacing = plan.segment[SPACING].reshape(spans, -1)
    tension = law.tension(*gradients).reshape(spans, -1)
    stored = law.energy_density(*gradients).reshape(spans, -1)
    inner, mass = [slice(first + 1, last) for first, last in plan.nodes], plan.node[MASS]
    weight = plan.node[[WEIGHT_U, WEIGHT_W]]

    along = [0.5 * mass[own] @ velocity[0, own] ** 2 for own in inner]
    across = [0.5 * mass[own] @ np.sum(velocity[1:, own] ** 2, axis=0) for own in inner]
    probes = [(1.0 - share) * x[:, int(i)] + share * x[:, int(i) + 1] for i, share in plan.probe]
    springs = 0.5 * q @ plan.stiffness @ q - plan.rest @ q
    energies = [-np.sum(weight * x[[0, 2]]), 0.5 * turning @ plan.mass @ turning, springs]
    done = 0.5 * (tallies[0, 0] + tallies[1, 0])
    works = done[TORQUE_WORK] + done[FORCE_WORK]

    excess = np.stack(law.excess_components(*gradients))
    moved = change.copy()
    for first, last in plan.nodes:
        moved[1:, [first, last]] = 0.0
    inertia = 0.5 * np.sum(mass * np.sum(change**2, axis=0)) + 0.5 * turned @ plan.mass @ turned
    pull = -np.sum(excess * np.diff(moved, axis=1)) + np.sum(weight * change[[0, 2]])
    pull += (plan.rest - plan.stiffness @ q) @ turned
    strain = np.sum(stored * spacing, axis=1)
    kept = np.sum(along) + np.sum(across) + np.sum(strain) + np.sum(energies)
    balance = kept + inertia - 0.5 * plan.step * pull + np.sum(done) - 2.0 * works
    mean = np.sum(tension * spacing, axis=1) / np.sum(spacing, axis=1)
    parts = (mean, np.min(tension, axis=1), along, across, strain, *probes, energies, done, [balance])
    row[:] = np.concatenate([*parts, q, turning, torque])
