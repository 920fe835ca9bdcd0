"""Every quantity of a drive file as a field, and settings written into its text."""

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from cabledrive.parameters import Machine, drive_schema, drive_text
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route.strain_free import POSE
from cabledrive.parameters.tables import with_shaft
from cabledrive.parameters.units import to_si

LEFT_OUT = {"schema", "name", "kind", "title", "source"}
"""Of the head of a file: what the text alone changes."""
TITLES = {"lumped": "Measured, lumped"}
"""Of tables that are not called by their key."""
POSITION = "Bodies, with all that they carry."
OF_TWO = ("Drive pulley", "Load pulley")
_UNIT = re.compile(r"^(.*?)\s*\[([^\]]+)\]$", re.DOTALL)
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*")


@dataclass(frozen=True, slots=True)
class Field:
    """One key of the file."""

    key: str  # as ``--set`` takes it
    label: str
    help: str
    unit: str
    base: str  # value of the text, without settings; empty where the text is silent
    value: str  # with settings
    default: str = ""  # what holds where nothing is written
    choices: tuple[str, ...] = ()  # values it may take; empty for a quantity or words
    number: float | None = None  # number of the base value in its own unit, where a slider can move it
    suffix: str = ""  # unit written behind the base value


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """A table of the file."""

    title: str
    help: str
    given: bool  # whether the text has it
    fields: tuple[Field, ...]


def groups_of(tables: Mapping[str, Any], settings: Sequence[tuple[str, str]]) -> list[Group]:
    """The form of a file. ``tables``: plain tables of the text; ``settings``: made on them."""
    schema = _schema()["then" if tables.get("kind") == "route" else "else"]["properties"]
    made = dict(settings)
    groups = []
    for name, part in schema.items():
        if name not in LEFT_OUT:
            groups += list(_groups(name, part, tables.get(name), made))
    bodies = _in_metres(tables, made).get("body")
    rows = bodies if isinstance(bodies, list) else []
    poses = [field for body in rows if isinstance(body, dict) for field in _pose(body, made)]
    if tables.get("kind") == "route" and poses:
        groups.insert(0, Group(title="Position", help=POSITION, given=True, fields=tuple(poses)))
    return groups


def _in_metres(tables: Mapping[str, Any], made: Mapping[str, str]) -> Mapping[str, Any]:
    """The tables with places relative to a shaft as lengths, which a slider can move."""
    try:
        return with_shaft({**tables, "shaft": made["shaft"]} if "shaft" in made else dict(tables))
    except InputRefused:
        return tables


def _pose(body: Mapping[str, Any], made: Mapping[str, str]) -> Iterator[Field]:
    """Where a body of a machine with routes can be moved; what it carries moves with it."""
    name, moves, at = body.get("name"), body.get("moves", ()), body.get("at")
    if not isinstance(name, str) or not isinstance(at, list) or len(at) != 2:
        return
    for move in (moves,) if isinstance(moves, str) else moves:
        if move in POSE:
            place = at["xy".index(move)] if move != "turn" else "0 deg"
            key, base = f"{name}.{move}", f"{place:g} m" if isinstance(place, float) else _shown(place)
            words = "angle from the pose of the file" if move == "turn" else f"new {move} of the body"
            yield _made(key, f"{name} {move}", (words, POSE[move]), base, made)


def field_of_refusal(groups: Sequence[Group], words: str) -> str:
    """The key that a refusal is about: the longest one that it names; empty where it names none."""
    fields = [field for group in groups for field in group.fields]
    keys = ((own.key, rf"(?<![\w.]){re.escape(own.key)}(?![\w.]\w)") for own in fields)
    if named := [key for key, pattern in keys if re.search(pattern, words)]:
        return max(named, key=len)
    changed = [own.key for own in fields if own.value != own.base]
    about = [key for key in changed if re.search(rf"\b{re.escape(key.rpartition('.')[2])}\b", words)]
    return about[0] if len(about) == 1 else ""


_schema = lru_cache(maxsize=1)(drive_schema)


def _groups(name: str, part: Mapping[str, Any], table: Any, made: Mapping[str, str]) -> Iterator[Group]:
    if part.get("type") == "array" or isinstance(table, list):
        items = part.get("items", part)
        for number, row in enumerate(table if isinstance(table, list) else []):
            yield _group(f"{name}.{number}", _named(name, number, row), items, row, made)
        return
    yield _group(name, TITLES.get(name, name.capitalize()), part, table, made)


def _named(name: str, number: int, row: Any) -> str:
    if isinstance(row, dict) and isinstance(row.get("name"), str) and row["name"]:
        return f"{TITLES.get(name, name.capitalize())} {row['name']}"
    if name == "pulley" and number < len(OF_TWO):
        return OF_TWO[number]
    return f"{TITLES.get(name, name.capitalize())} {number}"


