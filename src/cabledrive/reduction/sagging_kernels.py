"""Eq. (A.36) in time: leapfrog with exact linear frequencies, friction as impulses, a standing floor."""

# mypy: allow-untyped-defs

import numpy as np

from cabledrive.mechanics.compiled import njit

SWEEPS = 12
"""Passes over the shafts' friction impulses."""

MOTOR_SHAFT = 2
"""Place of the motor among the shafts, on which the torque acts."""

REFRESH = 8
"""Steps between two looks at the floor."""


@njit
def rub(shape, impulse_rate, solved, friction, h, p):
    """Coulomb friction of the shafts: impulses up to h c towards a rim speed of zero, in place; returned."""
    shafts = friction.size
    given = np.zeros(shafts)
    for _ in range(SWEEPS):
        settled = True
        for s in range(shafts):
            if friction[s] > 0.0:
                speed = 0.0
                for k in range(p.size):
                    speed += shape[s, k] * p[k]
                wanted = given[s] - speed / impulse_rate[s]
                wanted = min(max(wanted, -h * friction[s]), h * friction[s])
                if wanted != given[s]:
                    settled = False
                    for k in range(p.size):
                        p[k] += solved[s, k] * (wanted - given[s])
                    given[s] = wanted
        if settled:  # every further pass would change nothing
            break
    return given


@njit
def integrate_sagging(c, force, first, timing, state, kept):
    """Step the model along sampled torques above the holding torque, state in place.

    `timing`: step [s], and the floor of the amplitudes [m]; `state`: q, p, a, b; `kept`: what follows.

    `top` keeps the largest displacement at the probes, what the floor adds taken off mode by mode; `modal`
    the largest amplitude of each mode and `when` its step, counted from `first`; `least` the lowest tension
    at the watched segments; `history` the longitudinal amplitudes of every step.
    """
    (h, floor), (q, p, a, b), (top, modal, when, least, history) = timing, state, kept
    modes, rows, most = c.direct.shape
    products = np.zeros((rows, (1 + modes) * most))  # of `c.table` and the amplitudes, stretch by stretch
    pulled, pushed, pull, above = np.zeros(modes), np.zeros(modes), np.zeros(most), np.zeros(most)
    places, rubbed = np.zeros(c.probes.shape[2]), np.zeros(c.friction.size)
    inert = (
        modes - c.followers.size
    )  # the rows behind them are forces, to which the other modes' strain is tied
    for n in range(force.size):
        for k in range(c.followers.size):
            shaft = c.followers[k]
            q[inert + k] = rubbed[shaft] / h + (c.rim_force * force[n] if shaft == MOTOR_SHAFT else 0.0)
        # forces at the time of the displacements; speeds live half a step earlier
        stretch = 0.0
        for k in range(modes):
            pulled[k] = 0.0
        for r in range(rows):
            product = products[r]
            for m in range(product.size):
                product[m] = 0.0
            for i in range(c.counts[r]):
                amplitude, row = a[r, i], c.table[r, i]
                for m in range(product.size):
                    product[m] += row[m] * amplitude
            for j in range(c.counts[r]):
                stretch += (c.bend[r, j] + product[j]) * a[r, j]
            for k in range(modes):
                total, at = 0.0, (1 + k) * most
                for j in range(c.counts[r]):
                    half = 0.5 * product[at + j]
                    product[at + j] += c.direct[k, r, j]
                    total += (product[at + j] - half) * a[r, j]
                pulled[k] += total
        for k in range(modes):
            pushed[k] = c.torque_shape[k] * force[n] - c.stiff[k] * q[k] - pulled[k]
        for r in range(rows):
            product = products[r]
            for j in range(c.counts[r]):
                pull[j] = c.carried * stretch * (c.bend[r, j] + 2.0 * product[j])
            for k in range(modes):
                # the kept modes' static share is in `carried` already: their inertia is what differs
                moved, at = q[k] + pulled[k] * c.compliance[k], (1 + k) * most
                for j in range(c.counts[r]):
                    pull[j] += moved * product[at + j]
            for j in range(c.counts[r]):
                loss = 0.5 * h * c.loss[r, j]
                rate = c.spring[r, j] * a[r, j] + pull[j] / c.mass[r, j]
                b[r, j] = ((1.0 - loss) * b[r, j] - h * rate) / (1.0 + loss)
        for k in range(modes):  # a loop compiles in a tenth of the time that a product of matrices takes
            total = 0.0
            for i in range(modes):
                total += c.kept[k, i] * p[i] + h * c.solve[k, i] * pushed[i]
            pulled[k] = total
        for k in range(inert):
            p[k] = pulled[k]
        rubbed = rub(c.friction_shape, c.impulse_rate, c.solved, c.friction, h, p)
        for k in range(modes):
            q[k] += h * p[k]  # a follower's speed is never set
            if history.shape[0] > 0:
                history[n, k] = q[k]
        for r in range(rows):
            for j in range(most):
                a[r, j] += h * b[r, j]
        if floor > 0.0 and n % REFRESH == 0:
            for r in range(rows):
                for j in range(c.counts[r]):
                    size = np.sqrt(a[r, j] ** 2 + (b[r, j] / c.natural[r, j]) ** 2)
                    if 0.0 < size < floor:
                        a[r, j] *= floor / size
                        b[r, j] *= floor / size
        if n % 2 == 0:
            for r in range(rows):
                for j in range(c.counts[r]):
                    size = abs(a[r, j])
                    above[j] = np.copysign(max(size - floor, 0.0), a[r, j])
                    if size > modal[r, j]:
                        modal[r, j] = size
                        when[r, j] = first + n
                for x in range(places.size):
                    places[x] = 0.0
                for j in range(c.counts[r]):
                    for x in range(places.size):
                        places[x] += c.probes[r, j, x] * above[j]
                for x in range(places.size):
                    top[r, x] = max(top[r, x], abs(places[x]) + floor)
        for x in range(c.rest.size):
            tension = c.rest[x] + c.raised * stretch
            for k in range(modes):
                tension += c.watched[k, x] * q[k]
            least[0] = min(least[0], tension)
    whole = 0.0
    for k in range(modes):
        whole += q[k]
    for r in range(rows):
        for j in range(most):
            whole += a[r, j]
    if not np.isfinite(whole):
        least[0] = -np.inf
        for r in range(rows):
            for x in range(top.shape[1]):
                top[r, x] = np.inf
