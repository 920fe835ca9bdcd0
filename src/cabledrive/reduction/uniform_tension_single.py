"""Time integration of the uniform-tension model with one sine per span, in one plane: scalars only.

Half-sine plucks want no more, and ensembles run thousands of them. Twin:
`cabledrive.reduction.uniform_tension_kernels.integrate_reference`.
"""

from typing import Any

import numpy as np

from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.parameters.arrays import Array

Arrays = tuple[Array, Array, Array, Array]


@njit
def single_sine_kernel(
    c: Any, q: Array, p: Array, a: Array, b: Array, torque: Array, h: float, stride: int
) -> Arrays:
    """One sine per span; arguments and results as `integrate_reference`, with a, b of shape (1, 2, 1)."""
    records = (torque.size - 1) // stride + 1
    along = np.empty((records, 2, q.size))
    across = np.empty((records, 2, 1, 2, 1))
    tallies = np.empty((records, 3))
    peaks = np.zeros((2, 2))
    kicked, force = np.empty(2 * q.size), np.empty(q.size)
    matrices = c.along, c.coupling, c.torque_shape, c.loss_along, c.tension_along
    scalars = c.per_mass, c.carried[0], c.stretching[0], c.tension_across, c.loss_across
    _integrate(
        matrices, c.across[:, 0], c.sag[:, 0], scalars, q, p, a[0, :, 0], b[0, :, 0], torque, h, stride,
        along, across[:, :, 0, :, 0], tallies, peaks, kicked, force,
    )  # fmt: skip
    return along, across, tallies, peaks


@njit_in_place
def _integrate(
    matrices: tuple[Array, Array, Array, Array, Array],
    flow: Array,
    sag: Array,
    scalars: tuple[float, float, float, float, float],
    q: Array,
    p: Array,
    a: Array,
    b: Array,
    torque: Array,
    h: float,
    stride: int,
    along: Array,
    across: Array,
    tallies: Array,
    peaks: Array,
    kicked: Array,
    force: Array,
) -> None:
    exact, coupling, torque_shape, loss_along, tension_along = matrices
    per_mass, carried, stretching, tension_across, loss_across = scalars
    steps, modes = torque.size - 1, q.size
    x1, x2, v1, v2 = a[0], a[1], b[0], b[1]
    sag1, sag2 = sag[0], sag[1]
    low1 = low2 = np.inf
    top1 = top2 = 0.0
    work, lost, slid = 0.0, 0.0, 0.0
    for n in range(steps + 1):
        half = 0.0 if n == 0 else 0.5 * h
        rest = 0.0 if n == steps else 0.5 * h
        square1, square2 = x1 * x1, x2 * x2
        top1, top2 = max(top1, square1), max(top2, square2)
        stretched1, stretched2 = stretching * square1, stretching * square2
        tension1, tension2 = tension_across * stretched1, tension_across * stretched2
        pull1, pull2 = carried * stretched1, carried * stretched2
        power, friction = 0.0, 0.0
        for k in range(modes):
            push = torque_shape[k] * torque[n]
            tension1 += q[k] * tension_along[k, 0]
            tension2 += q[k] * tension_along[k, 1]
            pull1 += per_mass * q[k] * coupling[k, 0, 0]
            pull2 += per_mass * q[k] * coupling[k, 1, 0]
            force[k] = push - coupling[k, 0, 0] * square1 - coupling[k, 1, 0] * square2
            p[k] += half * force[k]
            power += push * p[k]
        for k in range(modes):
            for i in range(modes):
                friction += p[k] * loss_along[k, i] * p[i]
        low1, low2 = min(low1, tension1), min(low2, tension2)
        pull1, pull2 = -pull1 * x1, -pull2 * x2
        v1 += half * pull1
        v2 += half * pull2
        loss = loss_across * (v1 * v1 + v2 * v2)
        work += half * power
        lost += half * loss
        slid += half * friction
        if n % stride == 0:
            record = n // stride
            across[record, 0, 0], across[record, 0, 1] = x1, x2
            across[record, 1, 0], across[record, 1, 1] = v1, v2
            tallies[record, 0], tallies[record, 1], tallies[record, 2] = work, lost, slid
            for k in range(modes):
                along[record, 0, k], along[record, 1, k] = q[k], p[k]
        work += rest * power
        lost += rest * loss
        slid += rest * friction
        v1 += rest * pull1
        v2 += rest * pull2
        for k in range(modes):
            p[k] += rest * force[k]
            kicked[k], kicked[modes + k] = q[k], p[k]
        if n < steps:
            y1, y2 = x1 - sag1, x2 - sag2
            x1, x2 = sag1 + flow[0] * y1 + flow[1] * v1, sag2 + flow[0] * y2 + flow[1] * v2
            v1, v2 = flow[2] * y1 + flow[3] * v1, flow[2] * y2 + flow[3] * v2
            for k in range(modes):
                place, speed = 0.0, 0.0
                for i in range(2 * modes):
                    place += exact[k, i] * kicked[i]
                    speed += exact[modes + k, i] * kicked[i]
                q[k], p[k] = place, speed
    a[0], a[1], b[0], b[1] = x1, x2, v1, v2
    peaks[0, 0], peaks[1, 0] = low1, low2
    peaks[0, 1], peaks[1, 1] = np.sqrt(top1), np.sqrt(top2)
