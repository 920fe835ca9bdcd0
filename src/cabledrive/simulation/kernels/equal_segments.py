r"""Compiled step of a cable of equal segments under the exact law: tension, kick and drift in one pass.

With :math:`y = h^2 z = \Delta u\,(2h + \Delta u) + \Delta v^2 + \Delta w^2` of a segment's ends and the gain
:math:`g = EA\,z\,s(z)`, s the series of `cabledrive.simulation.kernels.segments`, a segment carries

.. math:: h\,(p_u, p_v, p_w) = (T_0 + g)\,(\Delta u, \Delta v, \Delta w) + (g h, 0, 0)

above the pretension. The pass treats the rims like any other node; what it makes of them is put right after
it. All steps between two records are taken in one call, so that what does not change is set up once. Twin:
`cabledrive.simulation.readable.verlet`.
"""

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import njit, njit_in_place, njit_inlined
from cabledrive.simulation.channels import TRANSVERSE_LOSS
from cabledrive.simulation.kernels.segments import C0, C1, C2, C3, C4, C5, C6, C7, LARGEST_Z
from cabledrive.simulation.kernels.shafts import add_to
from cabledrive.simulation.kernels.steps import keep_extremes, shaft_forces, tally_shafts, turn_shafts
from cabledrive.simulation.plan import (
    DRAG,
    FALL_U,
    FALL_W,
    INVERSE_SPACING,
    KEEP_T,
    KICK_T,
    KICK_U,
    RADIUS,
    SPACING,
    Plan,
)
from cabledrive.simulation.state import State
from cabledrive.simulation.workspace import NEW, Workspace

ORDERS = 8


@njit
def gain_series(rigidity: float, inverse_spacing: float) -> Array:
    """Coefficients of the gain in powers of y, from the first power on."""
    series = np.array([C0, C1, C2, C3, C4, C5, C6, C7])
    scale = rigidity
    for k in range(ORDERS):
        scale *= inverse_spacing * inverse_spacing
        series[k] *= scale
    return series


@njit_in_place
def safe_range(plan: Plan) -> tuple[float, float]:
    """Centre and half width of the y at which a segment is taut and the series holds."""
    slack_z = (1.0 + plan.slack_strain) ** 2 - 1.0
    square = plan.segment[SPACING, 0] ** 2
    lowest = max(slack_z, -LARGEST_Z) * square
    highest = LARGEST_Z * square
    return 0.5 * (highest + lowest), 0.5 * (highest - lowest)


@njit_inlined
def gain_at(x: Array, i: int, series: Array, h: float) -> float:
    """Gain of segment i."""
    du = x[0, i + 1] - x[0, i]
    dv = x[1, i + 1] - x[1, i]
    dw = x[2, i + 1] - x[2, i]
    y = du * (2.0 * h + du) + dv * dv + dw * dw
    gain = 0.0
    for k in range(ORDERS):
        gain = y * (series[ORDERS - 1 - k] + gain)
    return gain


