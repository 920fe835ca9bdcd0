"""Runs of the model of stretches: one that is recorded, one for its extremes, many at once."""

import numpy as np

from cabledrive.mechanics.compiled import njit, njit_inner, njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.stretch_kernels import (
    cable_tension,
    flow_modes,
    kick_modes,
    pull_coupled,
    pull_sines,
)
from cabledrive.reduction.stretches import StretchNumbers, StretchState

SWEEPS = 12
"""Passes over the impulses of friction."""

REFRESH = 8
"""Steps between two looks at the floor."""


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
    """Coulomb friction over a time [s]: impulses to keep what rubs where it is over a step."""
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
    """Move full rows along torques above the holding ones at each step, (n, i); ``first``: steps before.

    No amplitude of a mode across falls below ``floor`` [m]. ``kept``: largest displacement at the probes
    (b, points), what the floor adds taken off mode by mode; largest amplitude of each mode and its step
    (b, m); lowest watched tension (1,); amplitudes along and followers after every step (n, k + f), or none.
    """
    g, k, (rows, most), (top, modal, when, least, history) = c.model, s.force.size, s.sines.shape, kept
    motors = torque.shape[1]
    nothing, above, places = np.empty(0), np.zeros(most), np.zeros(top.shape[1])
    for n in range(torque.shape[0]):
        for i in range(s.held.size):
            s.held[i] = torque[n, i] if i < motors else s.rubbed[i - motors]
        pull_coupled(c, s)
        for x in range(g.rest.size):
            tension = g.rest[x]
            for b in range(s.stretched.size):
                tension += g.raised[x, b] * s.stretched[b]
            for i in range(k):
                tension += g.tension[x, i] * s.modes[i]
            for i in range(s.held.size):
                tension += g.tension[x, k + i] * s.held[i]
            least[0] = min(least[0], tension)
        for m in range(motors):
            for i in range(k):
                s.force[i] += g.torque_shape[i, m] * torque[n, m]
        for f in range(s.held.size):
            for b in range(rows):
                for j in range(most):
                    s.pull[b, j] += g.shoved[b, j, f] * s.held[f] * c.per_mass[b, j]
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


@njit_inner
def weighted_sum(weights: Array, parts: Array, start: float, out: Array) -> None:
    """The same sum of the first rows of an array in every lane, shape (lanes,)."""
    for i in range(out.size):
        out[i] = start
    for j in range(weights.size):
        for i in range(out.size):
            out[i] += weights[j] * parts[j, i]


@njit
def ensemble_run(
    c: StretchNumbers, start: Array, waves: tuple[Array, Array, float], stride: int
) -> tuple[Array, Array, Array, Array, Array]:
    """Many motions of one model from plucks at rest, shape (b, m, lanes), by (R.4), where rows do not bend.

    ``waves``: torque of amplitude one at the ends of the steps, amplitude of each lane [N m], what is added
    to all [N m]. Returns the motions shown (records, o, lanes) and first watched points (records, b, lanes),
    every ``stride`` steps; of all steps the largest motions (o, lanes), the largest sums of amplitudes
    (b, lanes) and the lowest tensions (x, lanes).
    """
    g, (wave, gain, offset), (rows, most, lanes) = c.model, waves, start.shape
    k, steps = g.natural.size, wave.size - 1
    modes, fresh, stretched = np.zeros((2 * k, lanes)), np.zeros((2 * k, lanes)), np.zeros((rows, lanes))
    sines, rates = start.copy(), np.zeros(start.shape)
    value, size = np.zeros(lanes), np.zeros(lanes)
    shown = np.empty((steps // stride + 1, g.motions.shape[0], lanes))
    middle = np.empty((steps // stride + 1, rows, lanes))
    largest, reach = np.zeros((g.motions.shape[0], lanes)), np.zeros((rows, lanes))
    least = np.full((g.rest.size, lanes), np.inf)
    for n in range(steps + 1):
        time = 0.5 * c.step if n == 0 or n == steps else c.step
        for b in range(rows):
            for i in range(lanes):
                stretched[b, i], size[i] = 0.0, 0.0
            for m in range(most):
                for i in range(lanes):
                    stretched[b, i] += 0.5 * g.square[b, m] * sines[b, m, i] * sines[b, m, i]
                    size[i] += abs(sines[b, m, i])
            for i in range(lanes):
                reach[b, i] = max(reach[b, i], size[i])
        for x in range(g.rest.size):
            weighted_sum(g.tension[x], modes, g.rest[x], value)
            weighted_sum(g.raised[x], stretched, 0.0, size)
            for i in range(lanes):
                least[x, i] = min(least[x, i], value[i] + size[i])
        for o in range(g.motions.shape[0]):
            weighted_sum(g.motions[o], modes, 0.0, value)
            for i in range(lanes):
                largest[o, i] = max(largest[o, i], abs(value[i]))
                if n % stride == 0:
                    shown[n // stride, o, i] = value[i]
        if n % stride == 0:
            for b in range(rows):
                weighted_sum(g.probes[b, :, 0], sines[b], 0.0, middle[n // stride, b])
        for j in range(k):
            for i in range(lanes):
                modes[k + j, i] += time * g.torque_shape[j] * (gain[i] * wave[n] + offset)
        for b in range(rows):
            weighted_sum(g.carried[b], stretched, 0.0, size)
            for m in range(most):
                for i in range(lanes):
                    value[i] = g.square[b, m] * size[i]
                for j in range(k):
                    coupling, pumped = g.coupling[j, b, m], 0.5 * time * g.coupling[j, b, m]
                    for i in range(lanes):
                        value[i] += coupling * modes[j, i]
                        modes[k + j, i] -= pumped * sines[b, m, i] * sines[b, m, i]
                for i in range(lanes):
                    a, v = sines[b, m, i], rates[b, m, i]
                    v -= time * c.per_mass[b, m] * value[i] * a
                    a -= g.sag[b, m]
                    sines[b, m, i] = g.sag[b, m] + c.across[0, b, m] * a + c.across[1, b, m] * v
                    rates[b, m, i] = c.across[2, b, m] * a + c.across[3, b, m] * v
        for j in range(2 * k):
            weighted_sum(c.along[j], modes, 0.0, fresh[j])
        modes, fresh = fresh, modes
    return shown, middle, largest, reach, least
