"""What `resonance` says of loops, of machines with routes and of a planned motion."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import isfinite, pi
from typing import Any

from cabledrive.answers.figures import Row, aligned, quantity
from cabledrive.answers.keys import Keys
from cabledrive.answers.runs import ALARMED
from cabledrive.app.results import Answer, provenance
from cabledrive.mechanics.datasheet import largest_pretension, warnings_of_rest
from cabledrive.mechanics.holding import FREE
from cabledrive.parameters import Drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.threshold import required_detuning
from cabledrive.report.blocks import listed, table_text
from cabledrive.report.machine.tables import ENDS, PAIR, PLANE, ROUTE_PAIR, pair_data, pairs_table, several
from cabledrive.studies.alarm import AlarmResult, route_alarm
from cabledrive.studies.planned_motion import read_motion
from cabledrive.studies.resonance import Remedy, ResonanceSummary, sensitivity
from cabledrive.studies.resonance_detuning import NO_EXCITATION, OF_A_MOTION, InstabilityMargin
from cabledrive.studies.resonance_map import SteadyBranch
from cabledrive.studies.route_pairs import RouteResonance, route_resonance
from cabledrive.studies.route_path import Passage

MOST_PAIRS, MOST_PASSAGES, LARGEST_MODES, LARGEST_PASSAGES = 12, 50, 3, 5
METHOD_OF_ROUTES = "exact modes of the network, coupling by exact integrals, first-order instability"
EXCITED = {"none": "", "direct": "directly, through sag", "parametric": "parametrically"}
ALARM = Keys(
    "verdict estimate_with_changes=changed slack modes",
    dict.fromkeys(("largest_transverse", "estimate_with_changes", "lowest_tension"), "the motion diverges"),
    of=AlarmResult,
    figures=ALARMED,
)
SPAN, AT = Row("span", "Span", kind="text"), Row("time", "At", "s", ".3g")
MOVED = (
    *(SPAN, ENDS, PLANE, Row("number", "m", form="d")),
    Row("frequency_hz", "Frequency", "Hz", 4),
    Row("largest", "Largest", "m", ""),
    *(AT, Row("excitation", "Excited", form=lambda how: EXCITED[how], kind="text")),
)
PASSED = (
    *(SPAN, PLANE, Row("kind", "Kind", kind="text")),
    Row("longitudinal_hz", "Longitudinal", "Hz", 4),
    Row("transverse_hz", "Transverse", "Hz", several),
    Row("passes", "Passed", kind="flag"),
    Row("amplitude", "Amplitude over steady threshold", "", 3),
    AT,
)
PASSAGE = Keys(
    "kind span plane longitudinal_hz transverse_hz detuning_hz passes time "
    "amplitude_over_threshold=amplitude",
    of=Passage,
)
REGION = Keys("growth_rate=growth pulley_amplitude=amplitude slack", of=InstabilityMargin)
REMEDY = Keys("change value text", {"value": "no value within reach is enough"}, of=Remedy)
BRANCH = Keys(
    "spans onset folds hopf_points ended torque pulley growth upper=amplitude.0 lower=amplitude.1",
    {"onset": "the branch is not connected to the state of rest"},
    of=SteadyBranch,
)
SUMMARY = Keys("* verdict reasons", of=ResonanceSummary)
LOOP = Keys(
    "text: motor texts: warnings number: load_torque? rows: pairs remedies branches? object: motion? "
    "instability_region? map: sensitivity? tuned_pretension_under_load?",
    {"tuned_pretension_under_load": "no pretension in reach tunes it"},
    parts={
        "pairs": Keys(
            "count: second_number? number: second_transverse_hz? transverse_frequency_hz? frequency_ratio? "
            "tuned_pretension?",
            also=(PAIR,),
        ),
        "remedies": REMEDY,
        "branches": BRANCH,
        "instability_region": Keys(
            "number: detuning_hz half_width_hz required_detuning_hz",
            {"required_detuning_hz": "the pulley mode is undamped: no detuning is enough"},
            also=(REGION,),
        ),
        "motion": Keys("text: motor", also=(ALARM,)),
    },
    also=(SUMMARY,),
)
OF_ROUTES = Keys(
    "* nearest_span detuning verdict reasons motor certified warnings=left_out",
    of=RouteResonance,
)
ROUTE = Keys(
    "number: tuned_pretension rows: pairs object: motion?",
    {"tuned_pretension": "on a machine with routes the tensions follow from statics"},
    parts={
        "pairs": Keys("number: second_transverse_hz?", also=(ROUTE_PAIR,)),
        "motion": Keys("text: motor count: poses rows: passages", parts={"passages": PASSAGE}, also=(ALARM,)),
    },
    also=(OF_ROUTES,),
)


def loop_data(
    drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...], load_torque: float = 0.0
) -> dict[str, Any]:
    """The summary as JSON gives it, SI, Hz where the key says so; under a torque on the load [N m]."""
    data = SUMMARY(found)
    if found.instability is not None:
        model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)
        required = required_detuning(model, found.torque) / (2 * pi)
        data["instability_region"] = REGION(found.instability) | {
            "detuning_hz": found.instability.distance / (2 * pi),
            "half_width_hz": found.instability.half_width / (2 * pi),
            "required_detuning_hz": required if isfinite(required) else None,
        }
        data["sensitivity"] = sensitivity(drive, found.torque, load_torque)
    if found.split:
        data |= {"load_torque": load_torque, "tuned_pretension_under_load": found.split}
    data["pairs"] = [pair_data(pair, found.pairs) for pair in found.coupled]
    data |= {"warnings": warnings_of_rest(drive), "remedies": [REMEDY(change) for change in changes]}
    return LOOP(data)


def loop_text(drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...]) -> str:
    """The summary for people."""
    parts = _summary(drive, found)
    if any((pair.tuned_pretension or 0.0) > largest_pretension(drive) for pair in found.pairs):
        parts.append(f"Beyond {quantity(largest_pretension(drive), 'N')} the cable leaves its elastic range.")
    if found.split:
        tuned = (f"{span} {'-' if v is None else quantity(v, 'N')}" for span, v in found.split.items())
        parts.append(f"under the steady load each span is tuned at its own pretension: {', '.join(tuned)}")
    if changes:
        enough = [change.text for change in changes if change.enough] or ["none found"]
        others = [change.text for change in changes if not change.enough]
        lines = ("changes that make it safe, each alone:", *indented((*enough, *others)))
        parts.append("\n".join(lines))
    parts += ["\n".join(f"Warning: {line}." for line in warnings_of_rest(drive))]
    return "\n\n".join(filter(None, parts))


def _summary(
    drive: Drive | RoutedDrive, found: ResonanceSummary | RouteResonance, none: str = ""
) -> list[str]:
    """Verdict, figures and pairs; ``none``: what is said where there are no pairs."""
    head = (drive.title or drive.name, "", f"verdict: {found.verdict}", *indented(found.reasons))
    pairs = pairs_table(found, MOST_PAIRS)
    figures = "\n".join(aligned(found.figures))
    return ["\n".join(head), figures, none if pairs is None else table_text(pairs)]


def branches_text(branches: tuple[SteadyBranch, ...], torque: float) -> str:
    """Branches of steady motion for people. ``torque``: where amplitudes are given [N m]."""
    lines = [f"steady motion under {quantity(torque, 'N m')}:"]
    for branch in branches:
        onset = "" if branch.onset is None else f", from {quantity(branch.onset, 'N m')} on"
        special = [("folds", branch.folds), ("beats begin", branch.hopf_points)]
        words = "".join(
            f", {name} at {', '.join(quantity(value, 'N m') for value in values)}"
            for name, values in special
            if values
        )
        lines.append(f"  {' and '.join(branch.spans)}{onset}{words}")
        for pulley, upper, lower, growth in branch.at(torque):
            lines.append(
                f"    upper {quantity(upper, 'm')}, lower {quantity(lower, 'm')}, q {quantity(pulley, 'm')}: "
                + ("stable" if growth < 0 else f"unstable, {growth:.3g} 1/s")
            )
    return "\n".join(lines if branches else [*lines, "  only the state of rest"])


def indented(lines: Iterable[str]) -> list[str]:
    """Lines under another one."""
    return [f"  {line}" for line in lines]


def alarm_text(judged: AlarmResult) -> str:
    """The verdict on a motion for people, with the largest modes and passages."""
    head = "\n".join([f"motion: {judged.verdict}", *aligned(judged.figures)])
    both = ((MOVED, judged.modes[:LARGEST_MODES]), (PASSED, judged.passages[:LARGEST_PASSAGES]))
    return "\n\n".join([head, *(table_text(listed("", rows, things)) for rows, things in both if things)])


def of_motion(found: ResonanceSummary | RouteResonance, judged: AlarmResult, rest: Sequence[str] = ()) -> Any:
    """The summary whose verdict is that of a planned motion where no excitation is given."""
    if found.verdict != NO_EXCITATION:
        return found
    reasons = (f"of the planned motion: {judged.reasons[0]}", *rest)
    return replace(found, verdict=OF_A_MOTION[judged.verdict], reasons=reasons)


def route_answer(
    drive: RoutedDrive, torque: float | None, motion_file: str | None, floor: float, limit: float
) -> Answer:
    """The answer for a machine with routes, with the verdict on a planned motion where a file has one.

    ``torque``: amplitude of the verdict [N m], default: that of [excitation]; ``floor``, ``limit`` [m].
    """
    found, judged = route_resonance(drive, torque=torque), None
    if motion_file is not None:
        judged = route_alarm(drive, read_motion(motion_file, drive), floor=floor, limit=limit)
        found = of_motion(found, judged)
    data = ROUTE(OF_ROUTES(found) | {"tuned_pretension": None})
    data["pairs"] = [pair_data(pair) for pair in found.pairs]
    parts = _summary(drive, found, "No pair lies within 10 % (1:2) or 5 % (sum) of resonance.")
    parts.insert(2, f"Motor {found.motor}; nearest is the first transverse mode of {found.nearest_span}.")
    parts += [words[0].upper() + words[1:] + "." for words in found.left_out]
    if judged is not None:
        near = [PASSAGE(one) for one in judged.passages[:MOST_PASSAGES]]
        data["motion"] = ALARM(judged) | {"motor": FREE, "poses": judged.poses, "passages": near}
        parts.append(alarm_text(judged))
    return Answer(data=data, text="\n\n".join(parts), provenance=provenance(drive, method=METHOD_OF_ROUTES))
