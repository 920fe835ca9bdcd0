"""How near a planned motion comes to what ropes, wraps, teeth and motors hold, span by span."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.span_table import follows
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.margins import (
    EXCEEDED,
    FRICTION,
    HOLDS,
    TEETH,
    UNKNOWN,
    MotorMargin,
    PulleyMargin,
    SpanMargin,
)
from cabledrive.studies.motion_margin_words import LEAST_FRICTION, assumptions_of, reasons_of
from cabledrive.studies.motion_tensions import MotionTensions, motion_tensions
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_snapshot import driven_of

Array = NDArray[np.float64]

FULL_MESH, PER_TOOTH = 6, 0.2
"""Teeth in mesh that carry the whole allowed tension of a belt, and what each missing one takes off: the
factor for teeth in mesh of design manuals of PowerGrip belts, 1.0, 0.8, 0.6, 0.4, 0.2 for 6, 5, 4, 3, 2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionMargins:
    """The answer: margins, verdict, reasons and assumptions.

    Attributes
    ----------
    spans, pulleys, motors : tuple
    overshoot : float or None
        Largest change of a tension with the vibration over the largest without it; None without a change.
    poses : int
    step : float
        Between samples [s].
    given : bool
        Whether the torque follows from given places.
    reasons, assumptions : tuple of str
    """

    spans: tuple[SpanMargin, ...]
    pulleys: tuple[PulleyMargin, ...]
    motors: tuple[MotorMargin, ...]
    overshoot: float | None
    poses: int
    step: float
    given: bool
    reasons: tuple[str, ...]
    assumptions: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """The worst of all: "exceeded", then "unknown", then "holds"."""
        parts: tuple[SpanMargin | PulleyMargin | MotorMargin, ...] = (
            *self.spans,
            *self.pulleys,
            *self.motors,
        )
        own = {part.verdict for part in parts}
        return next((word for word in (EXCEEDED, UNKNOWN) if word in own), HOLDS)


def motion_margins(
    drive: RoutedDrive, motion: PlannedMotion, *, wraps: Mapping[str, float] | None = None
) -> MotionMargins:
    """Margins of ropes, wraps, teeth and motors along a motion.

    ``wraps``: by pulley, instead of those of the geometry [rad].
    Raises `InputRefused` if the motion does not fit the machine.
    """
    found = motion_tensions(drive, motion)
    spans, motors = _spans(drive, found), _motors(drive, found)
    pulleys = tuple(sorted(_pulleys(drive, found, wraps or {}), key=lambda own: own.margin or np.inf))
    rise, risen = (float(np.abs(own - found.rest).max()) for own in (found.even, found.vibrating))
    return MotionMargins(
        spans=spans,
        pulleys=pulleys,
        motors=motors,
        overshoot=risen / rise if rise > 1e-9 * found.rest.max() else None,
        poses=len(found.slow.networks),
        step=float(found.time[1]),
        given=found.slow.given,
        reasons=reasons_of(spans, pulleys, motors),
        assumptions=(*_held_by_loads(found), *assumptions_of(found, pulleys)),
    )


def _held_by_loads(found: MotionTensions) -> list[str]:
    network = found.slow.networks[0]
    return unheld_words(network.motion, network.statics)


def _spans(drive: RoutedDrive, found: MotionTensions) -> tuple[SpanMargin, ...]:
    pieces = found.slow.networks[0].pieces
    rows = []
    for number, span in enumerate(drive.free_spans):
        own = [i for i, piece in enumerate(pieces) if piece.span == number]
        rest, even, tension = (
            x[:, own].reshape(len(x), -1) for x in (found.rest, found.even, found.vibrating)
        )
        strength = drive.ropes[span.route].strength
        rows.append(
            SpanMargin(
                name=span.name,
                route=drive.route[span.route].name,
                rest=_range(rest),
                even=_range(even),
                tension=_range(tension),
                lowest_at=float(found.time[int(tension.min(axis=1).argmin())]),
                highest_at=float(found.time[int(tension.max(axis=1).argmax())]),
                strength=strength,
                safety_factor=None if strength is None else strength / max(float(tension.max()), 1e-300),
            )
        )
    return tuple(rows)


