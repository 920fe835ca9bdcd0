"""Response of cable and pulleys to a planned motion: every mode that it can excite."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, pi

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction import sagging_model as sagging
from cabledrive.reduction.sagging_model import Extremes, LongitudinalModes
from cabledrive.reduction.static_state import (
    FreeStretch,
    StaticState,
    TransverseShapes,
    free_stretches,
    static_state,
    transverse_shapes,
)
from cabledrive.reduction.stretches import StretchModel
from cabledrive.studies.planned_motion import PlannedMotion, drive_along

ALWAYS = (1, 2, 3, 4)
"""Modes of every stretch that are kept whatever the motion: they carry its slow deflection."""

LEAST_GROWTH = 0.7
"""Logarithm of the growth over the motion below which parametric excitation does not count."""

LEAST_SHARE = 0.3
"""Share of the floor below which direct excitation does not count."""

STRONG = 0.12
"""Relative oscillation of a tension from which the second instability region, at a mode's own frequency,
counts."""

UNSURE = 0.006
"""Relative error of a mode's frequency that the selection allows for: by sag, and by uneven tension."""

WIDE = 0.1
"""Share of a frequency around it whose lines act together."""

HANN = 1.5
"""Sum of the squares of the lines into which the window spreads one."""

HIGHEST = 80


def amplitudes(values: Array) -> Array:
    """Amplitudes of the sines in signals, shape (n, signals), without their means, (n // 2 + 1, signals)."""
    window = np.hanning(values.shape[0])[:, None]
    spectrum = np.fft.rfft(window * (values - values.mean(axis=0)), axis=0)
    return np.asarray(2.0 * np.abs(spectrum) / window.sum())


def excited_modes(
    drive: Drive, state: StaticState, part: FreeStretch, lines: tuple[Array, Array, float], floor: float
) -> list[int]:
    r"""Numbers of the transverse modes of a free stretch, the most endangered first behind the lowest.

    ``lines``: spectrum of the tension's oscillation over its value at rest, the largest along the cable:
    relative amplitude of each line [-] and its frequency [rad/s], shape (n,), and the motion's duration [s];
    ``floor``: amplitude below which nothing counts [m]. A tension that oscillates by :math:`\eta T` at
    :math:`\Omega` makes a mode at :math:`w = \Omega/2`, or two whose frequencies add to it, grow by up to
    :math:`\tfrac18\Omega\eta` per time, within as much in frequency; through a sag of slope :math:`\sigma` it
    shakes a mode at :math:`w = \Omega` to no more than :math:`\eta\sigma/\kappa` times :math:`\min(w/\Gamma,
    \tfrac12 wT)`.
    """
    size, omega, duration = lines
    # Amplitude of all lines near each one together: what a chirp or a band of noise has at one time.
    total = np.concatenate(([0.0], np.cumsum(size**2)))
    place = np.arange(size.size)
    reach = np.maximum((WIDE * place).astype(int), 2)
    high, low = np.minimum(place + reach + 1, place.size), np.maximum(place - reach, 0)
    around = np.sqrt((total[high] - total[low]) / HANN)
    w = (
        part.omega
        if isinstance(part, TransverseShapes)
        else np.arange(1, HIGHEST + 1) * pi / part.travel_time
    )
    blurred = 4 * pi / duration
    growth = 0.125 * omega * size * duration
    width = 0.25 * omega * around + blurred
    growth = np.where(around > STRONG, np.maximum(growth, 0.125 * omega * around * duration), growth)
    score = np.zeros(w.size)
    for first in range(3):  # with itself, with the next, with the one after that
        sums = w[: w.size - first] + w[first:]
        for a, both in enumerate(sums):
            near = np.abs(omega - both) < 2.0 * width + UNSURE * both
            best = float(np.max(growth, where=near, initial=0.0)) * (1.0 if first == 0 else 0.3)
            for one in (a, a + first):
                score[one] = max(score[one], best if best > LEAST_GROWTH else 0.0)
    loss = max(drive.cable.transverse_damping, 1e-300)
    speed = np.sqrt(float(np.max(state.tension[part.segments])) / state.mesh.density)
    steep = float(np.max(np.abs(state.slope[part.segments])))
    for a, own in enumerate(w):
        near = np.abs(omega - own) < 2.0 * blurred + 2.0 * UNSURE * own
        line = float(np.max(size, where=near, initial=0.0))
        wide = np.abs(omega - own) < 2.0 * blurred + WIDE * own
        strong = float(np.max(around, where=wide, initial=0.0))
        shaken = line * steep * speed / own * min(own / loss, 0.5 * own * duration)
        if shaken > LEAST_SHARE * floor:
            score[a] = max(score[a], 1.0 + np.log1p(shaken / floor))
        if strong > STRONG:
            score[a] = max(score[a], 0.125 * own * strong**2 * duration)
    found = [int(a) + 1 for a in np.argsort(-score) if score[a] > 0.0 and int(a) + 1 not in ALWAYS]
    return [*ALWAYS, *found]