def _group(place: str, title: str, part: Mapping[str, Any], table: Any, made: Mapping[str, str]) -> Group:
    row = table if isinstance(table, dict) else {}
    properties = part.get("properties", {})
    fields = (_field(f"{place}.{key}", entry, row.get(key), made) for key, entry in properties.items())
    return Group(
        title=title,
        help=part.get("description", "").replace("`", ""),
        given=bool(row) or any(key.startswith(f"{place}.") for key in made),
        fields=tuple(field for field in fields if field is not None),
    )


def _field(key: str, entry: Mapping[str, Any], written: Any, made: Mapping[str, str]) -> Field | None:
    """The field of a key; none for arrays, which the text alone changes."""
    if isinstance(written, list | dict) or entry.get("type") in ("array", "object"):
        return None
    meaning = str(entry.get("description", "")).replace("`", "")
    match = _UNIT.match(meaning)
    words, unit = (match[1], match[2]) if match else (meaning, "")
    choices = (True, False) if entry.get("type") == "boolean" else entry.get("enum", ())
    own = _made(key, key.rpartition(".")[2].replace("_", " "), (words, unit), _shown(written), made)
    return replace(own, default=_shown(entry.get("default")), choices=tuple(map(_shown, choices)))


def _made(key: str, label: str, about: tuple[str, str], base: str, made: Mapping[str, str]) -> Field:
    """A field with its help and unit; ``base``: what the text says; ``made``: the settings."""
    number, suffix = _parted(base, about[1])
    value = made.get(key, base)
    return Field(key, label, *about, base=base, value=value, number=number, suffix=suffix)


def _shown(value: Any) -> str:
    """A value as a person writes it into the field."""
    if value is None or isinstance(value, list | dict):
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _parted(text: str, unit: str) -> tuple[float | None, str]:
    """Number and unit of a quantity that a slider can move: one above zero."""
    match = _NUMBER.match(text)
    if not unit or match is None:
        return None, ""
    try:
        value = to_si(text, unit if unit != "count" else "1")
    except InputRefused:
        return None, ""
    number = float(match[0])
    return (number, text[match.end() :].strip()) if value > 0.0 else (None, "")


_HEADER = re.compile(r"\s*(\[\[?)\s*([A-Za-z0-9_-]+)\s*\]\]?\s*(#.*)?$")
_LINE = re.compile(
    r"(?P<head>\s*(?P<key>[A-Za-z0-9_-]+)\s*=\s*)"
    r"(?P<value>\"(?:[^\"\\]|\\.)*\"|'[^']*'|[^\s#\"'\[{][^#]*?)(?P<rest>\s*(#.*)?)$"
)


def text_with(text: str, drive: Machine, settings: tuple[tuple[str, str], ...]) -> str:
    """The text that describes a drive: settings put into its own lines, or the drive written anew."""
    if not settings:
        return text
    lines = text.split("\n")
    for key, value in settings:
        lines = _with(lines, key, _toml(value))
    edited = "\n".join(lines)
    with suppress(InputRefused):
        if drive_from_text(edited) == drive:
            return edited
    return drive_text(drive)  # takes both kinds


def _with(lines: list[str], key: str, value: str) -> list[str]:
    """Replace the value of a key, or add it at the end of its table."""
    place, _, name = key.rpartition(".")
    end = None
    for number, (here, line) in enumerate(zip(_places(lines), lines, strict=True)):
        if here != place:
            continue
        if line.strip() and not line.lstrip().startswith("#"):
            end = number + 1
        match = _LINE.match(line)
        if match and match["key"] == name:
            return [*lines[:number], f"{match['head']}{value}{match['rest']}", *lines[number + 1 :]]
    if end is not None:
        return [*lines[:end], f"{name} = {value}", *lines[end:]]
    return [*lines, f"[{place}]", f"{name} = {value}", ""] if place else lines


def _places(lines: list[str]) -> list[str]:
    """The table in which each line stands: "cable", "pulley.1"; empty at the head."""
    found, place, counts = [], "", dict[str, int]()
    for line in lines:
        match = _HEADER.match(line)
        if match:
            place = match[2]
            if match[1] == "[[":
                counts[place] = counts.get(place, -1) + 1
                place = f"{place}.{counts[place]}"
        found.append(place)
    return found


def _toml(text: str) -> str:
    """A value as TOML: as it stands where it is TOML, else as text, see ``load_drive``."""
    with suppress(tomllib.TOMLDecodeError, RecursionError, ValueError):
        if list(tomllib.loads(f"value = {text}")) == ["value"] and "\n" not in text:
            return text.strip()
    return json.dumps(text, ensure_ascii=False)
