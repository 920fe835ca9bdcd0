r"""The alarm: does a planned motion make transverse vibrations grow beyond a limit, how far, where?

Every longitudinal mode that the torque reaches and every transverse mode that these can excite, in both
planes of every free stretch, is integrated along the motion by Eq. (A.36): from rest, which shows the direct
excitation through sag, and with a floor below which no mode falls, which shows parametric excitation of one
mode (1:2) and of two (sum type). Small changes of the transverse frequencies and of the torque say how sure
the verdict is.

Where pretension, carriages, a load or bodies change along the motion, modes are followed from pose to pose.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from cabledrive.answers.result import Result
from cabledrive.answers.runs import ALARMED
from cabledrive.mechanics.holding import released
from cabledrive.mechanics.network import network_of
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.threshold import lost_square
from cabledrive.studies.motion_response import MOST_MODES, PreparedMotion, prepare
from cabledrive.studies.motion_stages import Extremes, interpolated
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM, near_pairs
from cabledrive.studies.planned_motion import PlannedMotion

SAFE, DANGEROUS, UNKNOWN = "safe", "dangerous", "unknown"
NONE, DIRECT, PARAMETRIC = "none", "direct", "parametric"
DETUNING = 0.002
"""Relative change of the transverse frequencies against which a verdict must hold."""
MORE_TORQUE = 1.05
"""Factor on the torque against which a verdict must hold."""
MORE_FLOOR = 1.5
"""Factor on the floor against which a verdict must hold: the phase that grows is not known."""
MARGIN = 1.15
"""Factor on the displacement: what the model may be wrong by."""
STEEPEST = 0.12
"""Largest slope of the sag for which the model's expansion about the straight span holds."""
INSTANTS = 2000
"""Instants of a motion at which its pairs are looked at."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """A longitudinal mode and the one or two transverse modes that it comes near to exciting."""

    kind: str  # {"1:2", "sum"}
    # span, plane: of the first transverse mode
    span: str
    plane: str
    # longitudinal_hz, transverse_hz: where the amplitude is the largest share of the threshold [Hz]
    longitudinal_hz: float
    transverse_hz: tuple[float, float]
    # lowest and highest longitudinal frequency minus the sum of the transverse ones [Hz]
    detuning_hz: tuple[float, float]
    passes: bool  # whether it goes through resonance
    amplitude: float  # amplitude of the longitudinal mode over its threshold, the largest along the motion
    time: float  # when [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeAlarm:
    """What a motion does to one transverse mode."""

    span: str  # {"upper", "lower"}
    section: tuple[float, float]  # ends of the free stretch at the start, unstretched [m]
    plane: str  # {"w", "v"}: in the plane of the loop, or across it
    number: int
    frequency_hz: float  # at the start, of the string under its static tension [Hz]
    driven: float  # largest amplitude by the motion alone, from rest [m]
    largest: float  # largest amplitude from rest or from the floor [m]
    time: float  # when that is reached [s]
    # {"none", "direct", "parametric"}: what makes it larger than the floor: the tension's change through the
    # slope of the sag, or through the transverse motion itself, at 1:2 or by sum type
    excitation: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class AlarmResult(Result):
    """The verdict on a motion."""

    _heading, _table, _shown = "{0.verdict}", "modes", ALARMED
    verdict: str  # {"safe", "dangerous", "unknown"}
    # floor, limit: amplitude of every transverse mode that is always there, and the largest displacement
    # allowed [m]
    floor: float
    limit: float
    largest_transverse: float  # largest transverse displacement from rest along the motion [m]
    # an estimate of the same under changes of the frequencies, the torque and the floor, with a margin [m];
    # no bound
    changed: float
    modes: tuple[ModeAlarm, ...]  # the largest first
    lowest_tension: float | None  # along the motion [N]; None: beyond all numbers
    slack: bool  # whether a span loses its tension
    reasons: tuple[str, ...]  # of the verdict
    assumptions: tuple[str, ...]  # what the verdict rests on
    remedy: str
    # pairs that come near 1:2 or sum resonance along the motion, the largest amplitude first, and
    # poses at which modes were computed
    passages: tuple[Passage, ...] = ()
    poses: int = 1


def alarm(
    drive: Machine | Drive, motion: PlannedMotion, *, floor: float = 1e-5, limit: float = 5e-4
) -> AlarmResult:
    """Whether a motion makes transverse vibrations grow from a ``floor`` beyond a ``limit`` [m]."""
    drive = drive.machine
    if not 0.0 < floor < limit:
        raise InputRefused(f"floor = {floor:.4g} m must be above 0 and below limit = {limit:.4g} m")
    prepared = prepare(released(drive), motion, floor=floor)  # as torque controllers see it
    driven = prepared.response()
    grown = prepared.response(floor=floor)
    varied = [
        prepared.response(floor=MORE_FLOOR * floor, phase=phase, detuned=detuned, torque=MORE_TORQUE)
        for phase, detuned in ((0.25 * pi, -DETUNING), (0.75 * pi, 0.0), (0.5 * pi, DETUNING))
    ]
    largest = max(float(run.displacement.max(initial=0.0)) for run in (driven, grown))
    changed = MARGIN * max(largest, *(float(run.displacement.max(initial=0.0)) for run in varied))
    if not np.isfinite(largest):
        raise NotComputed(
            "the vibration along the planned motion diverges: plan a smaller or a slower motion"
        )
    runs = prepared.response(parametric=False), driven, grown
    modes = _mode_alarms(prepared, runs, drive.spans, floor)
    found = largest, changed, min(driven.tension, grown.tension)
    answer = _answer(found, (floor, limit), modes, _doubts(drive, motion, prepared))
    return AlarmResult(
        **answer,
        assumptions=_assumptions(drive, motion, len(prepared.models)),
        passages=passages_of(prepared, drive.spans),
        poses=len(prepared.models),
    )


def _rubs(drive: Machine) -> bool:
    return network_of(drive).rubs.values.size > 0


def _doubts(drive: Machine, motion: PlannedMotion, prepared: PreparedMotion) -> list[str]:
    """Where the model's own range ends."""
    found = []
    if prepared.steepest > STEEPEST:
        found.append(
            f"the slope of the sag is {prepared.steepest:.3g} at rest; the model is valid up to {STEEPEST:g}"
        )
    if not prepared.complete:
        more = f"more than {MOST_MODES} transverse modes of a stretch"
        found.append(f"the motion can excite {more}; the others are neglected")
    if prepared.ambiguous:
        found.append(
            f"modes change too much between poses to be followed: {'; '.join(prepared.ambiguous[:3])}"
        )
    if prepared.driven and _rubs(drive):
        found.append(
            "the places of bodies follow from the torque without the file's friction: give them as columns"
        )
    return found


