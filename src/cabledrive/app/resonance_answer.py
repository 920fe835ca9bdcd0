"""What `cabledrive resonance` answers: for programs and for people."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cabledrive.answers.keys import Keys
from cabledrive.mechanics.datasheet import largest_pretension, warnings_of_rest
from cabledrive.modal.tuning import Pair
from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.threshold import required_detuning
from cabledrive.report.blocks import table_text
from cabledrive.report.machine.data import figures_table
from cabledrive.report.machine.tables import own_pair, pairs_table
from cabledrive.report.typesetting import quantity
from cabledrive.studies.alarm import AlarmResult
from cabledrive.studies.pair_thresholds import SUM, CoupledPair
from cabledrive.studies.resonance import Remedy, ResonanceSummary, sensitivity
from cabledrive.studies.resonance_detuning import InstabilityMargin
from cabledrive.studies.resonance_map import SteadyBranch

LISTED = 6
DIVERGES = "the motion diverges"
ALARM = Keys(
    "verdict limit floor largest_transverse estimate_with_changes=changed reasons assumptions remedy slack "
    "lowest_tension modes",
    dict.fromkeys(("largest_transverse", "estimate_with_changes", "lowest_tension"), DIVERGES),
    of=AlarmResult,
)
UNDAMPED = "the pulley mode is undamped: no detuning is enough"
REGION = Keys("growth_rate=growth pulley_amplitude=amplitude slack", of=InstabilityMargin)
PAIR = Keys(
    "kind longitudinal_hz span section detuning_hz threshold_torque number=numbers.0 "
    "transverse_hz=transverse_hz.0",
    {"threshold_torque": ".reason"},
    of=CoupledPair,
)
SECOND = Keys("second_number=numbers.1 second_transverse_hz=transverse_hz.1", of=CoupledPair)
OWN = Keys(
    "transverse_frequency_hz=transverse_frequency frequency_ratio=ratio tuned_pretension",
    {"tuned_pretension": ".reason"},
    of=Pair,
)
REMEDY = Keys("change value text", {"value": "no value within reach is enough"}, of=Remedy)
SUMMARY = Keys("* verdict reasons", of=ResonanceSummary)
BRANCH = Keys(
    "spans onset folds hopf_points ended torque pulley growth upper=amplitude.0 lower=amplitude.1",
    {"onset": "the branch is not connected to the state of rest"},
    of=SteadyBranch,
)

OF_PAIRS = (
    "count: second_number? number: second_transverse_hz? transverse_frequency_hz? frequency_ratio? "
    "tuned_pretension?"
)
ANSWER = Keys(
    "text: motor texts: warnings number: load_torque? rows: pairs remedies branches? object: motion? "
    "instability_region? map: sensitivity? tuned_pretension_under_load?",
    {"tuned_pretension_under_load": "no pretension in reach tunes it"},
    parts={
        "pairs": Keys(OF_PAIRS, also=(PAIR,)),
        "remedies": REMEDY,
        "branches": BRANCH,
        "instability_region": Keys(
            "number: detuning_hz half_width_hz required_detuning_hz",
            {"required_detuning_hz": UNDAMPED},
            also=(REGION,),
        ),
        "motion": Keys("text: motor", also=(ALARM,)),
    },
    also=(SUMMARY,),
)


def resonance_data(
    drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...], load_torque: float = 0.0
) -> dict[str, Any]:
    """The summary as JSON gives it, SI, Hz where the key says so; under a torque on the load [N m]."""
    data = SUMMARY(found)
    if found.instability is not None:
        model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)
        required = required_detuning(model, found.torque) / (2 * np.pi)
        data["instability_region"] = REGION(found.instability) | {
            "detuning_hz": found.instability.distance / (2 * np.pi),
            "half_width_hz": found.instability.half_width / (2 * np.pi),
            "required_detuning_hz": required if np.isfinite(required) else None,
        }
        data["sensitivity"] = sensitivity(drive, found.torque, load_torque)
    if found.split:
        data["load_torque"] = load_torque
        data["tuned_pretension_under_load"] = found.split
    data["pairs"] = []
    for pair in found.coupled:  # of the pulley mode's 1:2 pairs also ratio and tuned pretension
        own = own_pair(found.pairs, pair)
        second = SECOND(pair) if pair.kind == SUM else {}
        data["pairs"].append(PAIR(pair) | second | ({} if own is None else OWN(own)))
    data |= {"warnings": warnings_of_rest(drive), "remedies": [REMEDY(change) for change in changes]}
    return ANSWER(data)


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


def resonance_text(drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...]) -> str:
    """The summary for people."""
    parts = [
        "\n".join((drive.title or drive.name, "", f"verdict: {found.verdict}", *indented(found.reasons)))
    ]
    parts.append(table_text(figures_table(found, "")))
    if (pairs := pairs_table(found, LISTED)) is not None:
        parts.append(table_text(pairs))
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
    if warnings := warnings_of_rest(drive):
        parts.append("\n".join(f"Warning: {line}." for line in warnings))
    return "\n\n".join(parts)


def indented(lines: Iterable[str]) -> list[str]:
    """Lines under another one."""
    return [f"  {line}" for line in lines]
