"""What the commands of a page share: options from filled fields, numbers, the drive as a file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studio.desk import Desk
from cabledrive.studio.state import State, drive_of

Form = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Asked:
    """A command to be run: what it is called on the page, and its arguments."""

    title: str
    arguments: list[str]


def drive_file(desk: Desk, state: State, folder: Path) -> str:
    """The drive of a state as a file beside its specification."""
    from cabledrive.parameters import drive_text

    (folder / "drive.toml").write_text(drive_text(drive_of(desk.library, state)), encoding="utf-8")
    return "drive.toml"


def map_option(desk: Desk, state: State) -> list[str]:
    """The map of a cable round two pulleys as an option; a machine with routes has none."""
    try:
        routes = isinstance(drive_of(desk.library, state), RoutedDrive)
    except (InputRefused, NotComputed):
        routes = False
    return [] if routes else ["--map", "map.html"]


def given(form: Form, **options: str) -> list[str]:
    """Options whose field is filled, each with its value in one argument."""
    return [f"{option}={form[name]}" for name, option in options.items() if form.get(name)]


def number(text: str, words: str) -> float:
    """A number from a field, between 0 and 1e9. Raises `InputRefused` with the field's words."""
    try:
        value = float(text)
    except ValueError:
        raise InputRefused(f"{words}: {text[:40]!r} is no number: write one") from None
    if not 0.0 <= value < 1e9:
        raise InputRefused(f"{words} = {value:g} must lie between 0 and 1e9")
    return value


def whole(text: str, words: str, most: int) -> int:
    """A whole number from a field, from 1 to ``most``. Raises `InputRefused` with the field's words."""
    if not (text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= most):
        raise InputRefused(f"{words}: {text[:40]!r} is no whole number from 1 to {most}: write one")
    return int(text)
