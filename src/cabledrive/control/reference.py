r"""The flat output of a chain, what a torque at its load asks for, and the reference as a law takes it.

Of inertias :math:`J_1` (motor) to :math:`J_N` (load), joined by springs :math:`k_i` with dampers :math:`b_i`,
:math:`D_i = 1 + (b_i/k_i)s`. From the load backwards, without a polynomial division:

.. math::
    R_N = 1, \quad a_N = J_N s^2, \qquad
    R_i = D_i R_{i+1} + a_{i+1}/k_i, \quad a_i = J_i s^2 R_i + D_i a_{i+1}

Then :math:`\theta_i = D_1 \cdots D_{i-1} R_i z`, link 1 carries :math:`D_1 a_2 z`, and the motor needs
:math:`J_1 s^2 R_1 z + D_1 a_2 z` besides its friction. Without dampers z is the load angle.

A torque f against the last inertia asks for a twist of the last link, that for a motion of the inertia
before, and so on to the motor. With :math:`\tau_N = f`, :math:`\delta_N = 0`, from the load backwards

.. math:: \delta_i = \delta_{i+1} + \frac{\tau_{i+1}}{k_i D_i}, \qquad
    \tau_i = \tau_{i+1} + J_i\ddot\delta_i + b_i\dot\delta_i

:math:`\delta_i` is what each angle, :math:`\tau_1` what the torque of the motor has to add; derivatives of f
up to the 2(N - 1)-th are known along the reference.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cabledrive.control.numbers import ObserverNumbers
from cabledrive.control.observers import torque_push
from cabledrive.identification.signals import lag_coefficients
from cabledrive.parameters.arrays import Array, Integers
from cabledrive.reduction.lumped_chain import LumpedChain


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlatOutput:
    """Polynomials of a chain of n inertias, coefficients of rising powers of s, all of length 2n + 1."""

    angles: Array  # (n, 2n + 1): each angle per flat output
    inertial: Array  # (2n + 1,): acceleration of the first inertia per flat output, s^2 R_1 [1/s^2]
    elastic: Array  # (2n + 1,): torque of the first link per flat output, D_1 a_2 [N m]
    time_constants: Array  # (n - 1,): b_i / k_i of the links [s]: the load is z through 1 + (b_i / k_i) s
    states: Array  # (2n, 2n): angles, then speeds, per z and its first 2n - 1 derivatives

    @property
    def size(self) -> int:
        """Number of inertias."""
        return int(self.angles.shape[0])


def flat_output(chain: LumpedChain, *, damped: bool = True) -> FlatOutput:
    """Polynomials of a lumped chain whose links join equal angles, see `reflected`.

    ``damped``: whether dampers and viscous friction beyond the motor count; printed laws leave them out.
    """
    n = chain.size
    length = 2 * n + 1
    times = np.array(chain.damping) / np.array(chain.stiffness) if damped else np.zeros(n - 1)
    rest = np.zeros(length)
    rest[0] = 1.0
    torque = _moved(rest, chain, n - 1, damped)
    carried = np.zeros(length)
    angles = np.zeros((n, length))
    angles[n - 1] = rest
    for i in range(n - 2, -1, -1):
        rest, carried = _through(rest, times[i]) + torque / chain.stiffness[i], _through(torque, times[i])
        angles[i] = rest
        torque = _moved(rest, chain, i, damped) + carried
    for i in range(1, n):
        for time in times[:i]:
            angles[i] = _through(angles[i], time)
    inertial = _shifted(rest, 2)
    states = np.zeros((2 * n, 2 * n))
    states[:n] = angles[:, : 2 * n]
    states[n:, 1:] = angles[:, : 2 * n - 1]
    return FlatOutput(angles=angles, inertial=inertial, elastic=carried, time_constants=times, states=states)


def _through(polynomial: Array, time: float) -> Array:
    """(1 + time s) polynomial."""
    return polynomial + time * _shifted(polynomial, 1)


def _shifted(polynomial: Array, power: int) -> Array:
    """s^power polynomial, cut to its length."""
    return np.concatenate((np.zeros(power), polynomial[:-power]))


def _moved(polynomial: Array, chain: LumpedChain, i: int, damped: bool) -> Array:
    """Torque that moves inertia i along the polynomial."""
    friction = chain.viscous[i] if damped else 0.0
    return chain.inertias[i] * _shifted(polynomial, 2) + friction * _shifted(polynomial, 1)


TORQUES = 3
"""Friction of Coulomb, viscous friction, inertia."""


class LoadRowNumbers(NamedTuple):
    """How columns follow from a wanted motion; without elements where a law has none."""

    sign: Array
    """(r, 2h + 1): weights that smooth the sign of the speed over samples around, and its derivatives."""
    lags: Array  # filters of the chain's dampers, as of `ReferenceNumbers`
    sources: Integers  # of these filters
    output: Array
    """(2n + 1, (l + 1) r): angles, speeds and motor torque that a torque of the load asks for, from all
    stages."""
    transition: Array
    """(states, states + 1): of the filter; the last column is what a torque of the load does between two
    samples."""
    seen: Array  # (m, states): readings from the filter's states
    gains: Array  # (samples, states, m): of the filter, of which the last one stays
    chosen: Integers  # (2n,): states of the filter that the law takes
    white: Array  # (m, m): what makes innovations white
    scalars: Array  # (2,): sample time [s]; K of tanh(K w / largest w)

    @property
    def columns(self) -> int:
        """How many columns there are."""
        return TORQUES * (len(self.chosen) + 1 + len(self.white)) if len(self.sign) else 0

    @property
    def turning(self) -> float:
        """Time over which the sign turns [s]; zero where there is none."""
        return float((self.sign.shape[1] - 1) * self.scalars[0]) if len(self.sign) else 0.0


class LoadRowState(NamedTuple):
    """What the generator keeps, and scratch."""

    window: Array  # (2h + 1,): signs about the next sample
    now: Array  # (3, r): torques now, and next
    next: Array
    memory: Array  # (3, l, r): of the filters
    stages: Array  # (l + 1, r): scratch
    error: Array  # (3, states): of the filter
    wanted: Array  # (r + 2,): scratch, as what follows
    innovation: Array  # (m,)
    fresh: Array  # (states,)


_NONE, _NOWHERE = np.zeros((0, 0)), np.zeros(0, dtype=np.int64)
NO_LOAD = LoadRowNumbers(
    _NONE, np.zeros((0, 3)), _NOWHERE, _NONE, _NONE, _NONE, np.zeros((0, 0, 0)), _NOWHERE, _NONE, np.zeros(0)
)


TURN = 400.0
"""Over the largest speed of the load: K of tanh(K w), before the sign is smoothed."""


def sign_weights(rows: int, turning: float, interval: float) -> Array:
    """Weights of the samples around, oldest first, in a smoothed sign and its derivatives, (rows, 2h + 1).

    Of averages over boxes, ``turning`` [s] all together; an even number of them shifts by whole samples.
    """
    boxes = rows + 1 + (rows + 1) % 2
    width = max(1, round(turning / (boxes * interval)))
    mean, slope = np.full(width + 1, 1.0 / width), np.zeros(width + 1)
    mean[[0, -1]] = 0.5 / width
    slope[0], slope[-1] = -1.0 / (width * interval), 1.0 / (width * interval)
    found = []
    for row in range(rows):
        weights = np.ones(1)
        for box in range(boxes):
            weights = np.convolve(weights, slope if box < row else mean)
        found.append(weights)
    return np.array(found)


def load_row_numbers(
    chain: LumpedChain, observer: ObserverNumbers, white: Array, turning: float, interval: float
) -> LoadRowNumbers:
    """Numbers of the generator; ``white``, (m, m): of innovations; ``turning``: of friction's sign [s]."""
    rows = 2 * chain.size - 1
    times, sources, output = carried_terms(chain)
    states = observer.model.shape[0]
    push = torque_push(chain, states, interval)
    asked = np.vstack((output[:-1][observer.chosen], output[-1:]))
    return LoadRowNumbers(
        sign=sign_weights(rows, turning, interval),
        lags=np.array([lag_coefficients(time, interval) for time in times]).reshape(-1, 3),
        sources=np.array(sources, dtype=np.int64),
        output=np.ascontiguousarray(asked),
        transition=np.column_stack((observer.model[:, :states], push)),
        seen=observer.output.copy(),
        gains=observer.gains.copy(),
        chosen=observer.chosen.copy(),
        white=np.ascontiguousarray(white),
        scalars=np.array([interval, TURN]),
    )


