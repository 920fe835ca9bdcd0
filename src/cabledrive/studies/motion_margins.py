"""How near a planned motion comes to what ropes, wraps, teeth and motors hold, span by span."""

from dataclasses import dataclass
from math import pi

import numpy as np

from cabledrive.mechanics.network.span_table import next_span
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.parameters import Machine
from cabledrive.studies.motion_tensions import MotionTensions, motion_tensions
from cabledrive.studies.planned_motion import PlannedMotion

HOLDS, EXCEEDED, UNKNOWN = "holds", "exceeded", "unknown"
FRICTION, TEETH = "friction", "teeth"


@dataclass(frozen=True, slots=True, kw_only=True)
class SpanMargin:
    """Tensions of one rope of a span along a motion [N], and what it holds."""

    name: str
    route: str
    rest: tuple[float, float]  # lowest and highest at rest in the poses
    even: tuple[float, float]  # with forces of inertia and friction, without vibration
    tension: tuple[float, float]  # with the vibration
    # lowest_at, highest_at: when [s]
    lowest_at: float
    highest_at: float
    # strength, safety_factor: strength over the highest tension; None without a strength
    strength: float | None
    safety_factor: float | None

    @property
    def slack(self) -> bool:
        """Whether it goes slack."""
        return self.tension[0] <= 0.0

    @property
    def verdict(self) -> str:
        """Whether the rope stays tight and unbroken."""
        broken = self.safety_factor is not None and self.safety_factor < 1.0
        return EXCEEDED if self.slack or broken else HOLDS


@dataclass(frozen=True, slots=True, kw_only=True)
class PulleyMargin:
    """What a pulley must transmit along a motion, and what its friction or its teeth hold."""

    name: str
    route: str
    by: str  # {"friction", "teeth"}
    wrap: float  # least wrap [rad]
    needed_friction: float | None  # largest ``abs(ln(T1/T2))`` over the wrap; None where one tension is gone
    capstan_friction: float | None  # of the file
    # effective_tension, allowed: largest difference of the tensions of one rope, and what the teeth in mesh
    # take [N]
    effective_tension: float
    allowed: float | None
    teeth_in_mesh: int | None
    margin: float | None  # what holds over what is needed; below 1 the rope slips or the teeth are overloaded
    time: float  # when it is least [s]
    verdict: str  # {"holds", "exceeded", "unknown"}


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorMargin:
    """What a motor must give along a motion, at its pulley [N m], [rad/s]; limits None if not in the file."""

    name: str
    peak_torque: float
    rms_torque: float
    holding_torque: float
    torque_limit: float | None
    peak_speed: float
    speed_limit: float | None

    @property
    def verdict(self) -> str:
        """Whether torque and speed stay within the limits."""
        pairs = ((self.peak_torque, self.torque_limit), (self.peak_speed, self.speed_limit))
        if any(limit is not None and peak > limit for peak, limit in pairs):
            return EXCEEDED
        return UNKNOWN if self.torque_limit is None else HOLDS


LEAST_FRICTION = 0.05
"""Friction that a pulley without a coefficient in the file is trusted to have."""
_MISFIT = 0.05
"""Part of the largest torque by which the file's may differ from that of its places without a word."""


def reasons_of(
    spans: tuple[SpanMargin, ...], pulleys: tuple[PulleyMargin, ...], motors: tuple[MotorMargin, ...]
) -> tuple[str, ...]:
    """Why a motion exceeds what holds, or cannot be judged, one line each."""
    found = []
    for span in spans:
        if span.slack:
            found.append(f"span {span.name} goes slack at {span.lowest_at:.4g} s")
        if span.safety_factor is not None and span.safety_factor < 1.0:
            said = f"span {span.name} reaches {span.tension[1]:.4g} N at {span.highest_at:.4g} s"
            found.append(f"{said}, its strength is {span.strength:.4g} N")
    for own in pulleys:
        if own.verdict == UNKNOWN:
            lack = "strength [N] of the belt" if own.by == TEETH else "capstan_friction"
            found.append(f"pulley {own.name}: the file gives no {lack}")
        elif own.verdict == EXCEEDED and own.by == TEETH:
            found.append(
                f"belt on {own.name}: {own.effective_tension:.4g} N on {own.teeth_in_mesh} teeth in mesh at "
                f"{own.time:.4g} s, {own.allowed or 0.0:.4g} N allowed"
            )
        elif own.verdict == EXCEEDED:
            need = "more than any" if own.needed_friction is None else f"{own.needed_friction:.3g}"
            said = f"the rope slips on {own.name} at {own.time:.4g} s"
            found.append(f"{said}: friction {own.capstan_friction:.3g}, needed {need}")
    for motor in motors:
        if motor.torque_limit is None:
            found.append(f"motor at {motor.name}: the file gives no torque limit")
        elif motor.peak_torque > motor.torque_limit:
            said = f"motor at {motor.name}"
            found.append(f"{said}: {motor.peak_torque:.4g} N m needed, limit {motor.torque_limit:.4g} N m")
        if motor.speed_limit is not None and motor.peak_speed > motor.speed_limit:
            said = f"motor at {motor.name}: {30.0 / pi * motor.peak_speed:.4g} rpm needed"
            found.append(f"{said}, limit {30.0 / pi * motor.speed_limit:.4g} rpm")
    return tuple(found) or ("ropes stay tight and unbroken, wraps, teeth and motors hold",)