@njit_inlined
def pulls_on_rims(x: Array, series: Array, h: float, pretension: float, segments: int, p: Array) -> None:
    """Axial components of the segments beside the rims, into their places in p."""
    for k in range(2 * (p.shape[1] // segments)):
        i = (k // 2) * segments + (k % 2) * (segments - 1)
        gain = gain_at(x, i, series, h)
        p[0, i] = (pretension + gain) * (x[0, i + 1] - x[0, i]) / h + gain


@njit_in_place
def stays_in_plane(x: Array, x_t: Array) -> bool:
    """Whether nothing has left the plane of the pulleys; then nothing does."""
    size = 0.0
    for i in range(x.shape[1]):
        size += abs(x[1, i]) + abs(x_t[1, i])
    return size == 0.0


@njit_in_place
def step_equal_segments(
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    series: Array,
    u: Array,
    v: Array | None,
    w: Array,
    u_t: Array,
    v_t: Array | None,
    w_t: Array,
) -> bool:
    """Take a step for each entry of ``torque``; without v the cable stays in the plane of the pulleys.

    The rows of the state are arguments of their own: only then does the compiler see that they do not
    overlap, and takes several nodes at once. Returns False as soon as a segment is found slack or out of the
    range of the series; the state is then of no use.
    """
    x, x_t, motor, tallies, p, shaft = state.x, state.x_t, state.motor, state.tallies, work.p, work.shaft
    n, step, closed, pretension = plan.segments, plan.step, plan.closed, plan.pretension
    last = p.shape[1]
    h, inverse = plan.segment[SPACING, 0], plan.segment[INVERSE_SPACING, 0]
    h2 = 2.0 * h
    centre, reach = safe_range(plan)
    fall_u, fall_w = plan.node[FALL_U], plan.node[FALL_W]
    kick_u, kick_t, keep = (
        plan.node[KICK_U, 1] * inverse,
        plan.node[KICK_T, 1] * inverse,
        plan.node[KEEP_T, 1],
    )
    loss = 0.25 * step * plan.node[DRAG, 1]
    matrix, back = plan.shaft_matrices[0], plan.shaft_matrices[1]
    per_radius = 1.0 / plan.shaft[RADIUS, 0]
    c0, c1, c2, c3 = series[0], series[1], series[2], series[3]
    c4, c5, c6, c7 = series[4], series[5], series[6], series[7]
    for j in range(torque.size):
        keep_extremes(n, plan.spans, plan.probe, x, motor, state.extremes)
        pulls_on_rims(x, series, h, pretension, n, p)
        push = torque[j] * per_radius
        shaft_forces(closed, n, plan.joint_stiffness, plan.node, x, x_t, motor, p, plan.driven, push, shaft)
        turn_shafts(step, closed, n, matrix, back, plan.shaft, motor, x_t, shaft)
        drive, load = u[0] + step * shaft[NEW, 0], u[n] + step * shaft[NEW, 1]
        pull = pretension + gain_at(x, 0, series, h)
        p_u, p_w = h * p[0, 0], pull * w[1]  # as if the first segment pulled from before as well
        p_v = pull * v[1] if v is not None else 0.0
        squares = 0.0
        outside = 0
        for i in range(last):
            du = u[i + 1] - u[i]
            dw = w[i + 1] - w[i]
            y = du * (h2 + du) + dw * dw
            if v is not None:
                dv = v[i + 1] - v[i]
                y += dv * dv
            gain = y * (c0 + y * (c1 + y * (c2 + y * (c3 + y * (c4 + y * (c5 + y * (c6 + y * c7)))))))
            outside += abs(y - centre) > reach
            pull = pretension + gain
            q = pull * du + gain * h
            speed = u_t[i] + fall_u[i] + kick_u * (q - p_u)
            p_u = q
            u_t[i] = speed
            u[i] += step * speed
            if v is not None and v_t is not None:
                q = pull * dv
                speed = keep * v_t[i] + kick_t * (q - p_v)
                p_v = q
                twice = speed + v_t[i]
                squares += twice * twice
                v_t[i] = speed
                v[i] += step * speed
            q = pull * dw
            speed = keep * w_t[i] + fall_w[i] + kick_t * (q - p_w)
            p_w = q
            twice = speed + w_t[i]
            squares += twice * twice
            w_t[i] = speed
            w[i] += step * speed
        if outside > 0:
            return False
        squares -= w_t[n] ** 2 if last > n else 0.0
        u[0], u[n], u_t[0], u_t[n] = drive, load, shaft[NEW, 0], shaft[NEW, 1]
        w[0], w[n], w_t[0], w_t[n] = 0.0, 0.0, 0.0, 0.0
        if v is not None and v_t is not None:
            squares -= v_t[n] ** 2 if last > n else 0.0
            v[0], v[n], v_t[0], v_t[n] = 0.0, 0.0, 0.0, 0.0
        if closed:
            u[last], u_t[last] = drive, shaft[NEW, 0]
        if loss > 0.0:
            add_to(tallies, TRANSVERSE_LOSS, loss * squares)
        tally_shafts(step, plan.joint_damping, plan.shaft, plan.driven, push, shaft, tallies)
    return True
