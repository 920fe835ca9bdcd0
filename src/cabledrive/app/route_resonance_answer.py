"""What `resonance` says of a machine with routes: pairs near 1:2 and of sum type, with their thresholds."""

from typing import Any

from cabledrive.app.results import Absent, Answer, provenance
from cabledrive.parameters import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM
from cabledrive.studies.route_pairs import NOT_INCLUDED, RoutePair, RouteResonance, route_resonance

METHOD = "exact modes of the network, coupling by exact integrals, first-order instability"
LISTED = 12
CLOSE = 0.5
"""Share of the lowest threshold from which a torque is called close."""


def route_resonance_answer(drive: RoutedDrive, torque: float | None) -> Answer:
    """The answer of `resonance`; ``torque``: amplitude of the verdict [N m], default: the torque limit."""
    if torque is not None and torque < 0.0:
        raise InputRefused(f"--torque = {torque:.9g} N m must not be negative")
    found = route_resonance(drive)
    limit = drive.motor[0].torque_limit if drive.motor else None
    asked = torque if torque is not None else limit
    lowest = min(
        (pair.threshold_torque for pair in found.pairs if pair.threshold_torque is not None), default=None
    )
    verdict, reasons = _verdict(asked, lowest)
    data: dict[str, Any] = {
        "frequency_ratio": found.frequency_ratio,
        "longitudinal_hz": found.longitudinal_hz,
        "nearest_span": found.nearest_span,
        "tuned_pretension": Absent(reason="on a machine with routes the tensions follow from statics"),
        "threshold_torque": Absent(reason="no pair that the first motor excites is near")
        if lowest is None
        else lowest,
        "detuning": found.frequency_ratio - 0.5,
        "verdict": verdict,
        "reasons": reasons,
        "torque": Absent(reason="no torque is given and the file has no torque limit")
        if asked is None
        else asked,
        "pairs": [_row(pair) for pair in found.pairs],
        "motor": found.motor,
        "certified": found.certified,
        "warnings": [f"not included: {NOT_INCLUDED}"],
    }
    return Answer(data=data, text=_text(drive, found, data), provenance=provenance(drive, method=METHOD))


def _verdict(asked: float | None, lowest: float | None) -> tuple[str, list[str]]:
    if lowest is None:
        return "safe", ["no listed pair is excited by the first motor"]
    if asked is None:
        return "unknown", ["no torque is given: add --torque, or motor.torque_limit to the file"]
    words = f"the lowest threshold is {lowest:.4g} N m of steady torque at a longitudinal frequency, "
    words += f"the torque {asked:.4g} N m"
    if asked >= lowest:
        return "resonant", [words]
    return ("close" if asked >= CLOSE * lowest else "safe"), [words]


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
