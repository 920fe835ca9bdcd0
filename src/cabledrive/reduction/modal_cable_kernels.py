"""A distributed cable in modes, a sample at a time: exact linear flow, nonlinear kicks."""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.compiled import njit, njit_part
from cabledrive.parameters.arrays import Array, Integers


class ModalCableNumbers(NamedTuple):
    """Frozen numbers of k modes along, m sines across each of s spans (none: m = 0), i inputs, o motions."""

    steps: int  # steps in a sample
    step: float  # length of a step [s]
    along: Array  # (2k, 2k): exact flow of the modes over a step, amplitudes then rates
    push: Array  # (2k, i): what inputs that are held over a step add to them
    across: Array  # (4, m): exact flow of the sines: x from x, x from v, v from x, v from v
    sag: Array  # (s, m): about which the sines vibrate [m]
    coupling: Array  # (k, s, m): G of (R.3)
    carried: Array  # (m,): of each sine: stiffening per S
    stretching: Array  # (m,): S per squared amplitude
    wave_numbers: Array  # (m,) [1/m]
    middle: Array  # (m,): displacement at midspan
    factors: Array  # (3,): 2 / m_t [1/kg]; tension per S [N/m]; largest slope for which the model holds
    motions: Array  # (o, k): motions shown per modal amplitude
    rest: Array  # (s,): tension of each span at rest [N]
    tension: Array  # (s, k): tension of each span per modal amplitude


class ModalCableState(NamedTuple):
    """Amplitudes then rates (2k,); sines, their rates and accelerations (planes, s, m), plane w first.

    ``holds`` (1,): whether the model holds; what follows is scratch.
    """

    modes: Array
    sines: Array
    rates: Array
    pull: Array
    holds: Integers
    fresh: Array
    force: Array
    stiffening: Array


