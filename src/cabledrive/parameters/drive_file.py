"""Drive files: read, varied from the command line, written again without loss."""

import re
import tomllib
from collections.abc import Iterable
from functools import cache
from importlib import resources
from math import inf
from pathlib import Path
from typing import Any

from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.files import write_whole
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.route.strain_free import POSE, is_pose_key, moved
from cabledrive.parameters.tables import ARRAYS, drive_from_tables, tables_from_drive
from cabledrive.parameters.toml_values import content_of, toml_of
from cabledrive.parameters.units import to_si

DEEPEST_KEY = 3  # pulley.0.inertia


def load_drive(source: str | Path, *, overrides: Iterable[str] = ()) -> Machine:
    """Load a machine by the path of its file, or by the name of a packaged one.

    Parameters
    ----------
    source : path-like
        Path of a TOML file, or a name listed by `packaged_drives`.
    overrides : iterable of str, optional
        Settings ``"key.path=value"`` that replace values of the file: ``"cable.pretension=6 N"``,
        ``"pulley.0.inertia=0.001"``. Named tables are reached by name, ``"pulley.motor.inertia=..."``, and
        ``"head.x=0.2 m"`` or ``"arm.turn=5 deg"`` moves a body of a machine with routes.

    Returns
    -------
    Machine
        Whatever the kind of its file. One cable between two pulleys has closed forms as well, see
        `Machine.two_pulleys`.

    Raises
    ------
    InputRefused
        If the file cannot be read, is not TOML, or does not describe a drive.
    """
    try:
        data = toml_of(_read(source))
        return _built(data, overrides)
    except InputRefused as refusal:
        raise refusal.at(str(source) or '""') from None


def drive_from_text(text: str, *, overrides: Iterable[str] = ()) -> Machine:
    """As `load_drive`, from the text of a drive file."""
    return _built(toml_of(text.encode()), overrides)


def _built(data: dict[str, Any], overrides: Iterable[str]) -> Machine:
    """The machine of a file's plain data, with settings; bodies are moved once it is whole."""
    pose: dict[str, float] = {}
    for setting in overrides:
        key, _, value = (part.strip() for part in setting.partition("="))
        if is_pose_key(data, key):
            unit, number = POSE[key.rpartition(".")[2]], _setting(value)
            number = to_si(number, unit) if isinstance(number, str) else number
            if isinstance(number, bool) or not isinstance(number, int | float) or not abs(number) < inf:
                raise InputRefused(
                    f'--set "{key[:80]}" needs one number in {unit}: write, for instance, {key}="0.1 {unit}"'
                )
            pose[key] = float(number)
        else:
            _override(data, setting)
    machine = drive_from_tables(data).machine
    return moved(machine, pose) if pose else machine


def save_drive(drive: Machine | Drive, path: str | Path, *, force: bool = False) -> Path:
    """Write a machine as a file that loads to an equal one, in the form that it was read from.

    Parameters
    ----------
    drive : Machine or Drive
    path : path-like
        File to write.
    force : bool, default False
        Whether an existing file may be replaced.

    Returns
    -------
    Path
        Where it was written.

    Raises
    ------
    InputRefused
        If the file exists (without `force`) or cannot be written.
    """
    return write_whole(path, drive_text(drive), force=force)


def drive_text(drive: Machine | Drive) -> str:
    """Text of the drive's file: SI values, each with its unit.

    Parameters
    ----------
    drive : Machine or Drive

    Returns
    -------
    str
        TOML.
    """
    import tomli_w

    return tomli_w.dumps(tables_from_drive(drive), multiline_strings=True)


def packaged_drives(*kinds: str) -> tuple[str, ...]:
    """Names of the drives that come with the package.

    Parameters
    ----------
    *kinds : {"loop", "line", "route"}
        Only drives of these kinds; default: all.

    Returns
    -------
    tuple of str
        In alphabetical order.
    """
    folder = resources.files("cabledrive.parameters") / "drives"
    names = sorted(
        entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml")
    )
    return tuple(name for name in names if not kinds or _kind(name) in kinds)


@cache
def _kind(name: str) -> str:
    """Kind of a packaged drive."""
    found = re.search(r'^kind\s*=\s*"(\w+)"', packaged_text(name), re.MULTILINE)
    assert found is not None
    return found[1]


def packaged_text(name: str) -> str:
    """File of a packaged drive as it is kept, comments included: a file to start from.

    Parameters
    ----------
    name : str
        A name listed by `packaged_drives`.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputRefused
        If no packaged drive has that name.
    """
    if name not in packaged_drives():
        known = nearest(name, packaged_drives())
        raise InputRefused(f"{name[:80]}: no packaged drive has this name{known}")
    return (resources.files("cabledrive.parameters") / "drives" / f"{name}.toml").read_text(encoding="utf-8")


def _read(source: str | Path) -> bytes:
    path = Path(source)
    if not str(source):
        raise InputRefused("no drive is named: give the path of a drive file, or a name of cabledrive drives")
    try:
        if str(source) in packaged_drives() and not path.is_file():
            return (resources.files("cabledrive.parameters") / "drives" / f"{source}.toml").read_bytes()
        return content_of(path)
    except InputRefused:
        raise
    except IsADirectoryError:
        raise InputRefused("is a folder: name a drive file in it") from None
    except (FileNotFoundError, NotADirectoryError):
        known = nearest(path.name.removesuffix(".toml"), packaged_drives())
        raise InputRefused(f"no such file, and no packaged drive of that name{known}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputRefused(f"cannot be read ({reason}): check the path") from None


def _override(data: dict[str, Any], setting: str) -> None:
    key, equals, text = setting.partition("=")
    if not equals or not key.strip():
        raise InputRefused(
            f'--set "{setting[:80]}" is not KEY=VALUE: write, for instance, cable.pretension="6 N"'
        )
    *path, last = (step.strip() for step in key.split("."))
    table: Any = data
    for depth, step in enumerate(path[:DEEPEST_KEY]):
        table = _enter(table, step, path[: depth + 1])
    if not isinstance(table, dict) or not last or len(path) >= DEEPEST_KEY:
        raise InputRefused(
            f'--set "{key.strip()[:80]}" does not name a value: write, for instance, pulley.0.inertia=0.001'
        )
    table[last] = _setting(text.strip())


def _enter(table: Any, step: str, path: list[str]) -> Any:
    """One step down the key path; a missing table is made, and an array grows by one at its end."""
    place = ".".join(path)
    if isinstance(table, list):
        named = [row for row in table if isinstance(row, dict) and row.get("name") == step]
        if named:
            return named[0]
        if not re.fullmatch("[0-9]{1,6}", step) or int(step) > len(table):
            names = [str(row["name"]) for row in table if isinstance(row, dict) and row.get("name")]
            raise InputRefused(
                f'--set: "{place}" does not exist: {path[-2]} has {len(table)} entries, numbered from 0'
                + (f", or by name: {', '.join(names)}" if names else "")
            )
        if int(step) == len(table):
            table.append({})
        return table[int(step)]
    if not isinstance(table, dict):
        raise InputRefused(f'--set: "{place}" is inside a value, not a table: shorten the key')
    # One motor may be a plain table also where several could be listed.
    several = step != "motor" and any(step in arrays for arrays in ARRAYS.values())
    return table.setdefault(step, [] if several else {})


def _setting(text: str) -> Any:
    """TOML if it is TOML (number, quoted text, true), else text: the shell eats the quotation marks."""
    try:
        value, *more = tomllib.loads(f"value = {text}").values()
        return text if more else value
    except (tomllib.TOMLDecodeError, RecursionError, ValueError):
        return text