def carried_terms(chain: LumpedChain) -> tuple[list[float], list[int], Array]:
    """Times [s], sources of a torque's filters, map (2n + 1, stages (2n - 1)): what keeps the load still."""
    n, rows, stages = chain.size, 2 * chain.size - 1, 2 ** (chain.size - 1)
    times: list[float] = []
    sources: list[int] = []
    found, (link, angle) = np.zeros((2 * n + 1, stages, rows)), np.zeros((2, stages, rows))
    link[0, 0] = 1.0
    for i in range(n - 2, -1, -1):
        angle = angle.copy()
        for stage in np.flatnonzero(link.any(axis=1)).tolist():
            times.append(chain.damping[i] / chain.stiffness[i])
            sources.append(stage)
            angle[len(times)] += link[stage] / chain.stiffness[i]
        speed, acceleration = (np.pad(angle, ((0, 0), (order, 0)))[:, :rows] for order in (1, 2))
        found[i], found[n + i] = angle, speed
        link = link + chain.inertias[i] * acceleration + chain.viscous[i] * speed
    found[2 * n] = link
    return times, sources, found.reshape(2 * n + 1, -1)


AT_ONCE = ((0.0, 1.0),)


class ReferenceNumbers(NamedTuple):
    """How a row follows from the wanted load angle and its derivatives y to y^(K)."""

    taps: Array  # (t, 2): delay [s] and weight of each copy of the motion; of an input shaper two, else one
    lags: Array  # (l, 3): first-order filters, exact for lines: shares of newest and last value, fading
    sources: Integers  # (l,): stage of each filter's input: 0 is the motion, i the output of filter i - 1
    output: Array  # (columns, (l + 1) (K + 1)): the row from all stages, stage after stage
    constant: Array  # (columns,): what is added to the row
    friction: Array  # (f, 2): c [N m] and K [s/rad] of each Coulomb friction c tanh(K w), added to a column
    places: Integers  # (f, 2): that column, and the column of the speed w
    load: LoadRowNumbers = NO_LOAD  # further columns, of a law that learns the load's torque

    @property
    def columns(self) -> int:
        """Columns of a row."""
        return len(self.output) + self.load.columns

    @property
    def derivatives(self) -> int:
        """Highest derivative K of the load angle."""
        return self.output.shape[1] // (len(self.lags) + 1) - 1


