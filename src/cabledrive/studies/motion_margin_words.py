"""What is said of the margins along a planned motion: reasons and assumptions."""

from math import pi

import numpy as np

from cabledrive.studies.margins import EXCEEDED, HOLDS, TEETH, UNKNOWN, MotorMargin, PulleyMargin, SpanMargin
from cabledrive.studies.motion_tensions import MotionTensions

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
            found.append(
                f"span {span.name} reaches {span.tension[1]:.4g} N at {span.highest_at:.4g} s, its strength "
                f"is {span.strength:.4g} N"
            )
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
            found.append(
                f"the rope slips on {own.name} at {own.time:.4g} s: friction {own.capstan_friction:.3g}, "
                f"needed {need}"
            )
    for motor in motors:
        if motor.torque_limit is None:
            found.append(f"motor at {motor.name}: the file gives no torque limit")
        elif motor.peak_torque > motor.torque_limit:
            found.append(
                f"motor at {motor.name}: {motor.peak_torque:.4g} N m needed, limit "
                f"{motor.torque_limit:.4g} N m"
            )
        if motor.speed_limit is not None and motor.peak_speed > motor.speed_limit:
            found.append(
                f"motor at {motor.name}: {30.0 / pi * motor.peak_speed:.4g} rpm needed, limit "
                f"{30.0 / pi * motor.speed_limit:.4g} rpm"
            )
    return tuple(found) or ("ropes stay tight and unbroken, wraps, teeth and motors hold",)


def assumptions_of(found: MotionTensions, pulleys: tuple[PulleyMargin, ...]) -> tuple[str, ...]:
    """What the margins of a motion rest on."""
    slow = found.slow
    poses = "in the pose of the file" if len(slow.networks) == 1 else f"frozen in {len(slow.networks)} poses"
    how = (
        "torque from the given places, friction of bodies, bearings and motors included"
        if slow.given
        else "places from the given torque, without friction"
    )
    lines = [
        "forces of inertia distributed over elastic ropes; vibration by the modes of masses and springs "
        f"{poses}, {found.lowest_mode:.4g} to {found.highest_mode:.4g} Hz, sampled every "
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
