"""What `resonance` and `check` say of a machine with routes and of a planned motion."""

from dataclasses import replace
from typing import Any

from cabledrive.answers.keys import Keys
from cabledrive.app.commands.check import DERIVED_OF_ROUTES
from cabledrive.app.resonance_answer import ALARM, indented
from cabledrive.app.results import Answer, provenance
from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network.span_table import PULLEY_ROW, SPAN_ROW
from cabledrive.modal.lowest import DERIVED
from cabledrive.parameters import Drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.report.blocks import table_text
from cabledrive.report.machine.data import figures_table
from cabledrive.report.machine.tables import margins_tables, pairs_table
from cabledrive.report.typesetting import quantity
from cabledrive.studies.alarm import AlarmResult, route_alarm
from cabledrive.studies.motion_margins import (
    FRICTION,
    TEETH,
    MotionMargins,
    MotorMargin,
    PulleyMargin,
    SpanMargin,
    motion_margins,
)
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM
from cabledrive.studies.planned_motion import read_motion
from cabledrive.studies.resonance_detuning import NO_EXCITATION, OF_A_MOTION
from cabledrive.studies.route_pairs import RoutePair, RouteResonance, route_resonance
from cabledrive.studies.route_path import Passage

PLANE_WORDS = {"w": "in plane", "v": "out of plane"}
EXCITATION_WORDS = {"direct": "excited directly through sag", "parametric": "excited parametrically"}


def alarm_text(judged: AlarmResult) -> str:
    """The verdict on a motion for people, with the three largest modes."""
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
PASSAGE = Keys(
    "kind span plane longitudinal_hz transverse_hz detuning_hz passes time "
    "amplitude_over_threshold=amplitude",
    of=Passage,
)
ROUTE_PAIR = Keys(
    "kind longitudinal_hz family span plane detuning_hz threshold_strain=threshold_amplitude "
    "threshold_torque transverse_hz=transverse_hz.0",
    {"threshold_torque": ".reason"},
    of=RoutePair,
)
ROUTE = Keys("* nearest_span detuning verdict reasons motor certified warnings=left_out", of=RouteResonance)


ROUTE_ANSWER = Keys(
    "number: tuned_pretension rows: pairs object: motion?",
    {"tuned_pretension": "on a machine with routes the tensions follow from statics"},
    parts={
        "pairs": Keys("number: second_transverse_hz?", also=(ROUTE_PAIR,)),
        "motion": Keys("text: motor count: poses rows: passages", parts={"passages": PASSAGE}, also=(ALARM,)),
    },
    also=(ROUTE,),
)


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
    data = ROUTE_ANSWER(ROUTE(found) | {"tuned_pretension": None})
    data["pairs"] = [
        ROUTE_PAIR(pair) | ({"second_transverse_hz": pair.transverse_hz[1]} if pair.kind == SUM else {})
        for pair in found.pairs
    ]
    pairs = pairs_table(found, LISTED)
    none = "No pair lies within 10 % (1:2) or 5 % (sum) of resonance."
    head = (drive.title or drive.name, "", f"verdict: {found.verdict}", *indented(found.reasons))
    motor = f"Motor {found.motor}; nearest is the first transverse mode of {found.nearest_span}."
    left_out = (words[0].upper() + words[1:] + "." for words in found.left_out)
    parts = ("\n".join(head), table_text(figures_table(found, "")), motor)
    text = "\n\n".join((*parts, none if pairs is None else table_text(pairs), *left_out))
    if judged is not None:
        near = [PASSAGE(one) for one in judged.passages[:MOST_PASSAGES]]
        data["motion"] = ALARM(judged) | {"motor": FREE, "poses": judged.poses, "passages": near}
        passages = (_passage_line(one) for one in judged.passages[:LISTED_PASSAGES])
        text = "\n".join([text, "", alarm_text(judged), *passages])
    return Answer(data=data, text=text, provenance=provenance(drive, method=METHOD))


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
    parts = [answer.text, "\n".join([f"Planned motion: {found.verdict}", *indented(found.reasons)])]
    parts += [table_text(one) for one in margins_tables(found)]
    parts.append("\n".join(f"Assumes: {words}." for words in found.assumptions))
    return replace(answer, data={**answer.data, "motion": _data(found)}, text="\n\n".join(parts))


NO_STRENGTH, NO_LIMIT = "no strength [N] in the file", "no limit in the file"
SPAN = Keys(
    "name route tension_at_rest=rest tension_without_vibration=even lowest_at highest_at slack safety_factor "
    "verdict lowest_tension=tension.0 highest_tension=tension.1",
    {"safety_factor": NO_STRENGTH},
    of=SpanMargin,
)
MOTOR = Keys(
    "pulley=name peak_torque rms_torque holding_torque torque_limit peak_speed speed_limit verdict",
    {"torque_limit": NO_LIMIT, "speed_limit": NO_LIMIT},
    of=MotorMargin,
)
MARGINS = Keys(
    "verdict reasons assumptions overshoot poses step spans motors",
    {"overshoot": "no tension changes"},
    {"spans": SPAN, "motors": MOTOR},
    of=MotionMargins,
)
HELD = {FRICTION: "capstan_friction", TEETH: "teeth_in_mesh allowed_tension=allowed"}
PULLEYS = {
    by: Keys(
        f"name route by wrap needed_friction effective_tension margin time verdict {held}",
        {
            "needed_friction": "a tension is gone",
            "margin": NO_LIMIT,
            "allowed_tension": NO_STRENGTH,
            "capstan_friction": "no capstan_friction in the file",
        },
        of=PulleyMargin,
    )
    for by, held in HELD.items()
}

ALONG = Keys("text: torque_from rows: pulleys", parts={"pulleys": tuple(PULLEYS.values())}, also=(MARGINS,))
VALID = Keys("flag: valid text: drive_hash texts: warnings object: motion?", parts={"motion": ALONG})
CHECKED = Keys("object: derived", parts={"derived": DERIVED}, also=(VALID,))
ROUTED = Keys(
    "object: derived rows: spans pulleys",
    parts={"derived": DERIVED_OF_ROUTES, "spans": SPAN_ROW, "pulleys": PULLEY_ROW},
    also=(VALID,),
)


def _data(found: MotionMargins) -> dict[str, Any]:
    pulleys = [PULLEYS[own.by](own) for own in found.pulleys]
    for own, made in zip(found.pulleys, pulleys, strict=True):
        if own.effective_tension == 0.0 and own.margin is None:
            made["margin_reason"] = "nothing to transmit"
    return MARGINS(found) | {"torque_from": "places" if found.given else "file", "pulleys": pulleys}
