"""Kernels of `cabledrive.reduction.stretches`: forces of the stretches, exact flow, and runs made of them."""

import numpy as np

from cabledrive.mechanics.compiled import njit, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.stretches import StretchNumbers, StretchState

SWEEPS = 12
"""Passes over the shafts' friction impulses."""

MOTOR_SHAFT = 2
"""Place of the motor among the shafts, on which the torque acts."""

REFRESH = 8
"""Steps between two looks at the floor."""


@njit_part
def start_cable(plucks: Array, s: StretchState) -> None:
    """Pluck each row by its first mode, shape (b,) [m]; everything else at rest."""
    s.holds[0] = 1
    for b in range(plucks.size):
        s.sines[b, 0] = plucks[b]


@njit_part
def stretch_rows(c: StretchNumbers, s: StretchState) -> None:
    """P of each row, where D is diagonal and nothing bends."""
    for b in range(s.sines.shape[0]):
        stretched = 0.0
        for m in range(s.sines.shape[1]):
            stretched += c.model.square[b, m] * s.sines[b, m] * s.sines[b, m]
        s.stretched[b] = 0.5 * stretched


@njit_part
def pull_sines(c: StretchNumbers, s: StretchState) -> None:
    """Accelerations that modes and rows give each other, where G and D are diagonal and L, l and s zero."""
    stretch_rows(c, s)
    k = s.force.size
    for i in range(k):
        s.force[i] = 0.0
    for b in range(s.sines.shape[0]):
        carried = 0.0
        for d in range(s.sines.shape[0]):
            carried += c.model.carried[b, d] * s.stretched[d]
        for m in range(s.sines.shape[1]):
            s.stiffening[m] = carried * c.model.square[b, m]
        for i in range(k):
            pumped, along = 0.0, s.modes[i]
            for m in range(s.sines.shape[1]):
                s.stiffening[m] += along * c.model.coupling[i, b, m]
                pumped += c.model.coupling[i, b, m] * s.sines[b, m] * s.sines[b, m]
            s.force[i] -= 0.5 * pumped
        for m in range(s.sines.shape[1]):
            s.pull[b, m] = -s.stiffening[m] * c.per_mass[b, m] * s.sines[b, m]


@njit_part
def pull_coupled(c: StretchNumbers, s: StretchState) -> None:
    """Accelerations that modes, followers and rows give each other, where G and D are full."""
    g, k, most = c.model, s.force.size, s.sines.shape[1]
    for i in range(k):
        s.force[i] = 0.0
    for b in range(s.sines.shape[0]):
        product, stretched = s.products[b], 0.0
        for m in range(product.size):
            product[m] = 0.0
        for i in range(most):
            amplitude, row = s.sines[b, i], c.table[b, i]
            if amplitude != 0.0:  # else one that only fills up the row
                for m in range(product.size):
                    product[m] += row[m] * amplitude
        for j in range(most):
            stretched += (g.bend[b, j] + 0.5 * product[j]) * s.sines[b, j]
            product[j] += g.bend[b, j]
        s.stretched[b] = stretched
        for i in range(k + s.held.size):
            total, at = 0.0, (1 + i) * most
            for j in range(most):
                half = 0.5 * product[at + j]
                product[at + j] += g.direct[i, b, j]
                total += (product[at + j] - half) * s.sines[b, j]
            if i < k:
                s.force[i] -= total
    for b in range(s.sines.shape[0]):
        product, carried = s.products[b], 0.0
        for d in range(s.sines.shape[0]):
            carried += g.carried[b, d] * s.stretched[d]
        for j in range(most):
            s.stiffening[j] = carried * product[j]
        for i in range(k + s.held.size):
            # the kept modes' static share is in `carried` already: their inertia is what differs
            moved, at = s.modes[i] - s.force[i] * g.softness[i] if i < k else s.held[i - k], (1 + i) * most
            for j in range(most):
                s.stiffening[j] += moved * product[at + j]
        for j in range(most):
            s.pull[b, j] = -s.stiffening[j] * c.per_mass[b, j]


@njit_part
def kick_modes(time: float, s: StretchState) -> None:
    """Rates after a time [s] under the accelerations last found."""
    for i in range(s.force.size):
        s.modes[s.force.size + i] += time * s.force[i]
    for b in range(s.sines.shape[0]):
        for m in range(s.sines.shape[1]):
            s.rates[b, m] += time * s.pull[b, m]