def _assumptions(drive: Machine, motion: PlannedMotion, poses: int) -> tuple[str, ...]:
    """What the verdict rests on."""
    found = []
    if _rubs(drive):
        found.append("Coulomb friction of the shafts: as in the drive file")
    if motion.changes:
        found.append("pretension, carriages and load torque change slowly against the transverse modes")
    elif poses > 1:
        how = "given" if motion.places else "by the torque on the rigid machine without friction"
        found.append(
            f"modes in {poses} poses, followed by their shapes and interpolated; places of bodies {how}"
        )
    return tuple(found)


def _answer(
    found: tuple[float, float, float],
    allowed: tuple[float, float],
    modes: tuple[ModeAlarm, ...],
    doubts: Sequence[str],
) -> dict[str, Any]:
    """Verdict, reasons and remedy from displacement, its estimate under changes [m] and lowest tension [N].

    ``allowed``: floor and limit [m].
    """
    (largest, changed, tension), (floor, limit) = found, allowed
    if tension < 0.0:
        doubts = ["a span goes slack along the motion; the model is not valid from there on", *doubts]
    verdict, more = DANGEROUS if largest > limit else UNKNOWN if changed > limit or doubts else SAFE, ""
    if verdict == UNKNOWN and changed > limit:
        more = f"; a change of the transverse frequencies by {DETUNING:.1%} and of the torque by "
        more += f"{MORE_TORQUE - 1.0:.0%} takes it to an estimated {1e3 * changed:.4g} mm"
    size = f"largest transverse displacement {1e3 * largest:.4g} mm, limit {1e3 * limit:.4g} mm"
    return {
        "verdict": verdict,
        "floor": floor,
        "limit": limit,
        "largest_transverse": largest,
        "changed": changed,
        "modes": modes,
        "lowest_tension": tension if np.isfinite(tension) else None,
        "slack": tension < 0.0,
        "reasons": (size + more, *doubts),
        "remedy": _remedy(verdict, modes),
    }


