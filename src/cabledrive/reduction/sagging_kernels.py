"""Eq. (A.36) in time: leapfrog with exact linear frequencies, friction as impulses, a standing floor."""

# mypy: allow-untyped-defs

import numpy as np

from cabledrive.mechanics.compiled import njit
from cabledrive.reduction.motion_kernels import exact_stiffness

SWEEPS = 12
"""Passes over the shafts' friction impulses."""


@njit
def rub(shape, impulse_rate, solved, friction, h, p):
    """Coulomb friction of the shafts: impulses up to h c that take each rim's speed towards zero, in place."""
    shafts = friction.size
    given = np.zeros(shafts)
    for _ in range(SWEEPS):
        for s in range(shafts):
            if friction[s] > 0.0:
                speed = 0.0
                for k in range(p.size):
                    speed += shape[s, k] * p[k]
                wanted = given[s] - speed / impulse_rate[s]
                wanted = min(max(wanted, -h * friction[s]), h * friction[s])
                for k in range(p.size):
                    p[k] += solved[s, k] * (wanted - given[s])
                given[s] = wanted


@njit
def integrate_sagging(c, force, first, h, floor, q, p, a, b, top, modal, when, least, history):
    """Step the model along sampled modal torques, state in place.

    `top` keeps the largest displacement at the probes, `modal` the largest amplitude of each mode and `when`
    its step, counted from `first`, `least` the lowest tension at the watched segments; `history` the
    longitudinal amplitudes of every step.
    """
    modes, rows, most = c.direct.shape
    slope = np.zeros((modes, rows, most))
    pulled, pushed = np.zeros(modes), np.zeros(modes)
    refresh = 8
    for n in range(force.size):
        stretch = 0.0
        pulled[:] = 0.0
        for r in range(rows):
            for j in range(c.count[r]):
                turned = 0.0
                for i in range(c.count[r]):
                    turned += c.square[r, j, i] * a[r, i]
                stretch += (c.bend[r, j] + turned) * a[r, j]
                for k in range(modes):
                    if c.stiff[k] > 0.0:
                        sum_ = 0.0
                        for i in range(c.count[r]):
                            sum_ += c.coupling[k, r, j, i] * a[r, i]
                        slope[k, r, j] = c.direct[k, r, j] + sum_
                        pulled[k] += (c.direct[k, r, j] + 0.5 * sum_) * a[r, j]
        for k in range(modes):
            pushed[k] = c.torque_shape[k] * force[n] - c.stiff[k] * q[k] - pulled[k]
        for r in range(rows):
            for j in range(c.count[r]):
                turned = 0.0
                for i in range(c.count[r]):
                    turned += c.square[r, j, i] * a[r, i]
                pull = c.carried * stretch * (c.bend[r, j] + 2.0 * turned)
                for k in range(modes):
                    if c.stiff[k] > 0.0:
                        pull += (q[k] + pulled[k] * c.compliance[k]) * slope[k, r, j]
                loss = 0.5 * h * c.loss[r, j]
                rate = c.spring[r, j] * a[r, j] + pull / c.mass[r, j]
                b[r, j] = ((1.0 - loss) * b[r, j] - h * rate) / (1.0 + loss)
        p[:] = c.kept @ p + h * (c.solve @ pushed)
        rub(c.friction_shape, c.impulse_rate, c.solved, c.friction, h, p)
        q += h * p
        a += h * b
        if history.shape[0] > 0:
            history[n] = q
        if floor > 0.0 and n % refresh == 0:
            for r in range(rows):
                for j in range(c.count[r]):
                    size = np.sqrt(a[r, j] ** 2 + (b[r, j] / c.natural[r, j]) ** 2)
                    if 0.0 < size < floor:
                        a[r, j] *= floor / size
                        b[r, j] *= floor / size
        if n % 2 == 0:
            for r in range(rows):
                for j in range(c.count[r]):
                    if abs(a[r, j]) > modal[r, j]:
                        modal[r, j] = abs(a[r, j])
                        when[r, j] = first + n
                for x in range(c.probes.shape[1]):
                    place = 0.0
                    for j in range(c.count[r]):
                        place += c.probes[r, x, j] * a[r, j]
                    top[r, x] = max(top[r, x], abs(place))
        for x in range(c.rest.size):
            tension = c.rest[x] + c.raised * stretch
            for k in range(modes):
                tension += c.watched[k, x] * q[k]
            least[0] = min(least[0], tension)
    if not np.isfinite(q.sum() + a.sum()):
        least[0] = -np.inf
        top[:] = np.inf
