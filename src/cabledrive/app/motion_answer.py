"""What `cabledrive resonance --motion` answers of a motion: for programs and for people."""

from typing import Any

import numpy as np

from cabledrive.app.results import Absent
from cabledrive.studies.alarm import AlarmResult

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
    from cabledrive.report.numbers import quantity

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