@njit_part
def flow_modes(c: StretchNumbers, inputs: Array, s: StretchState) -> None:
    """The damped linear motion over one step, exact for inputs that are held."""
    for i in range(s.modes.size):
        value = 0.0
        for j in range(s.modes.size):
            value += c.along[i, j] * s.modes[j]
        for j in range(inputs.size):
            value += c.push[i, j] * inputs[j]
        s.fresh[i] = value
    for i in range(s.modes.size):
        s.modes[i] = s.fresh[i]
    for b in range(s.sines.shape[0]):
        for m in range(s.sines.shape[1]):
            sag = c.model.sag[b, m]
            x, v = s.sines[b, m] - sag, s.rates[b, m]
            s.sines[b, m] = sag + c.across[0, b, m] * x + c.across[1, b, m] * v
            s.rates[b, m] = c.across[2, b, m] * x + c.across[3, b, m] * v


@njit_part
def cable_tension(c: StretchNumbers, s: StretchState, tensions: Array) -> None:
    """Tension of each span now, shape (x,) [N]; notes where a span is slack or too steep for the model.

    Rows are the spans, plane by plane.
    """
    stretch_rows(c, s)
    for x in range(tensions.size):
        value = c.model.rest[x]
        for i in range(s.force.size):
            value += c.model.tension[x, i] * s.modes[i]
        slope = 0.0
        for b in range(s.sines.shape[0]):
            value += c.model.raised[x, b] * s.stretched[b]
            if b % tensions.size == x:
                for m in range(s.sines.shape[1]):
                    slope += c.model.slopes[m] * abs(s.sines[b, m])
        tensions[x] = value
        if not (value > 0.0 and slope <= c.model.steepest):
            s.holds[0] = 0


@njit_part
def cable_motion(c: StretchNumbers, s: StretchState, places: Array, speeds: Array) -> None:
    """Motions shown and their rates now, shape (o,)."""
    for i in range(places.size):
        place, speed = 0.0, 0.0
        for j in range(s.force.size):
            place += c.model.motions[i, j] * s.modes[j]
            speed += c.model.motions[i, j] * s.modes[s.force.size + j]
        places[i] = place
        speeds[i] = speed


@njit_part
def cable_middle(c: StretchNumbers, s: StretchState, middles: Array) -> None:
    """Displacement of each row at its first watched point, the middle of a span, shape (b,) [m]."""
    for b in range(middles.size):
        value = 0.0
        for m in range(s.sines.shape[1]):
            value += c.model.probes[b, m, 0] * s.sines[b, m]
        middles[b] = value


@njit_part
def cable_step(c: StretchNumbers, s: StretchState, inputs: Array, tensions: Array) -> None:
    """One sample under held inputs, shape (i,) [N], [N m], by (R.4); writes the tensions at its end."""
    pull_sines(c, s)
    kick_modes(0.5 * c.step, s)
    for n in range(c.steps):
        flow_modes(c, inputs, s)
        pull_sines(c, s)
        kick_modes(c.step if n < c.steps - 1 else 0.5 * c.step, s)
        cable_tension(c, s, tensions)


@njit
def recorded_run(
    c: StretchNumbers, s: StretchState, torque: Array, stride: int
) -> tuple[Array, Array, Array, Array]:
    """The motion under a torque given at the ends of the steps, by (R.4); recorded every ``stride`` steps.

    Rows are the spans, plane by plane. Returns what `cabledrive.reduction.uniform_tension.IntegratedMotion`
    holds.
    """
    g, steps, k, (rows, most) = c.model, torque.size - 1, s.force.size, s.sines.shape
    records, spans = steps // stride + 1, g.rest.size
    along, across = np.empty((records, 2, k)), np.empty((records, 2, rows, most))
    tallies, tally, power = np.empty((records, 3)), np.zeros(3), np.zeros(3)
    peaks, tensions, reach, nothing = np.zeros((spans, 2)), np.empty(spans), np.empty(spans), np.empty(0)
    peaks[:, 0] = np.inf
    for n in range(steps + 1):
        half = 0.0 if n == 0 else 0.5 * c.step
        rest = 0.0 if n == steps else 0.5 * c.step
        pull_sines(c, s)
        cable_tension(c, s, tensions)
        reach[:] = 0.0
        for b in range(rows):
            largest = 0.0
            for m in range(most):
                largest += abs(s.sines[b, m])
            reach[b % spans] += largest**2
        for x in range(spans):
            peaks[x, 0] = min(peaks[x, 0], tensions[x])
            peaks[x, 1] = max(peaks[x, 1], np.sqrt(reach[x]))
        for i in range(k):
            s.force[i] += g.torque_shape[i] * torque[n]
        kick_modes(half, s)
        power[:] = 0.0
        for i in range(k):
            power[0] += torque[n] * g.torque_shape[i] * s.modes[k + i]
            for j in range(k):
                power[2] += s.modes[k + i] * g.damping[i, j] * s.modes[k + j]
        for b in range(rows):
            for m in range(most):
                power[1] += g.mass[b, m] * g.loss[b, m] * s.rates[b, m] ** 2
        for i in range(3):
            tally[i] += half * power[i]
        if n % stride == 0:
            r = n // stride
            along[r, 0], along[r, 1], tallies[r] = s.modes[:k], s.modes[k:], tally
            across[r, 0], across[r, 1] = s.sines, s.rates
        for i in range(3):
            tally[i] += rest * power[i]
        kick_modes(rest, s)
        if n < steps:
            flow_modes(c, nothing, s)
    return along, across, tallies, peaks