def _range(values: Array) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def _pulleys(drive: RoutedDrive, found: MotionTensions, given: Mapping[str, float]) -> list[PulleyMargin]:
    pieces = found.slow.networks[0].pieces
    rows = []
    for number, span in enumerate(drive.free_spans):
        if span.wrap is None or span.end.pulley is None:
            continue
        after = next(
            i
            for i, other in enumerate(drive.free_spans)
            if other.route == span.route and follows(drive, number, i)
        )
        last = max(i for i, piece in enumerate(pieces) if piece.span == number)
        first = min(i for i, piece in enumerate(pieces) if piece.span == after)
        wraps = [machine.free_spans[number].wrap for machine in found.slow.machines]
        sides = found.vibrating[:, last, 1], found.vibrating[:, first, 0]
        wrap = found.share @ np.array(wraps, dtype=float)
        if drive.pulley[span.end.pulley].name in given:
            wrap = np.full_like(wrap, given[drive.pulley[span.end.pulley].name])
        rows.append(_pulley(drive, number, found, sides, wrap))
    return rows


def _pulley(
    drive: RoutedDrive, number: int, found: MotionTensions, sides: tuple[Array, Array], wrap: Array
) -> PulleyMargin:
    span = drive.free_spans[number]
    assert span.end.pulley is not None
    pulley, rope = drive.pulley[span.end.pulley], drive.ropes[span.route]
    tight, loose = np.maximum(*sides), np.minimum(*sides)
    needed = np.where(
        loose > 0.0, np.log(np.maximum(tight, 1e-300) / np.maximum(loose, 1e-300)) / wrap, np.inf
    )
    effective = tight - loose
    teeth = allowed = None
    worst, have = float(needed.max()), pulley.capstan_friction
    when = int(needed.argmax())
    if rope.tooth_pitch is not None and _meets_teeth(drive, number):
        when = int(effective.argmax())
        teeth = int(wrap.min() * pulley.radius / rope.tooth_pitch + 1e-6)
        factor = min(1.0, max(0.0, 1.0 - PER_TOOTH * (FULL_MESH - teeth)))
        allowed = None if rope.strength is None else factor * rope.strength
        margin = None if allowed is None else allowed / max(float(effective.max()), 1e-300)
        if loose.min() <= 0.0:
            margin = 0.0
    else:
        margin = None if have is None else have / max(worst, 1e-300)
    verdict = UNKNOWN if margin is None else HOLDS if margin >= 1.0 else EXCEEDED
    if verdict == UNKNOWN and teeth is None and worst <= LEAST_FRICTION:
        verdict = HOLDS
    return PulleyMargin(
        name=pulley.name,
        route=drive.route[span.route].name,
        by=FRICTION if teeth is None else TEETH,
        wrap=float(wrap.min()),
        needed_friction=worst if np.isfinite(worst) else None,
        capstan_friction=have,
        effective_tension=float(effective.max()),
        allowed=allowed,
        teeth_in_mesh=teeth,
        margin=None if margin is None or not np.isfinite(margin) else float(margin),
        time=float(found.time[when]),
        verdict=verdict,
    )


def _meets_teeth(drive: RoutedDrive, number: int) -> bool:
    """Whether a pulley lies on the side of the belt on which a driven pulley of its route lies."""
    own = drive.free_spans[number]
    sides = {
        place.sense
        for place in drive.places[own.route]
        if place.pulley is not None and place.pulley in driven_of(drive)
    }
    return not sides or own.end.sense in sides


def _motors(drive: RoutedDrive, found: MotionTensions) -> tuple[MotorMargin, ...]:
    rows = []
    for m, number in enumerate(driven_of(drive)):
        torque = found.torque[:, m] + found.holding[:, m]
        motor = drive.motor[m] if drive.motor else None
        rows.append(
            MotorMargin(
                name=drive.pulley[number].name,
                peak_torque=float(np.abs(torque).max()),
                rms_torque=float(np.sqrt(np.mean(torque**2))),
                holding_torque=float(found.holding[np.abs(found.holding[:, m]).argmax(), m]),
                torque_limit=None if motor is None else motor.torque_limit,
                peak_speed=float(np.abs(found.speed[:, m]).max()),
                speed_limit=None if motor is None else motor.speed_limit,
            )
        )
    return tuple(rows)
