"""What `resonance` and `check` say of a machine with routes and of a planned motion."""

from dataclasses import replace
from math import degrees, pi
from typing import Any

import numpy as np

from cabledrive.app.results import Absent, Answer, provenance, side_by_side
from cabledrive.mechanics.holding import FREE
from cabledrive.parameters import Drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.studies.alarm import AlarmResult
from cabledrive.studies.motion_margins import (
    TEETH,
    MotionMargins,
    MotorMargin,
    PulleyMargin,
    SpanMargin,
    motion_margins,
)
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM
from cabledrive.studies.planned_motion import read_motion
from cabledrive.studies.resonance_detuning import NO_EXCITATION, OF_A_MOTION, STATE_ONE
from cabledrive.studies.route_alarm import route_alarm
from cabledrive.studies.route_pairs import RoutePair, RouteResonance, route_resonance
from cabledrive.studies.route_path import Passage

PLANE_WORDS = {"w": "in plane", "v": "out of plane"}
EXCITATION_WORDS = {"direct": "excited directly through sag", "parametric": "excited parametrically"}


def alarm_data(judged: AlarmResult) -> dict[str, Any]:
    """The verdict on a motion as JSON gives it. Returns SI."""
    return {
        "verdict": judged.verdict,
        "limit": judged.limit,
        "floor": judged.floor,
        "largest_transverse": _or_beyond(judged.largest_transverse),
        "estimate_with_changes": _or_beyond(judged.changed),
        "reasons": judged.reasons,
        "assumptions": judged.assumptions,
        "remedy": judged.remedy,
        "slack": judged.slack,
        "lowest_tension": _or_beyond(judged.lowest_tension),
        "modes": judged.modes,
    }


def _or_beyond(value: float | None) -> Any:
    if value is None or not np.isfinite(value):
        return Absent(reason="the motion diverges")
    return value


def alarm_text(judged: AlarmResult) -> str:
    """The verdict on a motion for people, with the three largest modes."""
    from cabledrive.report.typesetting import quantity

    lines = [f"motion: {judged.verdict}", *(f"  {reason}" for reason in judged.reasons)]
    if judged.remedy != "none needed":
        lines.append(f"  {judged.remedy}")
    for mode in judged.modes[:3]:
        where = (
            f"{mode.span}, {mode.section[0]:.4g} to {mode.section[1]:.4g} m, {PLANE_WORDS[mode.plane]}, "
            f"m = {mode.number} ({mode.frequency_hz:.4g} Hz)"
        )
        lines.append(
            f"  {where}: {quantity(mode.largest, 'm')} at {mode.time:.3g} s"
            + ("" if mode.excitation == "none" else f", {EXCITATION_WORDS[mode.excitation]}")
        )
    lines += [f"  assumes: {words}" for words in judged.assumptions]
    return "\n".join(lines)


METHOD = "exact modes of the network, coupling by exact integrals, first-order instability"
LISTED = 12
MOST_PASSAGES, LISTED_PASSAGES = 50, 5


def route_resonance_answer(
    drive: RoutedDrive, torque: float | None, motion_file: str | None, floor: float, limit: float
) -> Answer:
    """The answer of `resonance`, with the verdict on a planned motion where a file has one.

    ``torque``: amplitude of the verdict [N m], default: that of [excitation]; ``floor``, ``limit`` [m].
    """
    found, judged = route_resonance(drive, torque=torque), None
    if motion_file is not None:
        judged = route_alarm(drive, read_motion(motion_file, drive), floor=floor, limit=limit)
        if found.verdict == NO_EXCITATION:
            of_motion = f"of the planned motion: {judged.reasons[0]}"
            found = replace(found, verdict=OF_A_MOTION[judged.verdict], reasons=(of_motion,))
    data: dict[str, Any] = {
        "frequency_ratio": found.frequency_ratio,
        "longitudinal_hz": found.longitudinal_hz,
        "nearest_span": found.nearest_span,
        "tuned_pretension": Absent(reason="on a machine with routes the tensions follow from statics"),
        "threshold_torque": Absent(reason="no pair that the first motor excites is near")
        if found.threshold_torque is None
        else found.threshold_torque,
        "detuning": found.detuning,
        "verdict": found.verdict,
        "reasons": list(found.reasons),
        "torque": Absent(reason=STATE_ONE) if found.torque is None else found.torque,
        "pairs": [_row(pair) for pair in found.pairs],
        "motor": found.motor,
        "certified": found.certified,
        "warnings": list(found.left_out),
    }
    text = _text(drive, found, data)
    if judged is not None:
        near = [_passage(one) for one in judged.passages[:MOST_PASSAGES]]
        data["motion"] = alarm_data(judged) | {"motor": FREE, "poses": judged.poses, "passages": near}
        passages = (_passage_line(one) for one in judged.passages[:LISTED_PASSAGES])
        text = "\n".join([text, "", alarm_text(judged), *passages])
    return Answer(data=data, text=text, provenance=provenance(drive, method=METHOD))


