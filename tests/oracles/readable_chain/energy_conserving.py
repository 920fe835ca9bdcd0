r"""Readable time integration of the energy-conserving scheme.

The energy of the cable is split into the quadratic one of the linear law and the rest :math:`V(x)`, for the
exact law :math:`\tfrac12 EA \int (\lambda^2 - u'^2)\,dx`. A scalar :math:`\psi` stands for
:math:`\sqrt{2(V + C)}`, and every step is one of Stoermer-Verlet in which the nonlinear forces
:math:`F = -\nabla V` are scaled by its mean over the step (L.1)-(L.3):

.. math::
    M\,\frac{\dot x_{j+1/2} - \dot x_{j-1/2}}{\Delta t}
        &= F_{lin}(x_j) + c_j F(x_j) + \dots, \qquad
    c_j = \frac{\psi_{j+1/2} + \psi_{j-1/2}}{2\sqrt{2(V(x_j) + C)}} \\
    E_{j+1/2} - E_{j-1/2} &= -c_j F(x_j)\cdot\frac{x_{j+1} - x_{j-1}}{2} \\
    \psi &= \sqrt{2(E + C)}

Whatever the rest of the step does, damping and friction included,
:math:`\tfrac12 \dot x^T M \dot x + \tfrac12 x_j^T K x_{j+1} + E` changes by the work done on it and no more.
"""

from math import sqrt

import numpy as np

from cabledrive.mechanics.cable_laws import LinearLaw
from cabledrive.simulation.plan import KICK_T, KICK_U, PRETENSION, RIGIDITY, SPACING, copy_state
from oracles.readable_chain.verlet import balance_of, observed, step_reference, twin

# Entries of State.extra: E half a step before the state's time, and C.
STORED, SHIFT = range(2)
MOST_TRIALS = 20


def _linear_part(plan, gradients):
    """Components of the segments under the linear law."""
    linear = LinearLaw(pretension=plan.piece[0, PRETENSION], axial_rigidity=plan.piece[0, RIGIDITY])
    return np.stack(linear.excess_components(*gradients))


def _nonlinear_energy(plan, law, gradients):
    """Elastic energy beyond that of the linear law, V [J]."""
    u_x, v_x, w_x = gradients
    quadratic = 0.5 * (law.stiffness * u_x**2 + law.pretension * (v_x**2 + w_x**2))
    return float(np.sum(plan.segment[SPACING] * (law.energy_density(u_x, v_x, w_x) - quadratic)))


def energy_step_reference(plan, law, state, gradients, torque, forces):
    """One step of (L.1)-(L.3), repeated until force scale and velocities agree."""
    linear = _linear_part(plan, gradients)
    rest = np.stack(law.excess_components(*gradients)) - linear
    energy = _nonlinear_energy(plan, law, gradients)
    while min(energy, state.extra[STORED]) + state.extra[SHIFT] < 0.5 * state.extra[SHIFT]:
        state.extra[SHIFT] *= 2.0  # until the energy stays half of it away from zero
    root = sqrt(2.0 * (energy + state.extra[SHIFT]))
    old = sqrt(2.0 * (state.extra[STORED] + state.extra[SHIFT]))

    def _trial(change):
        attempt = copy_state(state)
        step_reference(plan, law, attempt, linear + (old + 0.5 * change) / root * rest, torque, forces)
        stretch = np.diff(attempt.x_t + state.x_t, axis=1)
        return attempt, 0.5 * plan.step / root * float(np.sum(rest * stretch))

    force = np.diff(rest, axis=1)
    kick = plan.node[[KICK_U, KICK_T, KICK_T], 1:-1]
    change, attempt, result = _settled(_trial, 0.25 * plan.step / root**2 * float(np.sum(kick * force**2)))
    for mine, theirs in zip(state, attempt, strict=True):
        mine[...] = theirs
    state.extra[STORED] += result * (old + 0.5 * change)


def _settled(trial, answer):
    """Change of psi over the step that leads to itself.

    The velocities of the nodes answer linearly to the force scale, which the substitution allows for; what is
    left are shafts and axial damping, whose answer only makes it smaller.
    """
    change, miss = 0.0, np.inf
    for _ in range(MOST_TRIALS):
        attempt, result = trial(change)
        if result == change or abs(result - change) >= miss:
            break
        miss = abs(result - change)
        change += (result - change) / (1.0 + answer)
    return change, attempt, result


def _observe(plan, law, before, after, gradients, torque, row):
    """The record of Stoermer-Verlet, with the balance of this scheme."""
    observed(plan, law, before, after, gradients, torque, row)
    rest = np.stack(law.excess_components(*gradients)) - _linear_part(plan, gradients)
    stretching = np.diff(0.5 * (after.x_t - before.x_t), axis=1)
    stored = 0.5 * (before.extra[STORED] + after.extra[STORED]) - _nonlinear_energy(plan, law, gradients)
    row[balance_of(plan)] += stored - 0.5 * plan.step * float(np.sum(rest * stretching))


integrate_reference = twin(energy_step_reference, _observe)
