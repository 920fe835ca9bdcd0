r"""Readable time integration of the dissertation's node-centred scheme, Eqs. (2.32)-(2.38), corrected.

Corrected: :math:`\Delta x = L_e/n` in (2.31), second differences over :math:`\Delta x^2` in (2.34), gravity
with the signs of (2.26)-(2.27), and the rims. There (2.37) and (2.38) leave open what u' is at a boundary
node: here a pulley carries the half cells of cable on both sides, and takes the tension at their far ends,
half a segment away, which is of second order and the same as a ghost node.
"""

import numpy as np
from reproduction.expanded_equations import accelerations

from cabledrive.simulation.plan import FALL_U, FALL_W, INVERSE_SPACING, KEEP_T, KICK_T, KICK_U, MASS
from oracles.readable_chain.verlet import (
    moved_reference,
    shaft_forces_reference,
    solve_shafts_reference,
    tally_reference,
    twin,
)


def step_reference(plan, law, state, gradients, torque, forces):
    """One step of the scheme, Eqs. (2.32) and (2.35)-(2.38)."""
    old, shaft_old = state.x_t.copy(), state.q_t.copy()
    pull = np.stack(law.excess_components(*gradients))
    right = shaft_forces_reference(plan, state, pull, torque) + (plan.matrix - plan.loss) @ shaft_old
    shaft_new, friction = solve_shafts_reference(plan, plan.matrix, right, shaft_old)
    new = _kicked(plan, law, state.x, old)
    tally_reference(plan, state, old, new, 0.5 * (shaft_old + shaft_new), friction, torque, forces)
    moved_reference(plan, state, new, shaft_new)


def _kicked(plan, law, x, old):
    """Velocities after the step, by central differences, Eqs. (2.33) and (2.34)."""
    inverse = plan.segment[INVERSE_SPACING, 1:]  # of the segment behind each node, equal to that before it
    first = (x[:, 2:] - x[:, :-2]) * 0.5 * inverse
    second = (x[:, 2:] - 2.0 * x[:, 1:-1] + x[:, :-2]) * inverse**2
    density = plan.node[MASS, 1] * inverse[0]
    gained = plan.step * np.stack(accelerations(law, density, tuple(first), tuple(second)))
    inner, new = slice(1, -1), old.copy()
    moves = plan.node[KICK_U, inner] > 0.0
    share = np.where(moves, plan.node[KICK_T, inner] / np.where(moves, plan.node[KICK_U, inner], 1.0), 0.0)
    new[0, inner] += np.where(moves, gained[0] + plan.node[FALL_U, inner], 0.0)
    new[1:, inner] = plan.node[KEEP_T, inner] * old[1:, inner] + share * gained[1:]
    new[2, inner] += plan.node[FALL_W, inner]
    return new


integrate_reference = twin(step_reference)