MOST_FAMILY = 500.0
"""Content of a torque, over the lowest longitudinal frequency, up to which modes are searched for."""
KNOTS = 17
PARTS = 8
"""Places of a changing motion at which modes are computed, and steps between two of them."""

STEPS_PER_PERIOD = 16
FEWEST_STEPS, MOST_STEPS = 4, 20_000_000

MOST_MODES = 20
"""Transverse modes of a stretch that are kept."""

COARSE, SEGMENTS_PER_MODE, MOST_SEGMENTS = 60, 10, 300


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PreparedMotion:
    """A motion, and the coefficients of the model along it."""

    h: float  # step [s]
    # time, torque: (steps,): [s], and the torque above the holding torque [N m]
    time: Array
    torque: Array
    states: tuple[StaticState, ...]
    models: tuple[StretchModel, ...]  # one of each, or one at each of `KNOTS` instants
    stretches: tuple[TransverseShapes, ...]  # free ones at the first, with their kept modes
    complete: bool  # whether all transverse modes that the motion can excite are kept

    def response(
        self,
        *,
        floor: float = 0.0,
        phase: float = 0.0,
        detuned: float = 0.0,
        torque: float = 1.0,
        parametric: bool = True,
    ) -> Extremes:
        """Largest displacements along the motion; ``floor`` [m] of every mode begins at ``phase`` [rad]."""
        stages = [(model, torque * part) for model, part in self._stages(detuned, parametric)]
        return sagging.integrate(stages, self.h, floor=floor, phase=phase)[0]

    def _stages(self, detuned: float, parametric: bool) -> Iterator[tuple[StretchModel, Array]]:
        """One stage where nothing changes; else `PARTS` between neighbouring knots, coefficients between."""
        models = [model._replace(transverse=(1.0 + detuned) * model.transverse) for model in self.models]
        if not parametric:
            models = [m._replace(coupling=0.0 * m.coupling, square=0.0 * m.square) for m in models]
        if len(models) == 1:
            yield models[0], self.torque
            return
        edges = np.linspace(0, self.torque.size, (len(models) - 1) * PARTS + 1).round().astype(int)
        for piece, (start, end) in enumerate(itertools.pairwise(edges)):
            knot, share = piece // PARTS, (piece % PARTS + 0.5) / PARTS
            one, other = models[knot]._asdict(), models[knot + 1]._asdict()
            changing = one.keys() - {"followers"}
            mixed = {name: (1.0 - share) * one[name] + share * other[name] for name in changing}
            yield models[knot]._replace(**mixed), self.torque[start:end]


