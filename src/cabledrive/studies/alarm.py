r"""The alarm: does a planned motion make transverse vibrations grow beyond a limit, how far, where?

Every longitudinal mode that the torque reaches and every transverse mode that these can excite, in both
planes of every free stretch, is integrated along the motion by Eq. (A.36): from rest, which shows the direct
excitation through sag, and with a floor below which no mode falls, which shows parametric excitation of one
mode (1:2) and of two (sum type). Small changes of the transverse frequencies and of the torque say how sure
the verdict is.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.studies.motion_response import MOST_MODES, PreparedMotion, prepare
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AlarmResult:
    """The verdict on a motion."""

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


def alarm(drive: Drive, motion: PlannedMotion, *, floor: float = 1e-5, limit: float = 5e-4) -> AlarmResult:
    """Whether a motion makes transverse vibrations grow from a ``floor`` beyond a ``limit`` [m]."""
    check_amplitudes(floor, limit)
    prepared = prepare(drive, motion, floor=floor)
    driven = prepared.response()
    grown = prepared.response(floor=floor)
    varied = [
        prepared.response(floor=MORE_FLOOR * floor, phase=phase, detuned=detuned, torque=MORE_TORQUE)
        for phase, detuned in ((0.25 * pi, -DETUNING), (0.75 * pi, 0.0), (0.5 * pi, DETUNING))
    ]
    largest = max(float(run.displacement.max()) for run in (driven, grown))
    changed = MARGIN * max(largest, *(float(run.displacement.max()) for run in varied))
    if not np.isfinite(largest):
        raise NotComputed(
            "the vibration along the planned motion diverges: plan a smaller or a slower motion"
        )
    tension = min(driven.tension, grown.tension)
    slack = tension < 0.0
    doubts = _doubts(prepared, slack)
    verdict = verdict_of(largest, changed, limit, doubts)
    model = prepared.models[0]
    rows = [
        (r, j, (part.span, part.ends, plane, number), float(omega))
        for r, (part, plane) in enumerate(zip(model.stretches, model.planes, strict=True))
        for j, (number, omega) in enumerate(zip(part.numbers, part.omega, strict=True))
    ]
    place = tuple(np.array([row[:2] for row in rows]).T)
    runs = prepared.response(parametric=False), driven, grown
    amplitude = np.array([run.amplitude[place] for run in runs])
    time = np.array([run.time[place] for run in runs])
    modes = mode_alarms([(*words, omega) for _, _, words, omega in rows], amplitude, time, floor)
    return AlarmResult(
        verdict=verdict,
        floor=floor,
        limit=limit,
        largest_transverse=largest,
        changed=changed,
        modes=modes,
        lowest_tension=tension if np.isfinite(tension) else None,
        slack=slack,
        reasons=(size_words(largest, limit) + change_words(verdict, changed, limit), *doubts),
        assumptions=_assumptions(drive, motion),
        remedy=remedy_of(verdict, modes, "the {} span"),
    )


def mode_alarms(
    modes: Sequence[tuple[str, tuple[float, float], str, int, float]],
    amplitude: Array,
    time: Array,
    floor: float,
) -> tuple[ModeAlarm, ...]:
    """What happens to each mode, the largest first.

    ``modes``: span, its ends, plane, number, frequency [rad/s]; ``amplitude``, ``time``, shape (3, modes):
    without parametric excitation, by the motion alone, from the floor [m], [s].
    """
    found = []
    for mode, (shaken, driven, grown), times in zip(modes, amplitude.T, time.T, strict=True):
        span, ends, plane, number, omega = mode
        largest = float(max(driven, grown))
        found.append(
            ModeAlarm(
                span=span,
                section=ends,
                plane=plane,
                number=number,
                frequency_hz=omega / (2.0 * pi),
                driven=float(driven),
                largest=largest,
                time=float(times[1 if driven >= grown else 2]),
                excitation=excitation_of(largest, float(shaken), floor),
            )
        )
    return tuple(sorted(found, key=lambda mode: -mode.largest))


def _doubts(prepared: PreparedMotion, slack: bool) -> list[str]:
    """Where the model's own range ends."""
    found = []
    if slack:
        found.append("a span goes slack along the motion; the model is not valid from there on")
    steepest = max(state.steepest for state in prepared.states)
    if steepest > STEEPEST:
        found.append(f"the slope of the sag is {steepest:.3g} at rest; the model is valid up to {STEEPEST:g}")
    if not prepared.complete:
        found.append(
            f"the motion can excite more than {MOST_MODES} transverse modes of a stretch; the others are "
            "neglected"
        )
    return found


def check_amplitudes(floor: float, limit: float) -> None:
    """Refuse a floor and a limit [m] that leave no room for growth."""
    if not 0.0 < floor < limit:
        raise InputRefused(f"floor = {floor:.4g} m must be above 0 and below limit = {limit:.4g} m")


def verdict_of(largest: float, changed: float, limit: float, doubts: list[str]) -> str:
    """Verdict from the largest displacement, its estimate under changes and the limit [m]."""
    return DANGEROUS if largest > limit else UNKNOWN if changed > limit or doubts else SAFE


def excitation_of(largest: float, shaken: float, floor: float) -> str:
    """What made a mode as large as it became; ``shaken``: amplitude without parametric excitation [m]."""
    if shaken > floor and shaken > 0.5 * largest:
        return DIRECT
    return PARAMETRIC if largest > 2.0 * floor else NONE


def size_words(largest: float, limit: float) -> str:
    """The largest displacement beside its limit [m]."""
    return f"largest transverse displacement {1e3 * largest:.4g} mm, limit {1e3 * limit:.4g} mm"


def change_words(verdict: str, changed: float, limit: float) -> str:
    """What a change of frequencies and torque makes of it [m], where that decides; else nothing."""
    if verdict != UNKNOWN or changed <= limit:
        return ""
    return (
        f"; a change of the transverse frequencies by {DETUNING:.1%} and of the torque by "
        f"{MORE_TORQUE - 1.0:.0%} takes it to an estimated {1e3 * changed:.4g} mm"
    )


def _assumptions(drive: Drive, motion: PlannedMotion) -> tuple[str, ...]:
    parts = [one for one in (drive.motor, *drive.pulley) if one is not None]
    rubs = any(part.coulomb_friction > 0.0 for part in parts)
    found = ["Coulomb friction of the shafts: as in the drive file"] if rubs else []
    if motion.changes:
        found.append("pretension, carriages and load torque change slowly against the transverse modes")
    return tuple(found)


def remedy_of(verdict: str, modes: Sequence[ModeAlarm], place: str) -> str:
    """What would keep the largest mode small; ``place``: how its span is named, such as "the {} span"."""
    if verdict == SAFE or not modes:
        return "none needed"
    worst = modes[0]
    where = f"mode {worst.number} of {place.format(worst.span)} ({worst.frequency_hz:.4g} Hz)"
    if worst.excitation == NONE:
        return "no mode grows; what is named above is not decided"
    if worst.excitation == DIRECT:
        return f"keep the torque away from {where}: it is excited directly; or tighten the cable"
    return (
        f"reduce the torque's oscillation before {worst.time:.3g} s, damp the cable, or move the pretension: "
        f"{where} is excited parametrically"
    )
