"""Settings written into the text of a drive file, its comments kept."""

import json
import re
import tomllib
from contextlib import suppress

from cabledrive.parameters import Drive, InputRefused, drive_text
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.parameters.route import RoutedDrive

_HEADER = re.compile(r"\s*(\[\[?)\s*([A-Za-z0-9_-]+)\s*\]\]?\s*(#.*)?$")
_LINE = re.compile(
    r"(?P<head>\s*(?P<key>[A-Za-z0-9_-]+)\s*=\s*)"
    r"(?P<value>\"(?:[^\"\\]|\\.)*\"|'[^']*'|[^\s#\"'\[{][^#]*?)(?P<rest>\s*(#.*)?)$"
)


def text_with(text: str, drive: Drive | RoutedDrive, settings: tuple[tuple[str, str], ...]) -> str:
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
