"""Time integration of the uniform-tension model: a readable version and compiled ones.

Half-sine plucks want no more, and ensembles run thousands of them. Twin:
`cabledrive.reduction.uniform_tension_kernels.integrate_reference`.
"""

from typing import Any

import numpy as np

from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.parameters.arrays import Array

Arrays = tuple[Array, Array, Array, Array]


def integrate_reference(
    c: Any, q: Array, p: Array, a: Array, b: Array, torque: Array, h: float, stride: int
) -> Arrays:
    """Readable twin of the compiled integrator; takes and returns what `integrate` and its kernel do."""
    steps = torque.size - 1
    along, across, tallies = [], [], []
    peaks = np.array([[np.inf, 0.0], [np.inf, 0.0]])
    tally = np.zeros(3)
    for n in range(steps + 1):
        stretched = np.einsum("pjm,m->j", a**2, c.stretching)
        peaks[:, 0] = np.minimum(peaks[:, 0], q @ c.tension_along + c.tension_across * stretched)
        peaks[:, 1] = np.maximum(peaks[:, 1], np.sqrt(np.sum(np.sum(np.abs(a), axis=2) ** 2, axis=0)))
        stiffening = c.per_mass * np.einsum("k,kjm->jm", q, c.coupling) + stretched[:, None] * c.carried
        force = c.torque_shape * torque[n] - np.einsum("kjm,pjm->k", c.coupling, a**2)
        pull = -stiffening * a
        half = 0.0 if n == 0 else 0.5 * h
        speed, swing = p + half * force, b + half * pull
        power = np.array(
            [
                torque[n] * (c.torque_shape @ speed),
                c.loss_across * np.sum(swing**2),
                speed @ c.loss_along @ speed,
            ]
        )
        tally += power * half
        if n % stride == 0:
            along.append([q.copy(), speed])
            across.append([a.copy(), swing])
            tallies.append(tally.copy())
        rest = 0.0 if n == steps else 0.5 * h
        tally += power * rest
        p += (half + rest) * force
        b += (half + rest) * pull
        if n < steps:
            q[:], p[:] = np.split(c.along @ np.concatenate((q, p)), 2)
            a[0] -= c.sag
            a[:], b[:] = c.across[0] * a + c.across[1] * b, c.across[2] * a + c.across[3] * b
            a[0] += c.sag
    return np.array(along), np.array(across), np.array(tallies), peaks


@njit
def integration_kernel(
    c: Any, q: Array, p: Array, a: Array, b: Array, torque: Array, h: float, stride: int
) -> Arrays:
    """Arithmetic of the integration; arguments and results as `integrate_reference`."""
    steps = torque.size - 1
    longitudinal = q.size
    planes, spans, sines = a.shape
    records = steps // stride + 1
    along = np.empty((records, 2, longitudinal))
    across = np.empty((records, 2, planes, spans, sines))
    tallies = np.empty((records, 3))
    peaks = np.zeros((spans, 2))
    peaks[:, 0] = np.inf
    tally = np.zeros(3)
    power = np.empty(3)
    force = np.empty(longitudinal)
    kicked = np.empty(2 * longitudinal)
    stiffening = np.empty(sines)
    for n in range(steps + 1):
        half = 0.0 if n == 0 else 0.5 * h
        rest = 0.0 if n == steps else 0.5 * h
        record = n // stride if n % stride == 0 else -1
        power[1] = 0.0
        for k in range(longitudinal):
            force[k] = c.torque_shape[k] * torque[n]
        for j in range(spans):
            stretched = 0.0
            reach = 0.0
            for plane in range(planes):
                largest = 0.0
                for m in range(sines):
                    stretched += c.stretching[m] * a[plane, j, m] ** 2
                    largest += abs(a[plane, j, m])
                reach += largest**2
            peaks[j, 1] = max(peaks[j, 1], np.sqrt(reach))
            tension = c.tension_across * stretched
            for m in range(sines):
                stiffening[m] = stretched * c.carried[m]
            for k in range(longitudinal):
                tension += q[k] * c.tension_along[k, j]
                drive = c.per_mass * q[k]
                pumped = 0.0
                for m in range(sines):
                    stiffening[m] += drive * c.coupling[k, j, m]
                for plane in range(planes):
                    for m in range(sines):
                        pumped += c.coupling[k, j, m] * a[plane, j, m] ** 2
                force[k] -= pumped
            peaks[j, 0] = min(peaks[j, 0], tension)
            for plane in range(planes):
                lost = 0.0
                for m in range(sines):
                    x = a[plane, j, m]
                    pull = -stiffening[m] * x
                    v = b[plane, j, m] + half * pull
                    lost += v * v
                    if record >= 0:
                        across[record, 0, plane, j, m] = x
                        across[record, 1, plane, j, m] = v
                    v += rest * pull
                    if n < steps:
                        sag = c.sag[j, m] if plane == 0 else 0.0
                        a[plane, j, m] = sag + c.across[0, m] * (x - sag) + c.across[1, m] * v
                        v = c.across[2, m] * (x - sag) + c.across[3, m] * v
                    b[plane, j, m] = v
                power[1] += c.loss_across * lost
        power[0] = 0.0
        power[2] = 0.0
        for k in range(longitudinal):
            p[k] += half * force[k]
            power[0] += torque[n] * c.torque_shape[k] * p[k]
        for k in range(longitudinal):
            for i in range(longitudinal):
                power[2] += p[k] * c.loss_along[k, i] * p[i]
        for i in range(3):
            tally[i] += half * power[i]
            if record >= 0:
                tallies[record, i] = tally[i]
            tally[i] += rest * power[i]
        for k in range(longitudinal):
            if record >= 0:
                along[record, 0, k] = q[k]
                along[record, 1, k] = p[k]
            kicked[k] = q[k]
            p[k] += rest * force[k]
            kicked[longitudinal + k] = p[k]
        if n < steps:
            for k in range(longitudinal):
                q[k] = 0.0
                p[k] = 0.0
                for i in range(2 * longitudinal):
                    q[k] += c.along[k, i] * kicked[i]
                    p[k] += c.along[longitudinal + k, i] * kicked[i]
    return along, across, tallies, peaks


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
