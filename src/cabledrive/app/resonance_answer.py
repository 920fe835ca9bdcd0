"""What `cabledrive resonance` answers: for programs and for people."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from cabledrive.app.results import Absent, figures, known, row
from cabledrive.mechanics.datasheet import largest_pretension, warnings_of_rest
from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.threshold import required_detuning
from cabledrive.report.blocks import table_text
from cabledrive.report.machine.data import figures_table
from cabledrive.report.machine.tables import own_pair, pairs_table
from cabledrive.report.typesetting import quantity
from cabledrive.studies.pair_thresholds import SUM
from cabledrive.studies.resonance import Remedy, ResonanceSummary, sensitivity
from cabledrive.studies.resonance_map import SteadyBranch

LISTED = 6


def resonance_data(
    drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...], load_torque: float = 0.0
) -> dict[str, Any]:
    """The summary as JSON gives it, SI, Hz where the key says so; under a torque on the load [N m]."""
    instability = found.instability
    data = figures(found, found.missing) | {"verdict": found.verdict, "reasons": found.reasons}
    if instability is not None:
        data["instability_region"] = {
            "detuning_hz": instability.distance / (2 * np.pi),
            "half_width_hz": instability.half_width / (2 * np.pi),
            "growth_rate": instability.growth,
            "pulley_amplitude": instability.amplitude,
            "slack": instability.slack,
            "required_detuning_hz": _required(drive, found, load_torque),
        }
        data["sensitivity"] = sensitivity(drive, found.torque, load_torque)
    if found.split:
        data["load_torque"] = load_torque
        data["tuned_pretension_under_load"] = {
            span: known(value, "no pretension in reach tunes it") for span, value in found.split.items()
        }
    data["pairs"] = _pairs_data(found)
    data["warnings"] = list(warnings_of_rest(drive))
    data["remedies"] = [row(change, "change value text") for change in changes]
    return data


def _pairs_data(found: ResonanceSummary) -> list[dict[str, Any]]:
    """Every pair with its threshold; of the pulley mode's 1:2 pairs also ratio and tuned pretension."""
    rows = []
    for pair in found.coupled:
        first, second = pair.transverse_hz
        names = "kind longitudinal_hz span section detuning_hz threshold_torque"
        made = row(pair, names, threshold_torque=pair.reason)
        made |= {"number": pair.numbers[0], "transverse_hz": first}
        if pair.kind == SUM:
            made |= {"second_number": pair.numbers[1], "second_transverse_hz": second}
        own = own_pair(found.pairs, pair)
        if own is not None:
            names = "transverse_frequency_hz=transverse_frequency frequency_ratio=ratio tuned_pretension"
            made |= row(own, names, tuned_pretension=own.reason)
        rows.append(made)
    return rows


def _required(drive: Drive, found: ResonanceSummary, load_torque: float) -> Any:
    model = autoparametric_model(drive, load_torque=load_torque, at_rest=True)
    value = required_detuning(model, found.torque) / (2 * np.pi)
    return (
        value if np.isfinite(value) else Absent(reason="the pulley mode is undamped: no detuning is enough")
    )


def branch_data(branch: SteadyBranch) -> dict[str, Any]:
    """A branch of steady motion as JSON gives it. Returns SI."""
    names = "spans onset folds hopf_points ended torque pulley growth"
    upper, lower = branch.amplitude
    onset = "the branch is not connected to the state of rest"
    return row(branch, names, onset=onset) | {"upper": upper, "lower": lower}


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