def _remedy(verdict: str, modes: Sequence[ModeAlarm]) -> str:
    """What would keep the largest mode small."""
    if verdict == SAFE or not modes:
        return "none needed"
    worst = modes[0]
    where = f"mode {worst.number} of span {worst.span} ({worst.frequency_hz:.4g} Hz)"
    if worst.excitation == NONE:
        return "no mode grows; what is named above is not decided"
    if worst.excitation == DIRECT:
        return f"keep the torque away from {where}: it is excited directly; or tighten the cable"
    said = f"reduce the torque's oscillation before {worst.time:.3g} s, damp the cable"
    return f"{said}, or move the pretension: {where} is excited parametrically"


def _mode_alarms(
    prepared: PreparedMotion, runs: tuple[Extremes, Extremes, Extremes], spans: Sequence[str], floor: float
) -> tuple[ModeAlarm, ...]:
    """Each mode, the largest first; ``runs``: not parametrically excited, from rest, from the floor [m]."""
    rows = [(r, j, place) for r, own in enumerate(prepared.places) for j, place in enumerate(own)]
    place = tuple(np.array([row[:2] for row in rows], dtype=int).reshape(-1, 2).T)
    amplitude, time = (np.array([getattr(run, of)[place] for run in runs]) for of in ("amplitude", "time"))
    omega = prepared.models[0].transverse[place]
    found = []
    for k, (_, _, (span, ends, plane, number)) in enumerate(rows):
        shaken, driven, grown = (float(own) for own in amplitude[:, k])
        largest = max(driven, grown)
        own = PARAMETRIC if largest > 2.0 * floor else NONE
        found.append(
            ModeAlarm(
                span=spans[span],
                section=ends,
                plane=plane,
                number=number,
                frequency_hz=float(omega[k]) / (2.0 * pi),
                driven=driven,
                largest=largest,
                time=float(time[1 if driven >= grown else 2, k]),
                excitation=DIRECT if shaken > floor and shaken > 0.5 * largest else own,
            )
        )
    return tuple(sorted(found, key=lambda mode: -mode.largest))


def passages_of(prepared: PreparedMotion, spans: tuple[str, ...]) -> tuple[Passage, ...]:
    """Every pair that comes near resonance along a motion, the largest amplitude over its threshold first."""
    time, swing = prepared.swing
    picked = np.unique(np.linspace(0, time.size - 1, INSTANTS).astype(np.intp))
    here = np.interp(time[picked], prepared.time, prepared.here)

    def at(name: str) -> Array:
        return interpolated([getattr(model, name) for model in prepared.models], here)

    natural, across, loss = at("natural"), at("transverse"), at("loss")
    found = []
    for row, places in enumerate(prepared.places):
        size = len(places)
        mass = np.array([model.mass[row, :size] for model in prepared.models])
        w, lost = across[:, row, :size], loss[:, row, :size]
        for q in np.flatnonzero(natural[0] > 0.0):
            coupled = np.abs([model.coupling[q, row, :size, :size] for model in prepared.models])
            coupled = coupled / np.sqrt(mass[:, :, None] * mass[:, None, :])
            detunings = natural[:, q, None, None] - w[:, :, None] - w[:, None, :]
            crossed = np.ptp(np.sign(detunings), axis=0) > 0.0
            off = np.abs(detunings / natural[:, q, None, None]).min(axis=0)
            for i, j in near_pairs(coupled.max(axis=0), np.where(crossed, 0.0, off)):
                detuning = detunings[:, i, j]
                least = lost_square(0.5 * lost[:, i], 0.5 * lost[:, j], detuning)
                threshold = 4.0 * np.sqrt(w[:, i] * w[:, j] * least)
                share = interpolated(coupled[:, i, j], here) * swing[picked, q]
                share = share / np.maximum(threshold, 1e-300)
                when = int(np.argmax(share))
                found.append(
                    Passage(
                        kind=ONE_TO_TWO if i == j else SUM,
                        span=spans[places[i][0]],
                        plane=places[i][2],
                        longitudinal_hz=float(natural[when, q]) / (2.0 * pi),
                        transverse_hz=(float(w[when, i]) / (2.0 * pi), float(w[when, j]) / (2.0 * pi)),
                        detuning_hz=(float(detuning.min()) / (2.0 * pi), float(detuning.max()) / (2.0 * pi)),
                        passes=bool(detuning.min() <= 0.0 <= detuning.max()),
                        amplitude=float(share[when]),
                        time=float(time[picked[when]]),
                    )
                )
    return tuple(sorted(found, key=lambda one: -one.amplitude))
