"""What `identify --tension` says: friction at wraps told from friction at bearings."""

from collections.abc import Sequence
from typing import Any

from cabledrive.app.results import Absent, Answer, provenance
from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.column_map import ColumnMap
from cabledrive.identification.logs.reading import read_log
from cabledrive.identification.wrap_friction import FrictionSplit, split_friction

METHOD = "least squares on strokes between reversals, errors of strokes and of the elastic cable"


def split_answer(logs: Sequence[str], tensions: Sequence[float], columns: ColumnMap) -> Answer:
    """Both frictions from logs at their tensions [N]; not complete where they are not told apart."""
    found = split_friction([read_log(log, columns) for log in logs], tensions)
    data = {
        "separated": not found.reason,
        "bearings": _estimate(found.constant),
        "wraps_per_tension": _estimate(found.per_tension),
        "total": [
            {"tension": tension, **_estimate(own)}
            for tension, own in zip(sorted(set(found.tensions)), found.total, strict=True)
        ],
        "strokes": found.strokes,
        "findings": list(found.findings),
    }
    return Answer(
        data=data,
        text=_text(found),
        provenance=provenance(method=METHOD),
        incomplete=None if not found.reason else found.findings[0],
    )


def _estimate(own: Estimate) -> dict[str, Any]:
    if own.reason:
        names = ("value", "low", "high")
        return {"unit": own.unit} | {name: Absent(reason=own.reason) for name in names}
    return {"unit": own.unit, "value": own.value, "low": own.low, "high": own.high}


def _text(found: FrictionSplit) -> str:
    lines = [
        f"All friction at {tension:.4g} N: {_interval(own)}"
        for tension, own in zip(sorted(set(found.tensions)), found.total, strict=True)
    ]
    if not found.reason:
        lines += [
            f"Motor and bearings, at the motor: {_interval(found.constant)}",
            f"Wraps, over the tension: {_interval(found.per_tension)}",
        ]
    lines += [f"{found.strokes} strokes."]
    return "\n".join([*lines, *(f"Finding: {line}." for line in found.findings)])


def _interval(own: Estimate) -> str:
    unit = "N m" if own.unit == "N m" else "N m per N"
    return f"{own.value:.4g} {unit}, 95 % interval {own.low:.4g} to {own.high:.4g}"
