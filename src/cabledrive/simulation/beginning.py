r"""The half step before the start, from displacements and velocities at t = 0.

:math:`\dot x_{-1/2} = \dot x_0 - \tfrac12 \Delta t\,\ddot x_0`, so that the first whole step comes out of the
same formula as all others; Eq. (2.39) with the term the print drops.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.simulation.plan import (
    COMPLIANCE,
    COULOMB,
    FALL_U,
    FALL_W,
    HOLDING,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    RADIUS,
    SMOOTH,
    TURNS,
    WEIGHT_U,
    Plan,
)


def half_step_before(
    plan: Plan,
    x: Array,
    x_t: Array,
    motor: tuple[float, float],
    torque: float,
    forces: Array,
    law: CableLaw,
) -> tuple[Array, float]:
    """Velocities half a step before the start, Eq. (2.39).

    ``x``, ``x_t``, shape (3, nodes): displacements [m] and velocities [m/s] at t = 0; ``motor``: displacement
    [m] and velocity [m/s] of the motor at the rim; ``torque``: torque at t = 0 [N m]; ``forces``: forces at t
    = 0 [N]; ``law``: cable law.
    Returns ``velocities``, shape (3, nodes): velocities of the nodes [m/s]; ``motor``: velocity of the motor
    at the rim [m/s].
    """
    gradients = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING]
    pull = np.stack(law.excess_components(*gradients))
    if plan.axial_damping > 0.0:
        direction = np.stack(law.strain_gradient(*gradients))
        pull = pull + direction * np.sum(direction * np.diff(x_t, axis=1), axis=0) / plan.segment[COMPLIANCE]
    gain = _gains_at_once(plan, x_t, pull, forces)
    rims = [0, plan.segments]
    old = np.array([*x_t[0, rims], motor[1]])
    speeds = old - 0.5 * _shaft_gains(plan, x, motor[0], pull[0], old, torque)
    before = x_t - 0.5 * gain
    before[0, rims] = speeds[:2]
    if plan.closed:
        before[:, -1] = before[:, 0]
    return before, float(speeds[2])


def _gains_at_once(plan: Plan, x_t: Array, pull: Array, forces: Array) -> Array:
    """Velocity the nodes between the rims would gain over a step at their present acceleration."""
    gain = np.zeros_like(x_t)
    inner = slice(1, -1)
    damped = (1.0 - plan.node[KEEP_T]) / (1.0 + plan.node[KEEP_T])
    force = np.diff(pull, axis=1)
    gain[0, inner] = plan.node[KICK_U, inner] * force[0] + plan.node[FALL_U, inner]
    gain[1:, inner] = plan.node[KICK_T, inner] * force[1:]
    gain[2, inner] += plan.node[FALL_W, inner]
    for (node, axis), pushed in zip(plan.force, forces, strict=True):
        gain[axis, node] += plan.node[KICK_U if axis == 0 else KICK_T, node] * pushed
    gain[1:] = gain[1:] * (1.0 + damped) - 2.0 * damped * x_t[1:]
    return gain


def _shaft_gains(plan: Plan, x: Array, motor: float, pull: Array, old: Array, torque: float) -> Array:
    """Velocity the shafts would gain over a step; a shaft at rest stays there if its friction can hold it."""
    n = plan.segments
    twisted = plan.joint_stiffness * (x[0, 0] - motor)
    force = np.array([pull[0] - twisted, -pull[n - 1], twisted])
    force -= plan.shaft[HOLDING] * np.array([x[0, 0], x[0, n], motor])
    force[:2] += plan.node[WEIGHT_U, [0, n]]
    if plan.closed:
        force[:2] += -pull[-1], pull[n]
    force[plan.driven] += torque / plan.shaft[RADIUS, 0]
    new_side, old_side = plan.shaft_matrices
    force -= (new_side - old_side) @ old  # all viscous damping
    coulomb = plan.shaft[COULOMB]
    smooth = np.where(plan.shaft[SMOOTH] > 0.0, plan.shaft[SMOOTH], 1.0)
    resting = np.where(old == 0.0, np.clip(force, -coulomb, coulomb), coulomb * np.sign(old))
    friction = np.where(plan.shaft[SMOOTH] > 0.0, coulomb * np.tanh(old / smooth), resting)
    mass_over_step = 0.5 * np.diag(new_side + old_side)
    return np.where(
        plan.shaft[TURNS] > 0.0, (force - friction) / np.where(mass_over_step > 0.0, mass_over_step, 1.0), 0.0
    )