def assumptions_of(found: MotionTensions, pulleys: tuple[PulleyMargin, ...]) -> tuple[str, ...]:
    """What the margins of a motion rest on."""
    count = len(found.networks)
    poses = "in the pose of the file" if count == 1 else f"frozen in {count} poses"
    how = "places from the given torque, without friction"
    if found.given:
        how = "torque from the given places, friction of bodies, bearings and motors included"
    lines = [
        "forces of inertia distributed over elastic ropes; vibration by the modes of masses and springs "
        f"{poses}, {found.modes[0]:.4g} to {found.modes[1]:.4g} Hz, sampled every "
        f"{1e3 * found.time[1]:.3g} ms",
        how,
        "not included: slip itself, vibration across the ropes, reflections of waves inside a span",
    ]
    if any(own.margin is None and own.verdict == HOLDS and own.needed_friction for own in pulleys):
        lines.append(f"pulleys without capstan_friction have {LEAST_FRICTION} or more")
    if found.mismatch > _MISFIT * np.abs(found.torque).max(initial=0.0):
        lines.append(
            f"the torque of the file differs by up to {found.mismatch:.3g} N m from the one that its places "
            "need, which is taken"
        )
    return tuple(lines)


FULL_MESH, PER_TOOTH = 6, 0.2
"""Teeth in mesh that carry the whole allowed tension of a belt, and what each missing one takes off: the
factor for teeth in mesh of design manuals of PowerGrip belts, 1.0, 0.8, 0.6, 0.4, 0.2 for 6, 5, 4, 3, 2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionMargins:
    """The answer: margins, verdict, reasons and assumptions."""

    spans: tuple[SpanMargin, ...]
    pulleys: tuple[PulleyMargin, ...]
    motors: tuple[MotorMargin, ...]
    # largest change of a tension with the vibration over the largest without it; None without a change
    overshoot: float | None
    poses: int
    step: float  # between samples [s]
    given: bool  # whether the torque follows from given places
    reasons: tuple[str, ...]
    assumptions: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """The worst of all: "exceeded", then "unknown", then "holds"."""
        own = {one.verdict for one in self.spans} | {one.verdict for one in self.pulleys}
        own |= {one.verdict for one in self.motors}
        return next((word for word in (EXCEEDED, UNKNOWN) if word in own), HOLDS)


def motion_margins(drive: Machine, motion: PlannedMotion) -> MotionMargins:
    """Margins of ropes, wraps, teeth and motors along a motion."""
    found = motion_tensions(drive, motion)
    spans, motors = _spans(drive, found), _motors(drive, found)
    wrapped = (
        n for n, span in enumerate(drive.free_spans) if span.wrap is not None and span.end.pulley is not None
    )
    rows = (_pulley(drive, number, found) for number in wrapped)
    pulleys = tuple(sorted(rows, key=lambda own: np.inf if own.margin is None else own.margin))
    first = found.networks[0]
    rise, risen = (float(np.abs(own - found.rest).max()) for own in (found.even, found.vibrating))
    return MotionMargins(
        spans=spans,
        pulleys=pulleys,
        motors=motors,
        overshoot=risen / rise if rise > 1e-9 * found.rest.max() else None,
        poses=len(found.networks),
        step=float(found.time[1]),
        given=found.given,
        reasons=reasons_of(spans, pulleys, motors),
        assumptions=(*unheld_words(first.motion, first.statics), *assumptions_of(found, pulleys)),
    )


def _spans(drive: Machine, found: MotionTensions) -> tuple[SpanMargin, ...]:
    pieces = found.networks[0].pieces
    rows = []
    for number, span in enumerate(drive.free_spans):
        own = [i for i, piece in enumerate(pieces) if piece.span == number]
        rest, even, tension = (
            x[:, own].reshape(len(x), -1) for x in (found.rest, found.even, found.vibrating)
        )
        strength = drive.ropes[span.route].strength
        ends = [(float(values.min()), float(values.max())) for values in (rest, even, tension)]
        rows.append(
            SpanMargin(
                name=span.name,
                route=drive.route[span.route].name,
                rest=ends[0],
                even=ends[1],
                tension=ends[2],
                lowest_at=float(found.time[int(tension.min(axis=1).argmin())]),
                highest_at=float(found.time[int(tension.max(axis=1).argmax())]),
                strength=strength,
                safety_factor=None if strength is None else strength / max(float(tension.max()), 1e-300),
            )
        )
    return tuple(rows)


def _pulley(drive: Machine, number: int, found: MotionTensions) -> PulleyMargin:
    """The pulley at the end of a span."""
    pieces, span = found.networks[0].pieces, drive.free_spans[number]
    assert span.end.pulley is not None
    pulley, rope = drive.pulley[span.end.pulley], drive.ropes[span.route]
    after = next_span(drive, number)
    last = max(i for i, piece in enumerate(pieces) if piece.span == number)
    first = min(i for i, piece in enumerate(pieces) if piece.span == after)
    sides = found.vibrating[:, last, 1], found.vibrating[:, first, 0]
    wrap = found.share @ np.array([one.drive.free_spans[number].wrap for one in found.networks], dtype=float)
    tight, loose = np.maximum(*sides), np.minimum(*sides)
    ratio = np.maximum(tight, 1e-300) / np.maximum(loose, 1e-300)
    needed = np.where(loose > 0.0, np.log(ratio) / wrap, np.inf)
    effective = tight - loose
    teeth = allowed = None
    worst, have = float(needed.max()), pulley.capstan_friction
    when = int(needed.argmax())
    # A belt's teeth are on the side on which a driven pulley of its route lies.
    driven = [place for place in drive.places[span.route] if place.pulley in drive.turned]
    meets = not driven or span.end.sense in {place.sense for place in driven}
    if rope.tooth_pitch is not None and meets:
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


def _motors(drive: Machine, found: MotionTensions) -> tuple[MotorMargin, ...]:
    rows, torques = [], found.torque + found.holding
    for m, (number, torque) in enumerate(zip(drive.turned, torques.T, strict=True)):
        if number in drive.loads:  # what it is given is no motor's to hold
            continue
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
