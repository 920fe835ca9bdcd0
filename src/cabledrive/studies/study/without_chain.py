"""A study of a machine without a chain: modes, resonance, margins, and why there is no controller."""

from typing import Any

from cabledrive.mechanics.network.span_table import pulley_rows, route_warnings, span_rows
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.modal import modes
from cabledrive.parameters import InputRefused, NotComputed, content_hash
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.studies.route_pairs import route_resonance

COUNT = 6
METHOD = "certified modes, pairs near internal resonance, tensions at rest"
REMEDY = "name another axis (--axis), or give a machine whose load is the end of a chain"


def study_without_chain(drive: RoutedDrive, why: str, logs: int) -> dict[str, Any]:
    """Plain data of a study's results, SI; ``why``: no controller; ``logs``: how many were given."""
    found, statics = modes(drive, count=COUNT), statics_of(drive)
    spans, pulleys = span_rows(drive, statics), pulley_rows(drive, statics)
    resonance, reasons = _resonance(drive)
    cautions = [*route_warnings(drive), *found.warnings]
    if logs:
        cautions.append(f"{logs} logs were not used: without a chain there is nothing to identify")
    return {
        "verdict": "unknown",
        "headline": f"no controller: {why}",
        "candidates": [],
        "reasons": [f"no controller: {why}", *reasons],
        "findings": [
            {"id": "no-chain", "value": None, "value_reason": why, "limit": None, "unit": "", "decides": True}
        ],
        "remedies": [REMEDY],
        "cautions": cautions,
        "margins": {
            "lowest_tension": min(min(row["tension_start"], row["tension_end"]) for row in spans),
            "safety_factor": min(
                (row["safety_factor"] for row in spans if row["safety_factor"] is not None), default=None
            ),
            "spans": spans,
            "pulleys": pulleys,
        },
        "drive": drive.name,
        "drive_hash": content_hash(drive),
        "stages": {
            "modes": {
                "longitudinal_hz": [mode.frequency for mode in found.longitudinal],
                "transverse_hz": [mode.frequency for mode in found.transverse],
                "certified": found.certified,
                "certified_reason": found.certified_reason,
            },
            "resonance": resonance,
        },
        "provenance": {
            "cabledrive": __version__,
            "drive": drive.name,
            "drive_hash": content_hash(drive),
            "method": METHOD,
        },
    }


def _resonance(drive: RoutedDrive) -> tuple[dict[str, Any] | None, list[str]]:
    """The internal resonance, and what it says."""
    try:
        found = route_resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        return None, [f"internal resonance not computed: {refusal}"]
    data = {
        "verdict": found.verdict,
        "threshold_torque": found.threshold_torque,
        "longitudinal_hz": found.longitudinal_hz,
        "frequency_ratio": found.frequency_ratio,
        "nearest_span": found.nearest_span,
    }
    return data, [f"internal resonance: {found.verdict}; {found.reasons[0]}"]
