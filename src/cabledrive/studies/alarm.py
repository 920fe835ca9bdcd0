r"""The alarm: does a planned motion make transverse vibrations grow beyond a limit, how far, where?

Every longitudinal mode that the torque reaches and every transverse mode that these can excite, in both
planes of every free stretch, is integrated along the motion by Eq. (A.36): from rest, which shows the direct
excitation through sag, and with a floor below which no mode falls, which shows parametric excitation of one
mode (1:2) and of two (sum type). Small changes of the transverse frequencies and of the torque say how sure
the verdict is.

With routes the longitudinal modes of the machine follow the motors' torque; their tension excites the
transverse modes of all spans, at 1:2 and by sum type, Eq. (N.11), while bodies move and the modes change with
them. Not included, and said in the result: back-action of the strings on the tension, excitation through sag,
dry friction.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from cabledrive.answers.result import Result
from cabledrive.answers.runs import ALARMED
from cabledrive.mechanics.holding import released
from cabledrive.mechanics.network import statics_of
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import Machine, RoutedDrive, posed
from cabledrive.studies.motion_response import MOST_MODES, prepare
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_path import Passage, RoutePath, passages_of, path_of
from cabledrive.studies.route_snapshot import peaks_of

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
    # of routes: pairs that come near 1:2 or sum resonance along the motion, the largest amplitude first, and
    # poses at which modes were computed
    passages: tuple[Passage, ...] = ()
    poses: int = 1


def alarm(drive: Machine, motion: PlannedMotion, *, floor: float = 1e-5, limit: float = 5e-4) -> AlarmResult:
    """Whether a motion makes transverse vibrations grow from a ``floor`` beyond a ``limit`` [m]."""
    if not 0.0 < floor < limit:
        raise InputRefused(f"floor = {floor:.4g} m must be above 0 and below limit = {limit:.4g} m")
    if isinstance(drive, RoutedDrive):
        return route_alarm(drive, motion, floor, limit)
    prepared = prepare(released(drive), motion, floor=floor)  # as routes: a torque turns the rotor
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
    rows = [
        (r, j, (part.span, part.ends, plane, number))
        for r, (plane, part) in enumerate(itertools.product("wv", prepared.stretches))
        for j, number in enumerate(part.numbers)
    ]
    omega = np.array([prepared.models[0].transverse[r, j] for r, j, _ in rows])
    place = tuple(np.array([row[:2] for row in rows]).T)
    doubts, assumptions = list[str](), list[str]()
    steepest = max(state.steepest for state in prepared.states)
    if steepest > STEEPEST:
        doubts.append(
            f"the slope of the sag is {steepest:.3g} at rest; the model is valid up to {STEEPEST:g}"
        )
    if not prepared.complete:
        more = f"more than {MOST_MODES} transverse modes of a stretch"
        doubts.append(f"the motion can excite {more}; the others are neglected")
    if any(part.coulomb_friction > 0.0 for part in (drive.motor, *drive.pulley) if part is not None):
        assumptions.append("Coulomb friction of the shafts: as in the drive file")
    if motion.changes:
        assumptions.append("pretension, carriages and load torque change slowly against the transverse modes")
    runs = prepared.response(parametric=False), driven, grown
    amplitude, time = (np.array([getattr(run, of)[place] for run in runs]) for of in ("amplitude", "time"))
    found, alarms = (largest, changed, min(driven.tension, grown.tension)), [row[2] for row in rows]
    modes = _mode_alarms(alarms, omega, amplitude, time, floor)
    answer = _answer(found, (floor, limit), modes, doubts, "the {} span")
    return AlarmResult(**answer, assumptions=tuple(assumptions))


def _answer(
    found: tuple[float, float, float],
    allowed: tuple[float, float],
    modes: tuple[ModeAlarm, ...],
    doubts: Sequence[str],
    place: str,
    more: str = "",
) -> dict[str, Any]:
    """Verdict, reasons and remedy from displacement, its estimate under changes [m] and lowest tension [N].

    ``allowed``: floor and limit [m]; ``place``: how a span is named; ``more``: said of the displacement.
    """
    (largest, changed, tension), (floor, limit) = found, allowed
    if tension < 0.0:
        doubts = ["a span goes slack along the motion; the model is not valid from there on", *doubts]
    verdict = DANGEROUS if largest > limit else UNKNOWN if changed > limit or doubts else SAFE
    if not more and verdict == UNKNOWN and changed > limit:
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
        "remedy": _remedy(verdict, modes, place),
    }


def _remedy(verdict: str, modes: Sequence[ModeAlarm], place: str) -> str:
    """What would keep the largest mode small; ``place``: how its span is named, such as "the {} span"."""
    if verdict == SAFE or not modes:
        return "none needed"
    worst = modes[0]
    where = f"mode {worst.number} of {place.format(worst.span)} ({worst.frequency_hz:.4g} Hz)"
    if worst.excitation == NONE:
        return "no mode grows; what is named above is not decided"
    if worst.excitation == DIRECT:
        return f"keep the torque away from {where}: it is excited directly; or tighten the cable"
    said = f"reduce the torque's oscillation before {worst.time:.3g} s, damp the cable"
    return f"{said}, or move the pretension: {where} is excited parametrically"


Mode = tuple[str, tuple[float, float], str, int]
"""Span, its ends [m], plane and number of a transverse mode."""


def _mode_alarms(
    modes: Sequence[Mode], omega: Array, amplitude: Array, time: Array, floor: float
) -> tuple[ModeAlarm, ...]:
    """What happens to each mode of frequency ``omega`` [rad/s], the largest first; ``floor`` [m].

    ``amplitude``, ``time``, (3, modes): without parametric excitation, by the motion alone, from the floor.
    """
    found = []
    for k, (span, ends, plane, number) in enumerate(modes):
        shaken, driven, grown = (float(own) for own in amplitude[:, k])
        largest = max(driven, grown)
        own = PARAMETRIC if largest > 2.0 * floor else NONE
        found.append(
            ModeAlarm(
                span=span,
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


SAME_POSE = 2e-3
"""Way to the next pose within which the modes are taken as they are: less than 0.02 % of a frequency each
10 % between poses."""


DRIVEN, DIRECTLY, GROWN = 0, 1, 2
"""Runs from rest, so without coupling, from the floor; behind them three with all a little otherwise."""
SHAKEN = 3


def growth_along(path: RoutePath, floor: float, most: float) -> tuple[Array, Array, Array, float | None]:
    r"""Integrate :math:`\ddot a + \Gamma\dot a + \omega^2 a + \sum_q g^q Q_q a = \theta M`, all runs.

    Returns the largest displacement of any span, (runs,), by each mode and when, (modes, runs), [m], [s],
    and when a run reached ``most`` [m], where all end.
    """
    floors = floor * np.array([0.0, 0.0, 1.0, *[MORE_FLOOR] * SHAKEN])
    phase = pi * np.array([0.0, 0.0, 0.5, 0.25, 0.75, 0.5])
    detuned = DETUNING * np.array([0.0, 0.0, 0.0, -1.0, 0.0, 1.0])
    torque = np.array([1.0, 1.0, 1.0, *[MORE_TORQUE] * SHAKEN])
    parametric = np.array([1.0, 0.0, 1.0, *[1.0] * SHAKEN])
    h = float(path.time[1] - path.time[0])
    names = ("across", "across_loss", "across_turn", "coupling", "shape")
    middle = 0.5 * (path.here[1:] + path.here[:-1])
    last, driven = middle[0], path.swing
    omega, loss, turn, coupling, shape = (path.at(name, middle[:1])[0] for name in names)
    peak = peaks_of(shape)[:, None]
    size = np.divide(floors, peak, out=np.zeros((omega.size, floors.size)), where=peak > 0.0)
    w = omega[:, None] * (1.0 + detuned)
    a, v = size * np.cos(phase), -size * w * np.sin(phase)
    amplitude, when = np.zeros_like(a), np.zeros_like(a)
    displacement, ended = np.zeros(floors.size), None
    kick = 0.5 * h * torque * parametric
    for i in range(middle.size):
        if i == 0 or abs(middle[i] - last) > SAME_POSE:
            last = middle[i]
            omega, loss, turn, coupling, shape = (path.at(name, middle[i : i + 1])[0] for name in names)
            peak, w = peaks_of(shape)[:, None], omega[:, None] * (1.0 + detuned)
            cosine, sine, decay = np.cos(w * h), np.sin(w * h), np.exp(-0.5 * h * loss)[:, None]
        pull = np.tensordot(driven[i], coupling, axes=1)
        rest = (turn @ path.pushed[i])[:, None] * torque / w**2
        v = (v - kick * (pull @ a)) * decay
        d = a - rest
        a, v = rest + d * cosine + v / w * sine, v * cosine - d * w * sine
        v = v * decay - kick * (pull @ a)
        swing = np.sqrt((a - rest) ** 2 + (v / w) ** 2) * peak
        low = (swing < floors) & (swing > 0.0)
        if low.any():
            scale = np.where(low, floors / np.where(swing > 0.0, swing, 1.0), 1.0)
            a, v = rest + (a - rest) * scale, v * scale
        now = np.abs(a) * peak
        larger = now > amplitude
        amplitude[larger], when[larger] = now[larger], path.time[i + 1]
        together = np.abs(shape @ a).max(axis=0, initial=0.0)
        displacement = np.maximum(displacement, np.maximum(together, now.max(axis=0, initial=0.0)))
        if displacement.max() > most:
            ended = float(path.time[i + 1])
            break
    return displacement, amplitude, when, ended


MOST = 100.0
"""Largest displacement that is followed, over the limit."""
SAG_SHARE = 0.1
"""Sag over the limit beyond which it could excite a span directly."""
ASSUMPTIONS = (
    "transverse motion small: its back-action on the tension, which bounds large amplitudes, is not included",
    "not checked: excitation through sag, dry friction of shafts and rails, running cables",
)


def route_alarm(drive: RoutedDrive, motion: PlannedMotion, floor: float, limit: float) -> AlarmResult:
    """Whether a motion makes a span vibrate beyond a ``limit`` [m] from a ``floor`` [m] of every mode."""
    path = path_of(drive, motion)
    displacement, amplitude, time, ended = growth_along(path, floor, MOST * limit)
    largest = float(displacement[[DRIVEN, GROWN]].max())
    changed = MARGIN * max(largest, float(displacement[GROWN:].max()))
    rise = np.einsum("ipq,iq->ip", path.at("strain", path.here), path.driven[0])
    lengths = {span.name: span.length for span in drive.free_spans}
    rows = [(span, (0.0, lengths[span]), plane, n) for span, plane, n in path.snapshots[0].keys]
    omega, runs, more = path.at("across", path.here[:1])[0], [DIRECTLY, DRIVEN, GROWN], ""
    still = ("bodies stay where the file has them",)
    if (poses := len(path.snapshots)) > 1:
        how = "given" if motion.places else "by the torque on the rigid machine without friction"
        words = f"modes in {poses} poses, followed by their shapes and interpolated; places of bodies {how}"
        still = (words,)
    if ended is not None:
        more = f"; followed until {ended:.4g} s, where a run reached {1e3 * MOST * limit:.4g} mm"
    found = largest, changed, float((path.at("tension", path.here) + rise).min())
    modes = _mode_alarms(rows, omega, amplitude.T[runs], time.T[runs], floor)
    doubts = _doubts_of_routes(drive, motion, path, limit)
    return AlarmResult(
        **_answer(found, (floor, limit), modes, doubts, "{}", more),
        assumptions=(*still, *ASSUMPTIONS),
        passages=passages_of(path),
        poses=poses,
    )


def _doubts_of_routes(drive: RoutedDrive, motion: PlannedMotion, path: RoutePath, limit: float) -> list[str]:
    """Where the model's own range ends besides."""
    found = []
    sag, where = 0.0, ""  # the largest at midspan in the poses of the motion [m]
    for pose in path.poses:
        machine = posed(drive, pose) if pose else drive
        rest = statics_of(machine)
        for number, span in enumerate(machine.free_spans):
            weight = abs(rest.stretches[number][0].load[1]) * rest.stretches[number][-1].end  # across
            own = weight * span.length / (8.0 * float(rest.mean[number]))
            sag, where = max((sag, where), (own, span.name))
    if sag > SAG_SHARE * limit:
        found.append(f"{where} sags by {1e3 * sag:.3g} mm, and excitation through sag is not computed")
    if not all(one.certified for one in path.snapshots):
        found.append("the list of modes is not certified in every pose")
    if path.ambiguous:
        found.append(f"modes change too much between poses to be followed: {'; '.join(path.ambiguous[:3])}")
    rubs = any(part.coulomb_friction for parts in (drive.motor, drive.pulley, drive.body) for part in parts)
    if not motion.places and len(path.snapshots) > 1 and rubs:
        found.append(
            "the places of bodies follow from the torque without the file's friction: give them as columns"
        )
    return found