def prepare(drive: Drive, motion: PlannedMotion, *, floor: float = 1e-5) -> PreparedMotion:
    """State of rest and modes that a motion can excite above a ``floor`` [m], along the motion."""
    knots = np.linspace(0.0, motion.time[-1], KNOTS) if motion.changes else np.zeros(1)
    drives = [drive_along(drive, motion, t) for t in knots]
    # what hangs on a stretch takes its frequencies from those of a string
    hang = any(not carriage.guided for carriage in drive.carriage)
    first = _state(drives[0], motion, 0.0, MOST_SEGMENTS if hang else COARSE)
    parts: Sequence[FreeStretch] = free_stretches(drives[0], first)
    if hang:
        parts = transverse_shapes(drives[0], first, [range(1, HIGHEST + 1)] * len(parts))
    even = np.linspace(0.0, motion.time[-1], max(motion.time.size, 256))
    size = amplitudes(np.interp(even, motion.time, motion.torque)[:, None])[:, 0]
    total = np.cumsum(size**2)
    place = 1  # of the frequency below which 99.9 % of the torque's power lies [rad/s]
    if total[-1] > 0.0:
        place = min(int(np.searchsorted(total, 0.999 * total[-1])) + 2, total.size - 1)
    content = 2 * pi * place / float(motion.time[-1])
    lowest = float(sagging.longitudinal_modes(drives[0], first, 0.0, 2).natural.max())
    fast = content > MOST_FAMILY * lowest
    if fast:  # before so many modes are searched for
        _grid(motion, lowest)
        _grid(motion, content)
        content = MOST_FAMILY * lowest
    modes = sagging.longitudinal_modes(drives[0], first, 1.5 * content)
    h, time = _grid(motion, max(float(modes.natural[-1]), content))
    torque = _above_holding(drives[0], motion, time, [first.holding_torque])
    lines = _tensions(drives[0], first, modes, torque, h)
    chosen = [excited_modes(drives[0], first, part, lines, floor) for part in parts]
    numbers = [own[:MOST_MODES] for own in chosen]
    complete = not fast and all(len(own) <= MOST_MODES for own in chosen)
    numbers = [sorted(own) for own in numbers]
    # Modes that a whole span would have at the wave length of the shortest one.
    needed = max(
        own[-1] * drives[0].span_length / (part.ends[1] - part.ends[0])
        for part, own in zip(parts, numbers, strict=True)
    )
    segments = int(np.clip(SEGMENTS_PER_MODE * needed, COARSE, MOST_SEGMENTS))
    states = [_state(d, motion, t, segments) for d, t in zip(drives, knots, strict=True)]
    kept, made = modes.natural.size, []
    previous: LongitudinalModes | None = None
    for d, state in zip(drives, states, strict=True):
        found = sagging.longitudinal_modes(d, state, 0.0, kept)
        natural, rims, strain = found.natural[:kept], found.rims[:kept], found.strain[:kept]
        if previous is not None:  # with the signs that they had
            size = min(strain.shape[1], previous.strain.shape[1])
            same = np.sum(strain[:, :size] * previous.strain[:, :size], axis=1)
            sign = np.where((same < 0.0) & (natural > 0.0), -1.0, 1.0)[:, None]
            rims, strain = sign * rims, sign * strain
        own = LongitudinalModes(natural=natural, rims=rims, strain=strain)
        made.append(sagging.sagging_model(d, state, own, numbers))
        previous = own
    models = tuple(model for model, _ in made)
    fastest = max(float(np.max(modes.natural)), *(float(m.transverse.max()) for m in models), content)
    h, time = _grid(motion, fastest)
    return PreparedMotion(
        h=h,
        time=time,
        torque=_above_holding(drives[0], motion, time, [state.holding_torque for state in states]),
        states=tuple(states),
        models=models,
        stretches=made[0][1],
        complete=complete,
    )


def _state(drive: Drive, motion: PlannedMotion, t: float, segments: int) -> StaticState:
    load = 0.0 if motion.load_torque is None else float(np.interp(t, motion.time, motion.load_torque))
    return static_state(drive, load_torque=load, segments=segments)


def _grid(motion: PlannedMotion, fastest: float) -> tuple[float, Array]:
    per_second = fastest * STEPS_PER_PERIOD / (2 * pi)
    wanted = float(ceil(motion.time[-1] * per_second))
    if not FEWEST_STEPS <= wanted <= MOST_STEPS:
        raise InputRefused(
            f"motion: lasts {motion.time[-1]:.4g} s, which takes {wanted:.3g} steps; it is judged from "
            f"{FEWEST_STEPS / per_second:.3g} s to {MOST_STEPS / per_second:.4g} s: plan one of that length"
        )
    h = float(motion.time[-1]) / int(wanted)
    return h, h * np.arange(int(wanted), dtype=np.float64)


def _above_holding(drive: Drive, motion: PlannedMotion, time: Array, holding: list[float]) -> Array:
    offset = drive.motor.offset_torque if drive.motor is not None else 0.0
    knots = np.linspace(0.0, motion.time[-1], max(len(holding), 2))
    held = np.interp(time, knots, np.broadcast_to(holding, knots.size))
    return np.interp(time, motion.time, motion.torque) + offset - held


def _tensions(
    drive: Drive, state: StaticState, modes: LongitudinalModes, torque: Array, h: float
) -> tuple[Array, Array, float]:
    """Lines of `excited_modes` along the motion, the transverse modes left out."""
    still, _ = sagging.sagging_model(drive, state, modes, [[1]] * len(free_stretches(drive, state)))
    still = still._replace(direct=0.0 * still.direct)  # nothing else begins to move them
    _, history_rows = sagging.integrate([(still, torque)], h, history=True)
    every = max(1, history_rows.shape[0] // 2**16)
    relative = (history_rows @ (still.tension.T / np.maximum(still.rest, 1e-300)))[::every]
    duration = h * torque.size
    size = amplitudes(relative).max(axis=1)
    return size, 2 * pi * np.arange(size.size) / duration, duration
