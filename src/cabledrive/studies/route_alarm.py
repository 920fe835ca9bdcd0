"""The alarm for a machine with routes: does a planned motion make a span vibrate across?

The longitudinal modes of the machine follow the motors' torque; their tension excites the transverse modes of
all spans, at 1:2 and by sum type, Eq. (N.11), while bodies move and the modes change with them. Not included,
and said in the result: back-action of the strings on the tension, excitation through sag, dry friction.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from cabledrive.mechanics.network import statics_of
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive, posed
from cabledrive.studies.alarm import (
    DETUNING,
    MARGIN,
    MORE_FLOOR,
    MORE_TORQUE,
    AlarmResult,
    change_words,
    check_amplitudes,
    mode_alarms,
    remedy_of,
    size_words,
    verdict_of,
)
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_path import Passage, RoutePath, passages_of, path_of

SAME_POSE = 2e-3
"""Way to the next pose within which the modes are taken as they are: less than 0.02 % of a frequency each
10 % between poses."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Runs:
    """How b runs differ, each of shape (b,)."""

    floor: Array  # displacement below which no mode falls [m]
    phase: Array  # of what is there at the start [rad]
    detuned: Array  # relative change of the transverse frequencies
    torque: Array  # factor on the torque
    parametric: Array  # factor on the coupling: 0 or 1


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Growth:
    """What b runs left."""

    displacement: Array  # (b,): largest displacement of any span from its chord [m]
    # amplitude, time: (a, b): largest displacement by each mode [m], and when [s]
    amplitude: Array
    time: Array
    ended: float | None  # when a run reached the largest displacement that is followed [s]


def growth_along(path: RoutePath, runs: Runs, most: float) -> Growth:
    r"""Integrate :math:`\ddot a + \Gamma\dot a + \omega^2 a + \sum_q g^q Q_q a = \theta M` in every run.

    Kicks of the coupling about exact rotations; ``most``: displacement at which it ends [m].
    """
    h = float(path.time[1] - path.time[0])
    names = ("across", "across_loss", "across_turn", "coupling", "shape")
    middle = 0.5 * (path.here[1:] + path.here[:-1])
    last, driven = middle[0], path.swing
    omega, loss, turn, coupling, shape = (path.at(name, middle[:1])[0] for name in names)
    peak = np.abs(shape).max(axis=0, initial=0.0)[:, None]
    size = np.divide(runs.floor, peak, out=np.zeros((omega.size, runs.floor.size)), where=peak > 0.0)
    w = omega[:, None] * (1.0 + runs.detuned)
    a, v = size * np.cos(runs.phase), -size * w * np.sin(runs.phase)
    amplitude, when = np.zeros_like(a), np.zeros_like(a)
    displacement = np.zeros(runs.floor.size)
    ended = None
    kick = 0.5 * h * runs.torque * runs.parametric
    for i in range(middle.size):
        fresh = abs(middle[i] - last) > SAME_POSE
        if fresh:
            last = middle[i]
            omega, loss, turn, coupling, shape = (path.at(name, middle[i : i + 1])[0] for name in names)
            peak, w = np.abs(shape).max(axis=0, initial=0.0)[:, None], omega[:, None] * (1.0 + runs.detuned)
        if i == 0 or fresh:
            cosine, sine, decay = np.cos(w * h), np.sin(w * h), np.exp(-0.5 * h * loss)[:, None]
        pull = np.tensordot(driven[i], coupling, axes=1)
        rest = (turn @ path.pushed[i])[:, None] * runs.torque / w**2
        v = (v - kick * (pull @ a)) * decay
        d = a - rest
        a, v = rest + d * cosine + v / w * sine, v * cosine - d * w * sine
        v = v * decay - kick * (pull @ a)
        swing = np.sqrt((a - rest) ** 2 + (v / w) ** 2) * peak
        low = (swing < runs.floor) & (swing > 0.0)
        if low.any():
            scale = np.where(low, runs.floor / np.where(swing > 0.0, swing, 1.0), 1.0)
            a, v = rest + (a - rest) * scale, v * scale
        now = np.abs(a) * peak
        larger = now > amplitude
        amplitude[larger], when[larger] = now[larger], path.time[i + 1]
        displacement = np.maximum(displacement, np.abs(shape @ a).max(axis=0, initial=0.0))
        if displacement.max() > most:
            ended = float(path.time[i + 1])
            break
    return Growth(displacement=displacement, amplitude=amplitude, time=when, ended=ended)


