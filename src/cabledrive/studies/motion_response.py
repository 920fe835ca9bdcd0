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
SHARE = 0.999
"""Share of the power of the tension's oscillation that lies below the highest transverse mode kept."""

REACH = 1.1
MOST_MODES = 24
COARSE, SEGMENTS_PER_MODE, MOST_SEGMENTS = 60, 12, 240


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


def prepare(drive: Drive, motion: PlannedMotion) -> PreparedMotion:
    """Compute the state of rest and the modes that a motion can excite, along the motion where they change.

    Parameters
    ----------
    drive : Drive
    motion : PlannedMotion

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
    content = _content(motion.torque, motion.time)
    modes = longitudinal_modes(drives[0], first, 1.5 * content)
    h, time = _grid(motion, max(float(modes.natural[-1]), content))
    torque = _above_holding(drives[0], motion, time, [first.holding_torque])
    top = REACH * _response_content(drives[0], first, modes, torque, h)
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


def _content(signal: Array, time: Array) -> float:
    """Frequency below which nearly all of a signal's power lies [rad/s]."""
    even = np.linspace(0.0, time[-1], max(time.size, 256))
    values = np.interp(even, time, signal)
    return _below(values[:, None], even[1])


def _below(values: Array, step: float) -> float:
    """Frequency below which `SHARE` of the power of some signals, mean removed, lies [rad/s]."""
    n = values.shape[0]
    window = np.hanning(n)[:, None]
    power = np.sum(np.abs(np.fft.rfft(window * (values - values.mean(axis=0)), axis=0)) ** 2, axis=1)
    total = np.cumsum(power)
    if total[-1] <= 0.0:
        return 2 * pi / (n * step)
    place = min(int(np.searchsorted(total, SHARE * total[-1])) + 2, total.size - 1)
    return 2 * pi * place / (n * step)


def _response_content(
    drive: Drive, state: StaticState, modes: LongitudinalModes, torque: Array, h: float
) -> float:
    """Frequency below which the tension oscillates, transverse modes left out [rad/s]."""
    still = sagging_model(drive, state, modes, [1] * len(free_stretches(drive, state)))
    still = replace(still, direct=0.0 * still.direct, coupling=0.0 * still.coupling, carried=0.0)
    numbers = numbers_of(still, state, h)
    _, told = integrate([(numbers, torque)], h, history=True)
    every = max(1, told.shape[0] // 2**17)
    return _below((told @ numbers.watched)[::every], h * every)


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