@njit_part
def rub(c: StretchNumbers, time: float, s: StretchState) -> None:
    """Coulomb friction of the shafts over a time [s]: impulses to keep each rim where it is over a step."""
    k, g = s.force.size, c.model
    for x in range(s.rubbed.size):
        s.rubbed[x] = 0.0
    for _ in range(SWEEPS):
        settled = True
        for x in range(s.rubbed.size):
            if g.friction[x] > 0.0:
                speed = 0.0
                for i in range(2 * k):
                    speed += c.glide[x, i] * s.modes[i]
                wanted = s.rubbed[x] - speed / c.give[x]
                wanted = min(max(wanted, -time * g.friction[x]), time * g.friction[x])
                if wanted != s.rubbed[x]:
                    settled = False
                    for i in range(k):
                        s.modes[k + i] += g.friction_shape[x, i] * (wanted - s.rubbed[x])
                    s.rubbed[x] = wanted
        if settled:  # every further pass would change nothing
            break
    for x in range(s.rubbed.size):
        s.rubbed[x] /= time


@njit
def extremes_run(
    c: StretchNumbers,
    s: StretchState,
    torque: Array,
    first: int,
    floor: float,
    kept: tuple[Array, Array, Array, Array, Array],
) -> None:
    """Move full rows along a torque above the holding torque at each step; ``first``: steps before.

    No amplitude of a mode across falls below ``floor`` [m]. ``kept``: largest displacement at the probes
    (b, points), what the floor adds taken off mode by mode; largest amplitude of each mode and its step
    (b, m); lowest watched tension (1,); amplitudes along and followers after every step (n, k + f), or none.
    """
    g, k, (rows, most), (top, modal, when, least, history) = c.model, s.force.size, s.sines.shape, kept
    nothing, above, places = np.empty(0), np.zeros(most), np.zeros(top.shape[1])
    for n in range(torque.size):
        for i in range(s.held.size):
            shaft = g.followers[i]
            s.held[i] = s.rubbed[shaft] + (g.rim_force * torque[n] if shaft == MOTOR_SHAFT else 0.0)
        pull_coupled(c, s)
        for x in range(g.rest.size):
            tension = g.rest[x]
            for b in range(rows):
                tension += g.raised[x, b] * s.stretched[b]
            for i in range(k):
                tension += g.tension[x, i] * s.modes[i]
            for i in range(s.held.size):
                tension += g.tension[x, k + i] * s.held[i]
            least[0] = min(least[0], tension)
        for i in range(k):
            s.force[i] += g.torque_shape[i] * torque[n]
        time = c.step if first + n > 0 else 0.5 * c.step
        kick_modes(time, s)
        rub(c, time, s)
        flow_modes(c, nothing, s)
        if history.shape[0] > 0:
            history[n, :k], history[n, k:] = s.modes[:k], s.held
        if floor > 0.0 and n % REFRESH == 0:
            for b in range(rows):
                for j in range(most):
                    size = np.sqrt(s.sines[b, j] ** 2 + (s.rates[b, j] / g.transverse[b, j]) ** 2)
                    if 0.0 < size < floor:
                        s.sines[b, j] *= floor / size
                        s.rates[b, j] *= floor / size
        if n % 2 == 0:
            for b in range(rows):
                for j in range(most):
                    size = abs(s.sines[b, j])
                    above[j] = np.copysign(max(size - floor, 0.0), s.sines[b, j])
                    if size > modal[b, j]:
                        modal[b, j] = size
                        when[b, j] = first + n
                for x in range(places.size):
                    places[x] = 0.0
                for j in range(most):
                    for x in range(places.size):
                        places[x] += g.probes[b, j, x] * above[j]
                for x in range(places.size):
                    top[b, x] = max(top[b, x], abs(places[x]) + floor)
    whole = 0.0
    for i in range(k):
        whole += s.modes[i]
    for b in range(rows):
        for j in range(most):
            whole += s.sines[b, j]
    if not np.isfinite(whole):
        least[0] = -np.inf
        top[:] = np.inf
