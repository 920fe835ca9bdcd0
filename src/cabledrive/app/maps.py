"""What `map` says, and the ranges of keys that `--vary` gives."""

from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.answers.figures import Row
from cabledrive.answers.keys import Keys
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.keys import quantity_of
from cabledrive.parameters.units import to_si
from cabledrive.report.blocks import listed, table_text
from cabledrive.report.machine.tables import zones_table
from cabledrive.report.words import HELD, speed_unit
from cabledrive.studies.excitation_orders import Campbell, Zone
from cabledrive.studies.sway import Sway, SwayingRope

if TYPE_CHECKING:
    import xarray as xr

OWN = ("longitudinal_hz", "transverse_hz", "coordinate_hz")
MOST_LINES = 12
"""Zones that the text lists."""


def map_answer(drive: Machine, found: "xr.Dataset", excited: Campbell | None) -> tuple[dict[str, Any], str]:
    """JSON object and text of a map."""
    dims = [str(dim) for dim in found["certified"].dims]
    refused = found["reason"].values.ravel()
    data: dict[str, Any] = {
        "keys": [str(key) for key, own in found.coords.items() if own.dims and own.dims[0] in dims],
        "shape": [int(found.sizes[dim]) for dim in dims],
        "outputs": [str(name) for name in found.data_vars],
        "motor": found.attrs["motor"],
        "certified_points": int(np.sum(found["certified"].values)),
        "points_without_modes": int(np.sum(refused != "")),
        "ranges": [row for name in OWN if name in found for row in _ranges(found, name, dims)],
    }
    if data["points_without_modes"]:
        data["first_reason"] = str(next(reason for reason in refused if reason))
    size = " x ".join(str(n) for n in data["shape"])
    over = f"{size} points over {', '.join(data['keys'])}; motor {HELD[data['motor']]}"
    certified = f"{over}; certified at {data['certified_points']}."
    rows = table_text(listed("", RANGES, data["ranges"]))
    text = [drive.title or drive.name, certified, "", rows]
    if data["points_without_modes"]:
        text.append(
            f"{data['points_without_modes']} points have no modes, the first: {data['first_reason']}."
        )
    if excited is not None:
        data |= EXCITED(excited) | {
            "speed": {"key": excited.coordinate, "low": excited.low, "high": excited.high},
            "orders": [{"name": name, "hz_per_speed": rate} for name, rate in excited.orders.items()],
            "clear": [{"low": low, "high": high} for low, high in excited.clear],
        }
        text += ["", *_speeds(excited)]
    return data, "\n".join(text)


def _ranges(found: "xr.Dataset", name: str, dims: list[str]) -> list[dict[str, Any]]:
    """Lowest and highest frequency of each mode or coordinate over the map, and where they are."""
    rows = []
    other = next(dim for dim in found[name].dims if dim not in dims)
    for label in found[other].values:
        own = found[name].sel({other: label})
        if not np.isfinite(own.values).any():
            continue
        places = [np.unravel_index(pick(own.values), own.shape) for pick in (np.nanargmin, np.nanargmax)]
        low, high = (
            {"frequency_hz": float(own.values[place])}
            | {dim: float(found[dim].values[i]) for dim, i in zip(dims, place, strict=True)}
            for place in places
        )
        plain = int(label) if isinstance(label, np.integer) else str(label)
        rows.append({"output": name, str(other): plain, "lowest": low, "highest": high})
    return rows


RANGES = (
    Row("output", "of", form=lambda name: name.removesuffix("_hz"), kind="text"),
    Row("mode", "mode", form="d"),
    Row("coordinate", "coordinate", kind="text"),
    Row("lowest.frequency_hz", "lowest", "Hz", ".6g"),
    Row("highest.frequency_hz", "highest", "Hz", ".6g"),
)


ZONE = Keys("order mode kind low high place_low place_high weight", of=Zone)
EXCITED = Keys("covered_hz=covered covered_certified=certified zones", parts={"zones": ZONE}, of=Campbell)
SWAY = Keys(
    "keys places bottom top ropes",
    parts={"ropes": Keys("name frequency_hz amplitude", of=SwayingRope)},
    of=Sway,
)

SWAYING = Keys("texts: warnings assumptions", also=(SWAY,))
MAP = Keys(
    "texts: keys outputs text: motor first_reason? numbers: shape count: certified_points "
    "points_without_modes rows: ranges{text: output coordinate? any: mode? map: lowest highest} number: "
    "covered_hz? flag: covered_certified? rows: orders{text: name number: hz_per_speed}? "
    "clear{number: low high}? zones? object: speed{text: key number: low high}?",
    parts={"zones": ZONE},
)


def _speeds(found: Campbell) -> list[str]:
    """What was searched, what to avoid and what is clear."""
    proof, unit = "certified" if found.certified else "not certified", speed_unit(found.coordinate)
    lines = [f"Order {name}: {rate:.5g} Hz per {unit}." for name, rate in found.orders.items()]
    searched = (
        f"Searched up to {found.covered:.4g} Hz ({proof} complete): {len(found.branches)} distinct modes."
    )
    return [*lines, searched, "", table_text(zones_table(found, MOST_LINES))]


ALONE, EACH = 31, 11
"""Values of a key where no number is given: of the only one, of several."""


def vary_of(drive: Machine, texts: tuple[str, ...]) -> dict[tuple[str, ...], np.ndarray]:
    """Values by keys, from texts such as "head.x=60mm:360mm:30" or "car.y=5m:35m,counterweight.y=35m:5m"."""
    found: dict[tuple[str, ...], np.ndarray] = {}
    for text in texts:
        keys, ends, numbers = [], [], set()
        for part in text.split(","):
            key, low, high, number = _range(drive, part)
            keys.append(key)
            ends.append((low, high))
            numbers |= {number} - {None}
        if len(numbers) > 1:
            raise InputRefused(f'--vary "{text[:80]}": keys that move together need one number of values')
        count = numbers.pop() if numbers else ALONE if len(texts) == 1 else EACH
        assert count is not None
        found[tuple(keys)] = np.array([np.linspace(low, high, count) for low, high in ends])
    return found


def _range(drive: Machine, text: str) -> tuple[str, float, float, int | None]:
    key, equals, rest = text.strip().partition("=")
    steps = rest.split(":")
    if not equals or len(steps) not in (2, 3):
        raise InputRefused(
            f'--vary "{text[:80]}" is not KEY=FROM:TO or KEY=FROM:TO:N: write, for instance, '
            "head.x=60mm:360mm:13"
        )
    key = key.strip()
    try:
        unit, _ = quantity_of(drive, key)
        low, high = (to_si(step, unit) for step in steps[:2])
    except InputRefused as refusal:
        raise refusal.at(f"--vary {key[:60]}") from None
    if len(steps) == 2:
        return key, low, high, None
    if not (steps[2].strip().isascii() and steps[2].strip().isdigit() and 1 <= int(steps[2]) <= 20_000):
        raise InputRefused(f'--vary {key}: "{steps[2][:20]}" is no number of values: write 1 to 20000')
    return key, low, high, int(steps[2])
