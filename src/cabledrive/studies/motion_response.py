"""The response of cable and pulleys to a planned motion: every mode that it can excite, from rest or a floor."""

from dataclasses import dataclass, replace
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.sagging_model import LongitudinalModes, SaggingModel, longitudinal_modes, sagging_model
from cabledrive.reduction.sagging_motion import Extremes, SaggingNumbers, integrate, numbers_of
from cabledrive.reduction.static_state import StaticState, static_state
from cabledrive.reduction.transverse_shapes import free_stretches, modes_below
from cabledrive.studies.planned_motion import PlannedMotion, drive_along

Array = NDArray[np.float64]

KNOTS = 17
PARTS = 8
"""Places of a changing motion at which modes are computed, and steps between two of them."""

STEPS_PER_PERIOD = 16
FEWEST_STEPS, MOST_STEPS = 4, 20_000_000

LEAST_GROWTH = 1.0
"""Logarithm of the growth over the whole motion below which parametric excitation does not count."""

STRONG = 0.2
"""Relative oscillation of a tension from which the second instability region, at a mode's own frequency, counts."""

LEAST_SHARE = 0.3
"""Share of the floor below which direct excitation does not count."""

REACH = 1.1
MOST_MODES = 40
COARSE, SEGMENTS_PER_MODE, MOST_SEGMENTS = 60, 10, 400


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PreparedMotion:
    """A motion, and the coefficients of Eq. (A.36) along it.

    Attributes
    ----------
    h : float
        Step [s].
    time, torque : ndarray, shape (steps,)
        [s], and the torque above the holding torque [N m].
    states : tuple of StaticState
    models : tuple of SaggingModel
        One of each, or one at each of `KNOTS` instants.
    complete : bool
        Whether all transverse modes that the motion can excite are kept.
    top : float
        Frequency up to which they were asked for [rad/s].
    """

    h: float
    time: Array
    torque: Array
    states: tuple[StaticState, ...]
    models: tuple[SaggingModel, ...]
    complete: bool
    top: float

    def response(
        self, *, floor: float = 0.0, phase: float = 0.0, detuned: float = 0.0, torque: float = 1.0
    ) -> Extremes:
        """Largest displacements along the motion.

        Parameters
        ----------
        floor : float, default 0.0
            Amplitude below which no transverse mode falls [m].
        phase : float, default 0.0
            Phase at which that amplitude begins [rad].
        detuned : float, default 0.0
            Relative change of all transverse frequencies.
        torque : float, default 1.0
            Factor on the torque above the holding torque.

        Returns
        -------
        Extremes
        """
        stages = [(numbers, torque * part) for numbers, part in _stages(self, detuned)]
        return integrate(stages, self.h, floor=floor, phase=phase)[0]


def prepare(drive: Drive, motion: PlannedMotion, *, floor: float = 1e-5) -> PreparedMotion:
    """Compute the state of rest and the modes that a motion can excite, along the motion where they change.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion
    floor : float, default 1e-5
        Amplitude below which nothing counts [m].

    Returns
    -------
    PreparedMotion

    Raises
    ------
    InputRefused
        If the motion is too short or too long to be integrated along.
    NotComputed
        If no equilibrium is found.
    """
    knots = np.linspace(0.0, motion.time[-1], KNOTS) if motion.changes else np.zeros(1)
    drives = [drive_along(drive, motion, t) for t in knots]
    first = _state(drives[0], motion, 0.0, COARSE)
    content = _content(motion)
    modes = longitudinal_modes(drives[0], first, 1.5 * content)
    h, time = _grid(motion, max(float(modes.natural[-1]), content))
    torque = _above_holding(drives[0], motion, time, [first.holding_torque])
    top = _highest_excited(drives[0], first, modes, torque, h, floor)
    counts = [max(2, modes_below(part, top)) for part in free_stretches(drives[0], first)]
    complete = max(counts) <= MOST_MODES
    counts = [min(count, MOST_MODES) for count in counts]
    segments = int(np.clip(SEGMENTS_PER_MODE * _needed(drives[0], first, counts), COARSE, MOST_SEGMENTS))
    states = [_state(d, motion, t, segments) for d, t in zip(drives, knots, strict=True)]
    kept, models = modes.natural.size, []
    previous = None
    for d, state in zip(drives, states, strict=True):
        own = _continued(longitudinal_modes(d, state, 0.0, kept), kept, previous)
        models.append(sagging_model(d, state, own, counts))
        previous = own
    fastest = max(float(np.max(modes.natural)), *(float(m.transverse.max()) for m in models), content)
    h, time = _grid(motion, fastest)
    return PreparedMotion(
        h=h,
        time=time,
        torque=_above_holding(drives[0], motion, time, [state.holding_torque for state in states]),
        states=tuple(states),
        models=tuple(models),
        complete=complete,
        top=top,
    )


def _state(drive: Drive, motion: PlannedMotion, t: float, segments: int) -> StaticState:
    load = 0.0 if motion.load_torque is None else float(np.interp(t, motion.time, motion.load_torque))
    return static_state(drive, load_torque=load, segments=segments)


def _needed(drive: Drive, state: StaticState, counts: list[int]) -> float:
    """Modes that a whole span would have at the wave length of the shortest one."""
    parts = free_stretches(drive, state)
    return max(
        count * drive.span_length / (part.ends[1] - part.ends[0])
        for part, count in zip(parts, counts, strict=True)
    )


