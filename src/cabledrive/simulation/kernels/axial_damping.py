r"""Compiled Kelvin-Voigt damping of the cable, implicit: an unknown tension per segment, tridiagonal.

The damping tension of a segment, :math:`q = b\,\dot\varepsilon = \beta\,d \cdot \Delta V`, acts along
:math:`d = \partial\lambda/\partial(u', v', w')`; V is the mean velocity over the step, which q itself
changes: :math:`V = V^* + \tfrac12 g\,\Delta(q d)` with g = step / mass. The speeds of the rims are left open:
each span answers with :math:`q = q_0 + q_a V_a + q_b V_b`.
"""

from math import sqrt

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import for_kernels, njit_in_place
from cabledrive.simulation.kernels.segments import (
    EXACT,
    LINEAR,
    segment_strain,
)
from cabledrive.simulation.plan import INVERSE_SPACING, Plan


@njit_in_place
@for_kernels
def strain_directions(plan: Plan, x: Array, direction: Array) -> None:
    """Derivative of the strain of each segment, shape (3, segments); zero where the cable is slack."""
    law, inverse_spacing = plan.law, plan.segment[INVERSE_SPACING]
    for i in range(inverse_spacing.size):
        h = inverse_spacing[i]
        u_x = (x[0, i + 1] - x[0, i]) * h
        v_x = (x[1, i + 1] - x[1, i]) * h
        w_x = (x[2, i + 1] - x[2, i]) * h
        along = 1.0
        if law == EXACT:
            stretch = sqrt((1.0 + u_x) ** 2 + v_x * v_x + w_x * w_x)
            along = (1.0 + u_x) / stretch
            v_x /= stretch
            w_x /= stretch
        elif law == LINEAR:
            v_x = 0.0
            w_x = 0.0
        if plan.tension_only and segment_strain(law, x, inverse_spacing, i) < plan.slack_strain:
            along = 0.0
            v_x = 0.0
            w_x = 0.0
        direction[0, i] = along
        direction[1, i] = v_x
        direction[2, i] = w_x


@njit_in_place
@for_kernels
def solve_span(
    first: int,
    last: int,
    compliance: Array,
    kick_u: Array,
    kick_t: Array,
    mean: Array,
    direction: Array,
    q: Array,
) -> None:
    """Damping tensions of segments first .. last - 1, affine in the speeds of the two rims.

    ``compliance`` is 1 / beta, ``mean`` (3, nodes) the mean velocities without damping. The rows of ``q`` get
    the constant part, the answers to unit speed of the rim at the start and at the end, and the pivots.
    """
    for i in range(first, last):
        before = i > first  # the node before the segment is no rim
        behind = i < last - 1
        own = compliance[i]
        rate = 0.0
        for axis in range(3):
            d = direction[axis, i]
            kick = kick_u if axis == 0 else kick_t
            if before:
                own += 0.5 * kick[i] * d * d
                rate -= d * mean[axis, i]
            if behind:
                own += 0.5 * kick[i + 1] * d * d
                rate += d * mean[axis, i + 1]
        q[0, i] = rate
        q[1, i] = 0.0 if before else -direction[0, i]
        q[2, i] = 0.0 if behind else direction[0, i]
        if before:  # eliminate the segment before
            link = _link(i, kick_u, kick_t, direction)
            share = link / q[3, i - 1]
            own -= share * link
            for k in range(3):
                q[k, i] -= share * q[k, i - 1]
        q[3, i] = own
    for i in range(last - 1, first - 1, -1):
        link = _link(i + 1, kick_u, kick_t, direction) if i < last - 1 else 0.0
        for k in range(3):
            if i < last - 1:
                q[k, i] -= link * q[k, i + 1]
            q[k, i] /= q[3, i]


@njit_in_place
def _link(node: int, kick_u: Array, kick_t: Array, direction: Array) -> float:
    """Coupling of the two segments that meet at a node."""
    return -0.5 * (
        kick_u[node] * direction[0, node - 1] * direction[0, node]
        + kick_t[node]
        * (direction[1, node - 1] * direction[1, node] + direction[2, node - 1] * direction[2, node])
    )
