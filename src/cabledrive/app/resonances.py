"""What `resonance` says of a machine and of a planned motion."""

from collections.abc import Iterable
from dataclasses import replace
from math import isfinite, pi
from typing import Any

from cabledrive.answers.figures import Row, aligned, quantity
from cabledrive.answers.keys import Keys
from cabledrive.answers.runs import ALARMED
from cabledrive.mechanics.datasheet import largest_pretension, warnings_of_rest
from cabledrive.mechanics.holding import HOLDING
from cabledrive.parameters import Machine
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.threshold import InstabilityMargin, required_detuning
from cabledrive.report.blocks import listed, table_text
from cabledrive.report.machine.tables import ENDS, NEAR, PLANE, pairs_table, several
from cabledrive.studies.alarm import AlarmResult, Passage
from cabledrive.studies.resonance_detuning import NO_EXCITATION, OF_A_MOTION, Remedy, ResonanceSummary
from cabledrive.studies.resonance_map import SteadyBranch

MOST_PAIRS, MOST_PASSAGES, LARGEST_MODES, LARGEST_PASSAGES = 12, 50, 3, 5
NO_PAIR = "No pair lies within 10 % (1:2) or 5 % (sum) of resonance."
SPRUNG = "The motor is on its holding stiffness."
EXCITED = {"none": "", "direct": "directly, through sag", "parametric": "parametrically"}
PASSAGE = Keys(
    "kind span plane longitudinal_hz transverse_hz detuning_hz passes time "
    "amplitude_over_threshold=amplitude",
    of=Passage,
)
ALARM = Keys(
    "verdict estimate_with_changes=changed slack modes poses passages",
    dict.fromkeys(("largest_transverse", "estimate_with_changes", "lowest_tension"), "the motion diverges"),
    {"passages": PASSAGE},
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
REGION = Keys("growth_rate=growth pulley_amplitude=amplitude slack", of=InstabilityMargin)
REMEDY = Keys("change value text", {"value": "no value within reach is enough"}, of=Remedy)
BRANCH = Keys(
    "spans onset folds hopf_points ended torque pulley growth upper=amplitude.0 lower=amplitude.1",
    {"onset": "the branch is not connected to the state of rest"},
    of=SteadyBranch,
)
SUMMARY = Keys(
    "* verdict reasons motor warnings=left_out nearest_span certified",
    {
        "nearest_span": "the ratio is that of an empty span",
        "certified": "pairs of modes were not looked for",
    },
    of=ResonanceSummary,
)
OWN = Keys("number: transverse_frequency_hz? frequency_ratio? tuned_pretension?", also=(NEAR,))
RESONANCE = Keys(
    "number: load_torque? rows: pairs remedies? branches? object: motion? instability_region? "
    "map: tuned_pretension_under_load?",
    {"tuned_pretension_under_load": "no pretension in reach tunes it"},
    parts={
        "pairs": OWN,
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


def loop_data(drive: Machine, found: ResonanceSummary, load_torque: float) -> dict[str, Any]:
    """What JSON has of loops and lines alone, SI, Hz where the key says so; under a load's torque [N m]."""
    data: dict[str, Any] = {"warnings": warnings_of_rest(drive)}
    if found.instability is not None:
        acting, region = found.torque or 0.0, found.instability
        model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)
        required = required_detuning(model, acting) / (2 * pi)
        data["instability_region"] = REGION(region) | {
            "detuning_hz": region.distance / (2 * pi),
            "half_width_hz": region.half_width / (2 * pi),
            "required_detuning_hz": required if isfinite(required) else None,
        }
    if found.split:
        data |= {"load_torque": load_torque, "tuned_pretension_under_load": found.split}
    return RESONANCE(data)


def remedies_text(changes: tuple[Remedy, ...], what: str) -> str:
    """Changes that make something safe, and those tried in vain."""
    enough = [change.text for change in changes if change.enough] or ["none found"]
    others = [change.text for change in changes if not change.enough]
    return "\n".join((f"changes that make {what} safe, each alone:", *indented((*enough, *others))))


def loop_text(drive: Machine, found: ResonanceSummary) -> list[str]:
    """What people read of loops and lines alone."""
    parts, limit = [], largest_pretension(drive.ropes[0])
    if any(pair.tuning and (pair.tuning.tuned_pretension or 0.0) > limit for pair in found.pairs):
        parts.append(f"Beyond {quantity(limit, 'N')} the cable leaves its elastic range.")
    if found.split:
        tuned = (f"{span} {'-' if v is None else quantity(v, 'N')}" for span, v in found.split.items())
        parts.append(f"under the steady load each span is tuned at its own pretension: {', '.join(tuned)}")
    lines = (
        *(f"Warning: {line}." for line in warnings_of_rest(drive)),
        *([SPRUNG] * (found.motor == HOLDING)),
    )
    return [*parts, *(["\n".join(lines)] if lines else [])]


def summary_text(drive: Machine, found: ResonanceSummary) -> list[str]:
    """Verdict, figures, pairs, and what is left out."""
    head = (drive.title or drive.name, "", f"verdict: {found.verdict}", *indented(found.reasons))
    pairs, parts = pairs_table(found, MOST_PAIRS), ["\n".join(head), "\n".join(aligned(found.figures))]
    if found.nearest_span:
        nearest = f"nearest is the first transverse mode of {found.nearest_span}"
        parts.append(f"Motor {found.motor}; {nearest}.")
    parts.append(NO_PAIR if pairs is None else table_text(pairs))
    return [*parts, *(f"{words[0].upper()}{words[1:]}." for words in found.left_out)]


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


def of_motion(found: ResonanceSummary, judged: AlarmResult) -> ResonanceSummary:
    """The summary whose verdict is that of a planned motion where no excitation is given."""
    if found.verdict != NO_EXCITATION:
        return found
    reasons = (f"of the planned motion: {judged.reasons[0]}", *found.reasons[1:])
    return replace(found, verdict=OF_A_MOTION[judged.verdict], reasons=reasons)
