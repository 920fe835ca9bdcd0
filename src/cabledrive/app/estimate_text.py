"""What was identified, in lines: parameters with their intervals, findings."""

from typing import Any


def parameter_rows(data: dict[str, Any]) -> list[str]:
    """The parameters, aligned."""
    entries = data["parameters"].values()
    level = "" if any(one["value"] is not None and one["low"] is None for one in entries) else " (95 %)"
    rows = [("parameter", "value", f"low{level}", f"high{level}", "unit")]
    for name, entry in data["parameters"].items():
        if entry["value"] is None:
            rows.append((name, "not determined", "", "", entry["unit"]))
        else:
            low, high = ("none" if entry[k] is None else f"{entry[k]:.6g}" for k in ("low", "high"))
            rows.append((name, f"{entry['value']:.6g}", low, high, entry["unit"]))
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    return ["  ".join(f"{c:<{w}}" for c, w in zip(row, [*widths, 0], strict=True)) for row in rows]


def finding_lines(data: dict[str, Any]) -> list[str]:
    """What was found, about the model and about the data."""
    messages = [one["message"] if isinstance(one, dict) else one for one in data["findings"]]
    found = [f"finding: {message}" for message in (*messages, *data.get("unidentifiable", ()))]
    for report in data["data"]:
        found += [f"data: {line}" for line in (*report["repaired"], *report["findings"])]
    return found
