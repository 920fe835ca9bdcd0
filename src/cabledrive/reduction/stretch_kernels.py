"""The step of `cabledrive.reduction.stretches`: forces of the stretches, exact flow, what is shown of it."""

from cabledrive.mechanics.compiled import njit_part
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.stretches import StretchNumbers, StretchState


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
    g, k, most, strands = c.model, s.force.size, s.sines.shape[1], c.model.bend.shape[1]
    for i in range(k):
        s.force[i] = 0.0
    for b in range(s.sines.shape[0]):
        product = s.products[b]
        for m in range(product.size):
            product[m] = 0.0
        for i in range(most):
            amplitude, row = s.sines[b, i], c.table[b, i]
            if amplitude != 0.0:  # else one that only fills up the row
                for m in range(product.size):
                    product[m] += row[m] * amplitude
        for e in range(strands):
            stretched, at = 0.0, e * most
            for j in range(most):
                stretched += (g.bend[b, e, j] + 0.5 * product[at + j]) * s.sines[b, j]
                product[at + j] += g.bend[b, e, j]
            s.stretched[b * strands + e] = stretched
        for i in range(k + s.held.size):
            total, at = 0.0, (strands + i) * most
            for j in range(most):
                half = 0.5 * product[at + j]
                product[at + j] += g.direct[i, b, j]
                total += (product[at + j] - half) * s.sines[b, j]
            if i < k:
                s.force[i] -= total
    for b in range(s.sines.shape[0]):
        product = s.products[b]
        for j in range(most):
            s.stiffening[j] = 0.0
        for e in range(strands):
            carried, at = 0.0, e * most
            for d in range(s.stretched.size):
                carried += g.carried[b * strands + e, d] * s.stretched[d]
            for j in range(most):
                s.stiffening[j] += carried * product[at + j]
        for i in range(k + s.held.size):
            # the kept modes' static share is in `carried` already: their inertia is what differs
            moved = s.modes[i] - s.force[i] * g.softness[i] if i < k else s.held[i - k]
            at = (strands + i) * most
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
