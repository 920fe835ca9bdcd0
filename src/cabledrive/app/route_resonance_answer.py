"""What `resonance` says of a machine with routes: pairs near 1:2 and of sum type, with their thresholds."""

from typing import Any

from cabledrive.app.results import Absent, Answer, provenance
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM
from cabledrive.studies.route_pairs import NOT_INCLUDED, RoutePair, RouteResonance, route_resonance

METHOD = "exact modes of the network, coupling by exact integrals, first-order instability"
LISTED = 12


def route_resonance_answer(drive: RoutedDrive, torque: float | None) -> Answer:
    """The answer of `resonance`; ``torque``: amplitude of the verdict [N m], default: the torque limit."""
    found = route_resonance(drive, torque=torque)
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
        "torque": Absent(reason="no torque is given and the file has no torque limit")
        if found.torque is None
        else found.torque,
        "pairs": [_row(pair) for pair in found.pairs],
        "motor": found.motor,
        "certified": found.certified,
        "warnings": [f"not included: {NOT_INCLUDED}"],
    }
    return Answer(data=data, text=_text(drive, found, data), provenance=provenance(drive, method=METHOD))


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
    from cabledrive.report.numbers import quantity

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
    return "\n".join([*lines, "", f"Not included: {NOT_INCLUDED}."])