class MotionNumbers(NamedTuple):
    """Pulses of the load: coefficients of a rise; angle at the first shaft [rad], rise, dwell [s], count."""

    coefficients: Array
    scalars: Array


class ReferenceState(NamedTuple):
    """What a generator keeps: rows made, what filters hold of each derivative; and scratch, by stages."""

    made: Integers
    memory: Array
    stages: Array
    load: LoadRowState


def reference_numbers(
    output: Array,
    times: Sequence[float] = (),
    interval: float = 1.0,
    *,
    sources: Sequence[int] | None = None,
    taps: Sequence[tuple[float, float]] = AT_ONCE,
    friction: Sequence[tuple[float, float, int, int]] = (),
) -> ReferenceNumbers:
    """Numbers of a generator; unless ``sources`` say else, each filter takes the one before it.

    ``output``, (columns, c): of all stages, or of the last one alone; ``times``: time constant of each filter
    [s]; ``friction``: c, K, column that it is added to, column of the speed, of each.
    """
    stages = len(times) + 1
    if sources is None:  # a series of filters, of which only the end is used
        output = np.hstack([np.zeros((len(output), (stages - 1) * output.shape[1])), output])
        sources = range(stages - 1)
    return ReferenceNumbers(
        taps=np.array(taps, dtype=float),
        lags=np.array([lag_coefficients(float(time), interval) for time in times]).reshape(-1, 3),
        sources=np.array(sources, dtype=np.int64),
        output=np.ascontiguousarray(output),
        constant=np.zeros(len(output)),
        friction=np.array([one[:2] for one in friction], dtype=float).reshape(-1, 2),
        places=np.array([one[2:] for one in friction], dtype=np.int64).reshape(-1, 2),
    )


def new_reference_state(numbers: ReferenceNumbers) -> ReferenceState:
    """A generator at rest at angle zero."""
    width, lags, load = numbers.derivatives + 1, len(numbers.lags), numbers.load
    r, taps = load.sign.shape
    held = TORQUES if r else 0
    return ReferenceState(
        made=np.zeros(1, dtype=np.int64),
        memory=np.zeros((lags, width)),
        stages=np.zeros((lags + 1, width)),
        load=LoadRowState(
            window=np.zeros(taps),
            now=np.zeros((held, r)),
            next=np.zeros((held, r)),
            memory=np.zeros((held, len(load.lags), r)),
            stages=np.zeros((len(load.lags) + 1 if r else 0, r)),
            error=np.zeros((held, len(load.transition))),
            wanted=np.zeros(r + 2 if r else 0),
            innovation=np.zeros(len(load.white)),
            fresh=np.zeros(len(load.transition)),
        ),
    )


def flat_generator(flat: FlatOutput, interval: float) -> ReferenceNumbers:
    r"""Rows (2n + 3,): :math:`z_d = y_d/(D_1 \cdots D_{n-1})`, 2n derivatives, speed, acceleration."""
    return reference_numbers(flat_map(flat).T, flat.time_constants.tolist(), interval)


def flat_map(flat: FlatOutput) -> Array:
    """The rows of `flat_generator` from each filtered derivative alone, shape (2n + 1, 2n + 3)."""
    speed = np.append(0.0, flat.angles[0, :-1])
    return np.column_stack((np.eye(2 * flat.size + 1), speed, flat.inertial))


def joint_motion(flat: FlatOutput, flat_rows: Array) -> tuple[Array, Array]:
    """Angles, then speeds, of rows of `flat_generator`, (samples, 2n), and torque of the first link [N m]."""
    n2 = 2 * flat.size
    return flat_rows[:, :n2] @ flat.states.T, flat_rows[:, : n2 + 1] @ flat.elastic