def _row(pair: RoutePair) -> dict[str, Any]:
    row: dict[str, Any] = {
        "kind": pair.kind,
        "longitudinal_hz": pair.longitudinal_hz,
        "family": pair.family,
        "span": pair.span,
        "plane": pair.plane,
        "transverse_hz": pair.transverse_hz[0],
        "detuning_hz": pair.detuning_hz,
        "threshold_strain": pair.threshold_amplitude,
        "threshold_torque": Absent(reason=pair.reason)
        if pair.threshold_torque is None
        else pair.threshold_torque,
    }
    return row | ({"second_transverse_hz": pair.transverse_hz[1]} if pair.kind == SUM else {})


def _text(drive: RoutedDrive, found: RouteResonance, data: dict[str, Any]) -> str:
    from cabledrive.report.typesetting import quantity

    head = ("longitudinal [Hz]", "transverse [Hz]", "detuning [Hz]", "threshold")
    widths = (18, 24, 15, 14)
    lines = [
        f"{drive.title or drive.name}",
        f"Verdict: {data['verdict']}; {data['reasons'][0]}.",
        f"Frequency ratio {found.frequency_ratio:.4g}: first transverse mode of {found.nearest_span} over "
        f"the longitudinal mode of {found.longitudinal_hz:.6g} Hz; motor {found.motor}.",
        "",
        "".join(f"{word:>{width}}" for word, width in zip(head, widths, strict=True)) + "  kind  span, plane",
    ]
    for pair in found.pairs[:LISTED]:
        both = f"{pair.transverse_hz[0]:.6g}"
        both += "" if pair.kind == ONE_TO_TWO else f" + {pair.transverse_hz[1]:.6g}"
        threshold = "none" if pair.threshold_torque is None else quantity(pair.threshold_torque, "N m")
        numbers = f"{pair.longitudinal_hz:>18.6g}{both:>24}{pair.detuning_hz:>15.4g}{threshold:>14}"
        lines.append(f"{numbers}  {pair.kind:<4}  {pair.span}, {pair.plane}")
    if not found.pairs:
        lines.append("No pair lies within 10 % (1:2) or 5 % (sum) of resonance.")
    elif len(found.pairs) > LISTED:
        lines.append(f"and {len(found.pairs) - LISTED} more with higher thresholds.")
    left_out = (words[0].upper() + words[1:] + "." for words in data["warnings"])
    return "\n".join([*lines, "", *left_out])


def _passage(one: Passage) -> dict[str, Any]:
    return {
        "kind": one.kind,
        "span": one.span,
        "plane": one.plane,
        "longitudinal_hz": one.longitudinal_hz,
        "transverse_hz": list(one.transverse_hz),
        "detuning_hz": list(one.detuning_hz),
        "passes": one.passes,
        "amplitude_over_threshold": one.amplitude,
        "time": one.time,
    }


def _passage_line(one: Passage) -> str:
    both = " + ".join(f"{f:.4g}" for f in one.transverse_hz[: 1 if one.kind == ONE_TO_TWO else 2])
    way = "passes" if one.passes else "comes near"
    return (
        f"  {one.span}, {PLANE_WORDS[one.plane]}: {way} {one.kind} "
        f"({one.longitudinal_hz:.4g} Hz against {both} Hz); "
        f"largest amplitude {one.amplitude:.3g} of the steady threshold, at {one.time:.3g} s"
    )


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
    return replace(answer, data=data, text="\n\n".join([answer.text, *_margins_text(found)]))


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


def _margins_text(found: MotionMargins) -> list[str]:
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