def _grid(motion: PlannedMotion, fastest: float) -> tuple[float, Array]:
    per_second = fastest * STEPS_PER_PERIOD / (2 * pi)
    wanted = float(ceil(motion.time[-1] * per_second))
    if not FEWEST_STEPS <= wanted <= MOST_STEPS:
        raise InputRefused(
            f"motion: lasts {motion.time[-1]:.4g} s, which takes {wanted:.3g} steps; it is judged from "
            f"{FEWEST_STEPS / per_second:.3g} s to {MOST_STEPS / per_second:.4g} s: plan one of that length"
        )
    h = float(motion.time[-1]) / int(wanted)
    return h, h * np.arange(int(wanted))


def _above_holding(drive: Drive, motion: PlannedMotion, time: Array, holding: list[float]) -> Array:
    offset = drive.motor.offset_torque if drive.motor is not None else 0.0
    held = np.interp(time, np.linspace(0.0, motion.time[-1], max(len(holding), 2)), np.broadcast_to(holding, max(len(holding), 2)))
    return np.interp(time, motion.time, motion.torque) + offset - held


def _content(motion: PlannedMotion) -> float:
    """Frequency below which 99.9 % of the torque's power lies [rad/s]."""
    even = np.linspace(0.0, motion.time[-1], max(motion.time.size, 256))
    size = _amplitudes(np.interp(even, motion.time, motion.torque)[:, None])[:, 0]
    total = np.cumsum(size**2)
    if total[-1] <= 0.0:
        return 2 * pi / float(motion.time[-1])
    place = min(int(np.searchsorted(total, 0.999 * total[-1])) + 2, total.size - 1)
    return 2 * pi * place / float(motion.time[-1])


def _amplitudes(values: Array) -> Array:
    """Amplitude of the sines in some signals, shape (frequencies, signals), mean removed."""
    window = np.hanning(values.shape[0])[:, None]
    spectrum = np.fft.rfft(window * (values - values.mean(axis=0)), axis=0)
    return np.asarray(2.0 * np.abs(spectrum) / window.sum())


def _highest_excited(
    drive: Drive, state: StaticState, modes: LongitudinalModes, torque: Array, h: float, floor: float
) -> float:
    r"""Frequency up to which transverse modes can be excited, transverse back-action left out [rad/s].

    A tension that oscillates by :math:`\eta T` at :math:`\Omega` makes a mode at :math:`w = \Omega/2` grow by
    :math:`\tfrac14 w\eta - \tfrac12\Gamma` per time, and shakes a mode at :math:`w = \Omega`, through a sag of
    slope :math:`\sigma`, to no more than :math:`\eta\sigma/\kappa` times :math:`\min(w/\Gamma, \tfrac12 wT)`.
    """
    parts = free_stretches(drive, state)
    still = sagging_model(drive, state, modes, [1] * len(parts))
    still = replace(still, direct=0.0 * still.direct, coupling=0.0 * still.coupling, carried=0.0)
    numbers = numbers_of(still, state, h)
    _, told = integrate([(numbers, torque)], h, history=True)
    every = max(1, told.shape[0] // 2**16)
    relative = (told @ (numbers.watched / np.maximum(numbers.rest, 1e-300)))[::every]
    size = _amplitudes(relative).max(axis=1)
    omega = 2 * pi * np.arange(size.size) / (h * torque.size)
    duration, loss = h * torque.size, drive.cable.transverse_damping
    lowest = pi / max(part.travel_time for part in parts)
    growth = (0.125 * omega * size - 0.5 * loss) * duration
    speed = np.sqrt(float(np.max(state.tension)) / state.mesh.density)
    lasting = np.minimum(omega / max(loss, 1e-300), 0.5 * omega * duration)
    shaken = size * state.steepest * speed / np.maximum(omega, 1e-300) * lasting
    second = np.max(omega, where=size > STRONG, initial=lowest)
    half = 0.5 * np.max(omega, where=growth > LEAST_GROWTH, initial=lowest) + 2.0 * lowest
    direct = np.max(omega, where=shaken > LEAST_SHARE * floor, initial=lowest)
    return REACH * float(max(second, half, direct))


def _continued(
    modes: LongitudinalModes, kept: int, previous: LongitudinalModes | None
) -> LongitudinalModes:
    """As many modes as before, with the signs that they had."""
    natural, rims, strain = modes.natural[:kept], modes.rims[:kept], modes.strain[:kept]
    if previous is None:
        return LongitudinalModes(natural=natural, rims=rims, strain=strain)
    size = min(strain.shape[1], previous.strain.shape[1])
    same = np.sum(strain[:, :size] * previous.strain[:, :size], axis=1)
    sign = np.where((same < 0.0) & (natural > 0.0), -1.0, 1.0)[:, None]
    return LongitudinalModes(natural=natural, rims=sign * rims, strain=sign * strain)


def _stages(motion: PreparedMotion, detuned: float) -> list[tuple[SaggingNumbers, Array]]:
    """One stage where nothing changes; else `PARTS` between neighbouring knots, coefficients in between."""
    numbers = [numbers_of(m, s, motion.h, detuned) for m, s in zip(motion.models, motion.states, strict=True)]
    if len(numbers) == 1:
        return [(numbers[0], motion.torque)]
    pieces = (len(numbers) - 1) * PARTS
    edges = np.linspace(0, motion.torque.size, pieces + 1).round().astype(int)
    stages = []
    for piece, (start, end) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        knot, share = piece // PARTS, (piece % PARTS + 0.5) / PARTS
        stages.append((_between(numbers[knot], numbers[knot + 1], share), motion.torque[start:end]))
    return stages


def _between(one: SaggingNumbers, other: SaggingNumbers, share: float) -> SaggingNumbers:
    pairs = zip(one, other, strict=True)
    return SaggingNumbers(
        *(a if a is one.count else np.ascontiguousarray((1.0 - share) * a + share * b) if np.ndim(a) else
          float((1.0 - share) * a + share * b) for a, b in pairs)
    )
