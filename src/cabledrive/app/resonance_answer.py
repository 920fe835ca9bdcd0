"""What `cabledrive resonance` answers: for programs and for people."""

from typing import Any

import numpy as np

from cabledrive.app.results import Absent, known, row
from cabledrive.mechanics.warnings import largest_pretension, warnings_of_rest
from cabledrive.modal.tuning import Pair
from cabledrive.parameters import Drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.threshold import required_detuning
from cabledrive.studies.pair_thresholds import SUM, CoupledPair
from cabledrive.studies.resonance import ResonanceSummary
from cabledrive.studies.resonance_remedies import Remedy, sensitivity
from cabledrive.studies.steady_motion import SteadyBranch

LISTED = 6
NUMBERS = ("frequency_ratio", "tuned_pretension", "threshold_torque", "detuning")


def resonance_data(
    drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...], load_torque: float = 0.0
) -> dict[str, Any]:
    """The summary as JSON gives it, SI, Hz where the key says so; under a torque on the load [N m]."""
    instability = found.instability
    data: dict[str, Any] = {name: _number(found, name) for name in NUMBERS}
    data |= {"verdict": found.verdict, "reasons": found.reasons, "torque": found.torque}
    data |= {"pulley_frequency_hz": _number(found, "pulley_frequency")}
    data |= {
        "threshold_torque_at_own_pretension": _number(found, "threshold_here"),
        "tenfold_growth_torque": _number(found, "growth_torque"),
        "coulomb_onset_torque": _number(found, "coulomb_onset"),
    }
    if instability is not None:
        data["instability_region"] = {
            "detuning_hz": instability.distance / (2 * np.pi),
            "half_width_hz": instability.half_width / (2 * np.pi),
            "growth_rate": instability.growth,
            "pulley_amplitude": instability.amplitude,
            "slack": instability.slack,
            "required_detuning_hz": _required(drive, found, load_torque),
        }
        data["sensitivity"] = _sensitivity_data(drive, found.torque, load_torque)
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
        own = next((own for own in found.pairs if _same(own, pair)), None)
        if own is not None:
            names = "transverse_frequency_hz=transverse_frequency frequency_ratio=ratio tuned_pretension"
            made |= row(own, names, tuned_pretension=own.reason)
        rows.append(made)
    return rows


def _same(own: Pair, pair: CoupledPair) -> bool:
    """Whether two records are of one mode of one section beside the pulley mode."""
    ends = all(abs(a - b) <= 1e-9 * pair.section[1] for a, b in zip(own.section, pair.section, strict=True))
    pulley = abs(pair.longitudinal_hz / own.pulley_frequency - 1.0) < 1e-9
    return pair.kind != SUM and pulley and ends and own.span == pair.span and own.number == pair.numbers[0]


def _sensitivity_data(drive: Drive, torque: float, load_torque: float) -> dict[str, float]:
    slopes = sensitivity(drive, torque, load_torque)
    return {
        "detuning_hz_per_pretension": slopes.detuning_per_pretension / (2 * np.pi),
        "detuning_hz_per_inertia": slopes.detuning_per_inertia / (2 * np.pi),
        "threshold_per_transverse_damping": slopes.threshold_per_transverse_damping,
        "threshold_per_friction": slopes.threshold_per_friction,
    }


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
    from cabledrive.report.typesetting import quantity

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


def _number(found: ResonanceSummary, name: str) -> Any:
    why = found.missing.get(name, "the spans go slack before any torque does this")
    return known(getattr(found, name), why)


def resonance_text(drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...]) -> str:
    """The summary for people."""
    from cabledrive.report.typesetting import quantity

    lines = [
        drive.title or drive.name,
        "",
        f"verdict: {found.verdict}",
        *(f"  {reason}" for reason in found.reasons),
    ]
    named = (
        ("frequency ratio", found.frequency_ratio, "1"),
        ("detuning, ratio - 1/2", found.detuning, "1"),
        ("pulley mode", found.pulley_frequency, "Hz"),
        ("tuned pretension", found.tuned_pretension, "N"),
        ("threshold torque, tuned", found.threshold_torque, "N m"),
        ("threshold torque, as given", found.threshold_here, "N m"),
        ("tenfold growth in 1 s, tuned", found.growth_torque, "N m"),
        ("no growth below (Coulomb)", found.coulomb_onset, "N m"),
        ("torque of these figures", found.torque, "N m"),
    )
    lines += ["", *(f"{label:<30}{_shown(value, unit, quantity)}" for label, value, unit in named)]
    if found.pairs:
        lines += ["", "pairs with the pulley mode:"]
        for pair in found.pairs:
            if not _listed(pair, found.pairs):
                continue
            tuned = _shown(pair.tuned_pretension, "N", quantity)
            if (pair.tuned_pretension or 0.0) > largest_pretension(drive):
                tuned += ", beyond the cable's elastic range"
            where = f"{pair.span}, {pair.section[0]:.4g} to {pair.section[1]:.4g} m, m = {pair.number}"
            lines.append(f"  {where:<32} ratio {pair.ratio:.4f}   tuned at {tuned}")
        lines += ["", "thresholds, lowest first:", *_threshold_lines(found, quantity)]
    if found.split:
        tuned = ", ".join(f"{span} {_shown(value, 'N', quantity)}" for span, value in found.split.items())
        lines += ["", f"under the steady load each span is tuned at its own pretension: {tuned}"]
    if changes:
        lines += ["", "changes that make it safe, each alone:"]
        lines += [f"  {change.text}" for change in changes if change.enough] or ["  none found"]
        lines += [f"  {change.text}" for change in changes if not change.enough]
    lines += [f"Warning: {line}." for line in warnings_of_rest(drive)]
    return "\n".join(lines)


def _listed(pair: Pair, pairs: tuple[Pair, ...]) -> bool:
    """Whether the text lists a pair: the lowest of each section, and the nearest to 1:2."""
    own = [other for other in pairs if (other.span, other.section) == (pair.span, pair.section)]
    return pair.number <= 3 or pair is min(own, key=lambda other: abs(other.detuning))


def _threshold_lines(found: ResonanceSummary, quantity: Any) -> list[str]:
    """The pairs that the least torque excites."""
    lines = []
    for pair in found.coupled[:LISTED]:
        numbers = " + ".join(str(number) for number in dict.fromkeys(pair.numbers))
        torque = "no torque" if pair.threshold_torque is None else quantity(pair.threshold_torque, "N m")
        lines.append(
            f"  {pair.kind}, {pair.longitudinal_hz:.4g} Hz with {pair.span}, {pair.section[0]:.4g} to "
            f"{pair.section[1]:.4g} m, m = {numbers}: {torque}, detuned by {pair.detuning_hz:.3g} Hz"
        )
    left = len(found.coupled) - len(lines)
    return [*lines, f"  and {left} more (--json)"] if left > 0 else lines


def _shown(value: float | None, unit: str, quantity: Any) -> str:
    return "-" if value is None else quantity(value, unit)