def new_modal_cable_state(numbers: ModalCableNumbers, planes: int = 1) -> ModalCableState:
    """A cable at rest and straight."""
    size, shape = len(numbers.along), (planes, *numbers.sag.shape)
    return ModalCableState(
        modes=np.zeros(size),
        sines=np.zeros(shape),
        rates=np.zeros(shape),
        pull=np.zeros(shape),
        holds=np.zeros(1, dtype=np.int64),
        fresh=np.zeros(size),
        force=np.zeros(size // 2),
        stiffening=np.zeros(shape[2]),
    )


@njit_part
def start_cable(plucks: Array, s: ModalCableState) -> None:
    """Pluck each span by the half sine, shape (s,) [m]; everything else at rest."""
    s.holds[0] = 1
    for j in range(plucks.size):
        s.sines[0, j, 0] = plucks[j]


@njit_part
def pull_modes(numbers: ModalCableNumbers, s: ModalCableState) -> None:
    """Accelerations that modes and sines give each other, as in `uniform_tension_model`."""
    k = s.force.size
    for i in range(k):
        s.force[i] = 0.0
    for j in range(numbers.coupling.shape[1]):
        stretched = 0.0
        for p in range(s.sines.shape[0]):
            for m in range(numbers.coupling.shape[2]):
                stretched += numbers.stretching[m] * s.sines[p, j, m] * s.sines[p, j, m]
        for m in range(numbers.coupling.shape[2]):
            s.stiffening[m] = stretched * numbers.carried[m]
        for i in range(k):
            pumped, drive = 0.0, numbers.factors[0] * s.modes[i]
            for m in range(numbers.coupling.shape[2]):
                s.stiffening[m] += drive * numbers.coupling[i, j, m]
            for p in range(s.sines.shape[0]):
                for m in range(numbers.coupling.shape[2]):
                    pumped += numbers.coupling[i, j, m] * s.sines[p, j, m] * s.sines[p, j, m]
            s.force[i] -= pumped
        for p in range(s.sines.shape[0]):
            for m in range(numbers.coupling.shape[2]):
                s.pull[p, j, m] = -s.stiffening[m] * s.sines[p, j, m]


@njit_part
def kick_modes(time: float, s: ModalCableState) -> None:
    """Rates after a time [s] under the accelerations last found."""
    for i in range(s.force.size):
        s.modes[s.force.size + i] += time * s.force[i]
    for p in range(s.sines.shape[0]):
        for j in range(s.sines.shape[1]):
            for m in range(s.sines.shape[2]):
                s.rates[p, j, m] += time * s.pull[p, j, m]


@njit_part
def flow_modes(numbers: ModalCableNumbers, inputs: Array, s: ModalCableState) -> None:
    """The damped linear motion over one step, exact for inputs that are held."""
    for i in range(s.modes.size):
        value = 0.0
        for j in range(s.modes.size):
            value += numbers.along[i, j] * s.modes[j]
        for j in range(inputs.size):
            value += numbers.push[i, j] * inputs[j]
        s.fresh[i] = value
    for i in range(s.modes.size):
        s.modes[i] = s.fresh[i]
    for p in range(s.sines.shape[0]):
        for j in range(s.sines.shape[1]):
            for m in range(s.sines.shape[2]):
                sag = numbers.sag[j, m] if p == 0 else 0.0
                x, v = s.sines[p, j, m] - sag, s.rates[p, j, m]
                s.sines[p, j, m] = sag + numbers.across[0, m] * x + numbers.across[1, m] * v
                s.rates[p, j, m] = numbers.across[2, m] * x + numbers.across[3, m] * v


@njit_part
def cable_tension(numbers: ModalCableNumbers, s: ModalCableState, tensions: Array) -> None:
    """Tension of each span now, shape (s,) [N]; notes where a span is slack or too steep for the model."""
    for j in range(tensions.size):
        value = numbers.rest[j]
        for i in range(s.force.size):
            value += numbers.tension[j, i] * s.modes[i]
        slope = 0.0
        for p in range(s.sines.shape[0]):
            for m in range(s.sines.shape[2]):
                a = s.sines[p, j, m]
                value += numbers.factors[1] * numbers.stretching[m] * a * a
                slope += numbers.wave_numbers[m] * abs(a)
        tensions[j] = value
        if not (value > 0.0 and slope <= numbers.factors[2]):
            s.holds[0] = 0


@njit_part
def cable_motion(numbers: ModalCableNumbers, s: ModalCableState, places: Array, speeds: Array) -> None:
    """Motions shown and their rates now, shape (o,)."""
    for i in range(places.size):
        place, speed = 0.0, 0.0
        for j in range(s.force.size):
            place += numbers.motions[i, j] * s.modes[j]
            speed += numbers.motions[i, j] * s.modes[s.force.size + j]
        places[i] = place
        speeds[i] = speed


@njit_part
def cable_middle(numbers: ModalCableNumbers, s: ModalCableState, middles: Array) -> None:
    """Displacement of the middle of each span across it, shape (s,) [m]."""
    for j in range(middles.size):
        value = 0.0
        for m in range(numbers.sag.shape[1]):
            value += numbers.middle[m] * s.sines[0, j, m]
        middles[j] = value


@njit_part
def cable_step(numbers: ModalCableNumbers, s: ModalCableState, inputs: Array, tensions: Array) -> None:
    """One sample under held inputs, shape (i,) [N], [N m], by (R.4); writes the tensions at its end."""
    pull_modes(numbers, s)
    kick_modes(0.5 * numbers.step, s)
    for n in range(numbers.steps):
        flow_modes(numbers, inputs, s)
        pull_modes(numbers, s)
        kick_modes(numbers.step if n < numbers.steps - 1 else 0.5 * numbers.step, s)
        cable_tension(numbers, s, tensions)


@njit
def integration_kernel(
    numbers: ModalCableNumbers,
    torque_shape: Array,
    losses: tuple[Array, float],
    s: ModalCableState,
    torque: Array,
    stride: int,
) -> tuple[Array, Array, Array, Array]:
    """The motion under a torque given at the ends of the steps, by (R.4); recorded every ``stride`` steps.

    ``torque_shape`` (k,): modal force per torque; ``losses``: damping along (k, k) and per rate across, of
    the powers lost. Returns what `cabledrive.reduction.uniform_tension.IntegratedMotion` holds.
    """
    steps, k, (planes, spans, sines) = torque.size - 1, s.force.size, s.sines.shape
    records = steps // stride + 1
    along, across = np.empty((records, 2, k)), np.empty((records, 2, planes, spans, sines))
    tallies, tally, power = np.empty((records, 3)), np.zeros(3), np.zeros(3)
    peaks, tensions, nothing = np.zeros((spans, 2)), np.empty(spans), np.empty(0)
    peaks[:, 0] = np.inf
    for n in range(steps + 1):
        half = 0.0 if n == 0 else 0.5 * numbers.step
        rest = 0.0 if n == steps else 0.5 * numbers.step
        pull_modes(numbers, s)
        cable_tension(numbers, s, tensions)
        for j in range(spans):
            peaks[j, 0] = min(peaks[j, 0], tensions[j])
            reach = 0.0
            for p in range(planes):
                largest = 0.0
                for m in range(sines):
                    largest += abs(s.sines[p, j, m])
                reach += largest**2
            peaks[j, 1] = max(peaks[j, 1], np.sqrt(reach))
        for i in range(k):
            s.force[i] += torque_shape[i] * torque[n]
        kick_modes(half, s)
        power[:] = 0.0
        for i in range(k):
            power[0] += torque[n] * torque_shape[i] * s.modes[k + i]
            for j in range(k):
                power[2] += s.modes[k + i] * losses[0][i, j] * s.modes[k + j]
        for p in range(planes):
            for j in range(spans):
                for m in range(sines):
                    power[1] += losses[1] * s.rates[p, j, m] ** 2
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
            flow_modes(numbers, nothing, s)
    return along, across, tallies, peaks
