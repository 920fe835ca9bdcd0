"""What `resonance` says of a machine with routes: pairs near 1:2 and of sum type, with their thresholds."""

from dataclasses import replace
from typing import Any

from cabledrive.app.motion_answer import PLANE_WORDS, alarm_data, alarm_text
from cabledrive.app.results import Absent, Answer, provenance
from cabledrive.mechanics.holding import FREE
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.motion_file import read_motion
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM
from cabledrive.studies.resonance_detuning import NO_EXCITATION, OF_A_MOTION, STATE_ONE
from cabledrive.studies.route_alarm import route_alarm
from cabledrive.studies.route_pairs import RoutePair, RouteResonance, route_resonance
from cabledrive.studies.route_passages import Passage

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
