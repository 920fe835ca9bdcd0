"""Time integration of the uniform-tension model: a readable version and a compiled one."""

from typing import Any

import numpy as np

from cabledrive.mechanics.compiled import njit
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