MOST = 100.0
"""Largest displacement that is followed, over the limit."""
SAG_SHARE = 0.1
"""Sag over the limit beyond which it could excite a span directly."""
ASSUMPTIONS = (
    "transverse motion small: its back-action on the tension, which bounds large amplitudes, is not included",
    "not checked: excitation through sag, dry friction of shafts and rails, running cables",
)
DRIVEN, DIRECTLY, GROWN = 0, 1, 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RouteAlarm(AlarmResult):
    """The verdict on a motion of a machine with routes."""

    # pairs that come near 1:2 or sum resonance along the motion, the largest amplitude first
    passages: tuple[Passage, ...]
    poses: int  # at which modes were computed


def route_alarm(
    drive: RoutedDrive, motion: PlannedMotion, *, floor: float = 1e-5, limit: float = 5e-4
) -> RouteAlarm:
    """Whether a motion makes a span vibrate beyond a ``limit`` [m] from a ``floor`` [m] of every mode."""
    check_amplitudes(floor, limit)
    path = path_of(drive, motion)
    found = growth_along(path, _runs(floor), MOST * limit)
    largest = float(found.displacement[[DRIVEN, GROWN]].max())
    bound = MARGIN * max(largest, float(found.displacement[GROWN:].max()))
    rise = np.einsum("ipq,iq->ip", path.at("strain", path.here), path.along)
    tension = float((path.at("tension", path.here) + rise).min())
    doubts = _doubts(drive, motion, path, tension, limit)
    verdict = verdict_of(largest, bound, limit, doubts)
    more = change_words(verdict, bound, limit)
    if found.ended is not None:
        more = f"; followed until {found.ended:.4g} s, where a run reached {1e3 * MOST * limit:.4g} mm"
    lengths = {span.name: span.length for span in drive.free_spans}
    rows = [
        (span, (0.0, lengths[span]), plane, number, float(omega))
        for (span, plane, number), omega in zip(
            path.snapshots[0].keys, path.at("across", path.here[:1])[0], strict=True
        )
    ]
    runs = [DIRECTLY, DRIVEN, GROWN]
    modes = mode_alarms(rows, found.amplitude.T[runs], found.time.T[runs], floor)
    return RouteAlarm(
        verdict=verdict,
        floor=floor,
        limit=limit,
        largest_transverse=largest,
        changed=bound,
        modes=modes,
        lowest_tension=tension,
        slack=tension < 0.0,
        reasons=(size_words(largest, limit) + more, *doubts),
        assumptions=_assumptions(path, motion),
        remedy=remedy_of(verdict, modes, "{}"),
        passages=passages_of(path),
        poses=len(path.snapshots),
    )


def _runs(floor: float) -> Runs:
    """From rest, the same without coupling, from the floor, and three with everything a little otherwise."""
    return Runs(
        floor=floor * np.array([0.0, 0.0, 1.0, MORE_FLOOR, MORE_FLOOR, MORE_FLOOR]),
        phase=pi * np.array([0.0, 0.0, 0.5, 0.25, 0.75, 0.5]),
        detuned=DETUNING * np.array([0.0, 0.0, 0.0, -1.0, 0.0, 1.0]),
        torque=np.array([1.0, 1.0, 1.0, MORE_TORQUE, MORE_TORQUE, MORE_TORQUE]),
        parametric=np.array([1.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
    )


def _doubts(
    drive: RoutedDrive, motion: PlannedMotion, path: RoutePath, tension: float, limit: float
) -> list[str]:
    """Where the model's own range ends."""
    found = []
    if tension < 0.0:
        found.append("a span goes slack along the motion; the model is not valid from there on")
    sag, where = 0.0, ""  # the largest at midspan in the poses of the motion [m]
    for pose in path.poses:
        machine = posed(drive, pose) if pose else drive
        rest = statics_of(machine)
        for number, span in enumerate(machine.free_spans):
            across = abs(float(rest.line_load[number] @ np.array(span.across)))
            own = across * span.length**2 / (8.0 * float(rest.mean[number]))
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


def _assumptions(path: RoutePath, motion: PlannedMotion) -> tuple[str, ...]:
    if len(path.snapshots) == 1:
        return ("bodies stay where the file has them", *ASSUMPTIONS)
    how = "given" if motion.places else "by the torque on the rigid machine without friction"
    return (
        f"modes in {len(path.snapshots)} poses, followed by their shapes and interpolated; "
        f"places of bodies {how}",
        *ASSUMPTIONS,
    )
