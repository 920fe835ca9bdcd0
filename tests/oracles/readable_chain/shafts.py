"""Readable motion of the shafts over one step: implicit friction, set-valued or smoothed."""

from itertools import product

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.plan import Plan


def friction_of(plan: Plan) -> tuple[Array, Array]:
    """Coulomb friction and speed over which it is smoothed, of each shaft."""
    coulomb, smooth = np.zeros(3), np.full(3, plan.smooth.max(initial=0.0))
    coulomb[plan.stick], smooth[plan.stick] = plan.bound, plan.smooth
    return coulomb, smooth


def solve_shafts_reference(plan: Plan, matrix: Array, right: Array, old: Array) -> tuple[Array, Array]:
    r"""New speeds v and frictions f of the shafts: :math:`A v + f = r`, :math:`f \in c\,\mathrm{Sgn}(v)`.

    Each shaft sticks or slips one way or the other: all cases are tried until one fits. A smoothed friction
    :math:`f_i = c_i \tanh\frac{v_i + v_i^{old}}{2 s_i}` is found by Newton's method.
    """
    free = np.flatnonzero(plan.moves > 0.0)
    new, friction = np.zeros(3), np.zeros(3)
    inner = matrix[np.ix_(free, free)]
    coulomb, smooth = (values[free] for values in friction_of(plan))
    if (smooth > 0.0).any():
        new[free] = _smoothed(inner, right[free], coulomb, smooth, old[free])
    else:
        new[free] = _stick_slip(inner, right[free], coulomb)
    rubbing = free[coulomb > 0.0]
    friction[rubbing] = (right - matrix @ new)[rubbing]
    return new, friction


def _stick_slip(matrix: Array, right: Array, coulomb: Array) -> Array:
    best, least = np.zeros_like(right), np.inf
    for case in product((0.0, 1.0, -1.0), repeat=right.size):
        way = np.array(case)
        slips = way != 0.0
        speed = np.zeros_like(right)
        inner = matrix[np.ix_(slips, slips)]
        speed[slips] = np.linalg.solve(inner, (right - coulomb * way)[slips])
        friction = right - matrix @ speed
        wrong_way = np.maximum(-speed * way, 0.0)
        too_much = np.where(slips, 0.0, np.maximum(np.abs(friction) - coulomb, 0.0)) / np.diag(matrix)
        miss = float(np.sum(wrong_way + too_much))
        if miss < least:
            best, least = speed, miss
    return best


def _smoothed(matrix: Array, right: Array, coulomb: Array, smooth: Array, old: Array) -> Array:
    def excess(speed: Array) -> Array:
        return matrix @ speed + coulomb * np.tanh(0.5 * (speed + old) / smooth) - right

    speed = old.copy()
    for _ in range(200):
        push, left = np.tanh(0.5 * (speed + old) / smooth), excess(speed)
        slope = matrix + np.diag(0.5 * coulomb * (1.0 - push**2) / smooth)
        step = np.linalg.solve(slope, left)
        if np.linalg.norm(excess(speed - step)) > np.linalg.norm(left):
            # where the tangent is flat and the friction is not, the chord through zero keeps it from cycling
            chord = matrix + np.diag(coulomb / np.maximum(np.abs(speed + old), 2.0 * smooth))
            step = np.linalg.solve(chord, left)
        speed = speed - step
        if np.max(np.abs(step)) <= 1e-15 * np.max(np.abs(speed), initial=1e-300):
            break
    return speed
