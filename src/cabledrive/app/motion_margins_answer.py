"""What `cabledrive check --motion` says of a planned motion: for programs and for people."""

from dataclasses import replace
from math import degrees, pi
from typing import Any

from cabledrive.app.results import Absent, Answer
from cabledrive.app.tables import side_by_side
from cabledrive.parameters import Drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.studies.margins import TEETH, MotorMargin, PulleyMargin, SpanMargin
from cabledrive.studies.motion_file import read_motion
from cabledrive.studies.motion_margins import MotionMargins, motion_margins


def with_margins(answer: Answer, drive: Drive | RoutedDrive, file: str) -> Answer:
    """The same answer with the margins along a planned motion."""
    if isinstance(drive, RoutedDrive):
        found = motion_margins(drive, read_motion(file, drive, torque=False))
    else:
        motion = read_motion(file)
        machine = as_machine(drive, loaded=motion.load_torque is not None)
        pulleys = zip(machine.pulley, (drive.drive_pulley, drive.load_pulley), strict=True)
        wraps = {named.name: own.wrap_angle for named, own in pulleys if own.wrap_angle is not None}
        found = motion_margins(machine, motion.of_two_pulleys(), wraps=wraps)
    data: dict[str, Any] = {**answer.data, "motion": _data(found)}
    return replace(answer, data=data, text="\n\n".join([answer.text, *_text(found)]))


def _data(found: MotionMargins) -> dict[str, Any]:
    return {
        "verdict": found.verdict,
        "reasons": list(found.reasons),
        "assumptions": list(found.assumptions),
        "overshoot": Absent(reason="no tension changes") if found.overshoot is None else found.overshoot,
        "torque_from": "places" if found.given else "file",
        "poses": found.poses,
        "step": found.step,
        "spans": [_span(own) for own in found.spans],
        "pulleys": [_pulley(own) for own in found.pulleys],
        "motors": [_motor(own) for own in found.motors],
    }


def _span(own: SpanMargin) -> dict[str, Any]:
    lacking = Absent(reason="no strength [N] in the file")
    return {
        "name": own.name,
        "route": own.route,
        "tension_at_rest": list(own.rest),
        "tension_without_vibration": list(own.even),
        "lowest_tension": own.tension[0],
        "lowest_at": own.lowest_at,
        "highest_tension": own.tension[1],
        "highest_at": own.highest_at,
        "slack": own.slack,
        "safety_factor": lacking if own.safety_factor is None else own.safety_factor,
        "verdict": own.verdict,
    }


def _pulley(own: PulleyMargin) -> dict[str, Any]:
    row: dict[str, Any] = {
        "name": own.name,
        "route": own.route,
        "by": own.by,
        "wrap": own.wrap,
        "needed_friction": Absent(reason="a tension is gone")
        if own.needed_friction is None
        else own.needed_friction,
        "effective_tension": own.effective_tension,
        "margin": _margin(own),
        "time": own.time,
        "verdict": own.verdict,
    }
    if own.by == TEETH:
        lacking = Absent(reason="no strength [N] in the file")
        return row | {
            "teeth_in_mesh": own.teeth_in_mesh,
            "allowed_tension": lacking if own.allowed is None else own.allowed,
        }
    lacking = Absent(reason="no capstan_friction in the file")
    return row | {"capstan_friction": lacking if own.capstan_friction is None else own.capstan_friction}


def _margin(own: PulleyMargin) -> Any:
    if own.margin is not None:
        return own.margin
    return Absent(reason="nothing to transmit" if own.effective_tension == 0.0 else "no limit in the file")


def _motor(own: MotorMargin) -> dict[str, Any]:
    lacking = Absent(reason="no limit in the file")
    return {
        "pulley": own.name,
        "peak_torque": own.peak_torque,
        "rms_torque": own.rms_torque,
        "holding_torque": own.holding_torque,
        "torque_limit": lacking if own.torque_limit is None else own.torque_limit,
        "peak_speed": own.peak_speed,
        "speed_limit": lacking if own.speed_limit is None else own.speed_limit,
        "verdict": own.verdict,
    }


def _text(found: MotionMargins) -> list[str]:
    head = f"Planned motion: {found.verdict}"
    return [
        "\n".join([head, *(f"  {reason}" for reason in found.reasons)]),
        side_by_side(
            ("span", "at rest [N]", "without vibration [N]", "with vibration [N]", "safety"),
            [
                (
                    own.name,
                    _both(own.rest),
                    _both(own.even),
                    _both(own.tension),
                    "" if own.safety_factor is None else f"{own.safety_factor:.3g}",
                )
                for own in found.spans
            ],
        ),
        side_by_side(
            ("pulley", "wrap [deg]", "needed", "holds", "margin", "verdict"),
            [
                (
                    own.name,
                    f"{degrees(own.wrap):.4g}",
                    *_needed(own),
                    "" if own.margin is None else f"{own.margin:.3g}",
                    own.verdict,
                )
                for own in found.pulleys
            ],
        ),
        side_by_side(
            ("motor", "peak [N m]", "rms [N m]", "limit [N m]", "peak [rpm]", "verdict"),
            [
                (
                    own.name,
                    f"{own.peak_torque:.4g}",
                    f"{own.rms_torque:.4g}",
                    "" if own.torque_limit is None else f"{own.torque_limit:.4g}",
                    f"{30.0 / pi * own.peak_speed:.4g}",
                    own.verdict,
                )
                for own in found.motors
            ],
        ),
        "\n".join(f"Assumes: {words}." for words in found.assumptions),
    ]


def _needed(own: PulleyMargin) -> tuple[str, str]:
    """What a pulley must transmit and what it holds."""
    if own.by == TEETH:
        allowed = "" if own.allowed is None else f"{own.allowed:.4g} N"
        return f"{own.effective_tension:.4g} N", f"{allowed} on {own.teeth_in_mesh} teeth"
    need = "slips" if own.needed_friction is None else f"friction {own.needed_friction:.3g}"
    return need, "" if own.capstan_friction is None else f"{own.capstan_friction:.3g}"


def _both(values: tuple[float, float]) -> str:
    low, high = (f"{value:.5g}" for value in values)
    return low if low == high else f"{low} to {high}"
