"""Places of a file that are written relative to one length, `shaft`: a lift is stretched by one key."""

import re
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.units import to_si

KEY = "shaft"
RELATIVE = r"^\s*([+-]?[0-9.]+\s*\*?\s*)?shaft\b"
"""How such a place begins: "shaft", "0.5 shaft - 1 m"."""
_TERM = re.compile(r"\s*(?P<factor>[+-]?[0-9]*\.?[0-9]*)\s*\*?\s*shaft\s*(?:(?P<sign>[+-])\s*(?P<rest>.+))?")
_PLACES = {"body": ("at", "pivot", "travel"), "pulley": ("at",), "anchor": ("at",)}


def with_shaft(data: dict[str, Any]) -> dict[str, Any]:
    """Plain data of a file, its relative places in metres; refused without a shaft of a length above 0."""
    given = data.get(KEY)
    length = None
    if given is not None:
        length = to_si(given, "m") if isinstance(given, str) else given
        if isinstance(length, bool) or not isinstance(length, (int, float)) or not 0.0 < length < 1e6:
            raise InputRefused(f'{KEY} = {str(given)[:40]} is no length above 0: write, for instance, "60 m"')
    found = {key: value for key, value in data.items() if key != KEY}
    for table, keys in _PLACES.items():
        rows = found.get(table)
        if isinstance(rows, list):
            found[table] = [
                {key: _placed(value, length) if key in keys else value for key, value in row.items()}
                if isinstance(row, dict)
                else row
                for row in rows
            ]
    return found


def _placed(value: Any, shaft: float | None) -> Any:
    """A place, a range or a list of them with every relative quantity in metres."""
    if isinstance(value, list):
        return [_placed(part, shaft) for part in value]
    if not isinstance(value, str) or KEY not in value:
        return value
    if ":" in value:
        return ":".join(f"{part!r} m" if isinstance(part := _placed(end, shaft), float) else part
                        for end in value.split(":"))  # fmt: skip
    match = _TERM.fullmatch(value)
    if match is None:
        raise InputRefused(f'"{value[:60]}" is no place: write shaft, shaft - 2 m or 0.5 shaft + 1 m')
    if shaft is None:
        raise InputRefused(f'"{value[:60]}" needs {KEY} = "..." at the head of the file: add it')
    factor = match["factor"]
    whole = float(factor if factor not in ("", "+", "-") else f"{factor}1") * shaft
    rest = 0.0 if match["rest"] is None else to_si(match["rest"], "m")
    return whole - rest if match["sign"] == "-" else whole + rest
