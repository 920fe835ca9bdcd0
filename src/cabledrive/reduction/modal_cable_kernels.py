"""A distributed cable in modes, a sample at a time: exact linear flow, nonlinear kicks."""

from typing import NamedTuple

import numpy as np

from cabledrive.mechanics.compiled import njit_part
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
    """Amplitudes then rates (2k,), sines and their rates (s, m); whether the model holds (1,); scratch."""

    modes: Array
    sines: Array
    rates: Array
    holds: Integers
    fresh: Array
    force: Array


def new_modal_cable_state(numbers: ModalCableNumbers) -> ModalCableState:
    """A cable at rest and straight."""
    size, shape = len(numbers.along), numbers.sag.shape
    return ModalCableState(
        modes=np.zeros(size),
        sines=np.zeros(shape),
        rates=np.zeros(shape),
        holds=np.zeros(1, dtype=np.int64),
        fresh=np.zeros(size),
        force=np.zeros(size // 2),
    )


@njit_part
def start_cable(plucks: Array, s: ModalCableState) -> None:
    """Pluck each span by the half sine, shape (s,) [m]; everything else at rest."""
    s.holds[0] = 1
    for j in range(plucks.size):
        s.sines[j, 0] = plucks[j]


@njit_part
def kick_modes(numbers: ModalCableNumbers, time: float, s: ModalCableState) -> None:
    """What modes and sines do to each other over a time [s], as in `uniform_tension_model`."""
    k = s.force.size
    for i in range(k):
        s.force[i] = 0.0
    for j in range(numbers.coupling.shape[1]):
        stretched = 0.0
        for m in range(numbers.coupling.shape[2]):
            stretched += numbers.stretching[m] * s.sines[j, m] * s.sines[j, m]
        for m in range(numbers.coupling.shape[2]):
            a = s.sines[j, m]
            stiffening = stretched * numbers.carried[m]
            for i in range(k):
                g = numbers.coupling[i, j, m]
                stiffening += numbers.factors[0] * s.modes[i] * g
                s.force[i] -= g * a * a
            s.rates[j, m] -= time * stiffening * a
    for i in range(k):
        s.modes[k + i] += time * s.force[i]


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
    for j in range(numbers.sag.shape[0]):
        for m in range(numbers.sag.shape[1]):
            x, v = s.sines[j, m] - numbers.sag[j, m], s.rates[j, m]
            s.sines[j, m] = numbers.sag[j, m] + numbers.across[0, m] * x + numbers.across[1, m] * v
            s.rates[j, m] = numbers.across[2, m] * x + numbers.across[3, m] * v


@njit_part
def cable_tension(numbers: ModalCableNumbers, s: ModalCableState, tensions: Array) -> None:
    """Tension of each span now, shape (s,) [N]; notes where a span is slack or too steep for the model."""
    for j in range(tensions.size):
        value = numbers.rest[j]
        for i in range(s.force.size):
            value += numbers.tension[j, i] * s.modes[i]
        slope = 0.0
        for m in range(numbers.sag.shape[1]):
            a = s.sines[j, m]
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
            value += numbers.middle[m] * s.sines[j, m]
        middles[j] = value


@njit_part
def cable_step(numbers: ModalCableNumbers, s: ModalCableState, inputs: Array, tensions: Array) -> None:
    """One sample under held inputs, shape (i,) [N], [N m], by (R.4); writes the tensions at its end."""
    kick_modes(numbers, 0.5 * numbers.step, s)
    for n in range(numbers.steps):
        flow_modes(numbers, inputs, s)
        kick_modes(numbers, numbers.step if n < numbers.steps - 1 else 0.5 * numbers.step, s)
        cable_tension(numbers, s, tensions)
