"""Keys that a campaign may vary: of the drive file, of the motion, of the goals, of the computation."""

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.frequency_curves import unit_in_file

DRIVE, PLANT, MOTION, GOALS, COMPUTE, OWN = "drive", "plant", "motion", "goals", "compute", "own"
MOTION_UNITS = {"angle": "rad", "rise": "s", "dwell": "s", "pulses": "count", "order": "count"}
WORD = ""
"""In place of a unit: a key that takes text, or true and false."""


@cache
def goal_units() -> dict[str, str]:
    """SI unit of each goal of a study, by name; "count" for a whole number."""
    from cabledrive.studies.study.goals import QUANTITIES  # a study brings most of the package with it

    return {**QUANTITIES, "pulses": "count", "order": "count"}


def unit_of(key: str, options: Mapping[str, str], drives: Iterable[Drive | RoutedDrive]) -> str:
    """SI unit of a key, "1" for a plain number, "count" for a whole one, "" for text or true and false.

    ``options``: units of the numbers that the computation takes; a key that no drive has is refused.
    """
    space, _, rest = key.partition(".")
    if key == DRIVE:
        return WORD
    if space == OWN and rest:
        return "1"
    if space == GOALS:
        return _known(key, rest, goal_units(), f"{GOALS}.")
    for name, units in ((MOTION, MOTION_UNITS), (COMPUTE, options)):
        if space == name:
            return _known(key, rest, units, f"{name}.")
    refusals = []
    for drive in drives:
        try:
            return unit_in_file(drive, rest if space == PLANT else key)
        except InputRefused as refusal:
            refusals.append(refusal)
    raise refusals[0]


def _known(key: str, name: str, units: Mapping[str, str], place: str) -> str:
    if not units:
        raise InputRefused(f'unknown key "{key}": this computation has no number that can be varied')
    require_known(name, units, f'unknown key "{key}"', place)
    return units[name]


def settings_of(values: Mapping[str, Any], space: str) -> dict[str, Any]:
    """Values of the keys in one name space, without its name; "" stands for the drive file."""
    if space:
        return {key[len(space) + 1 :]: value for key, value in values.items() if key.startswith(f"{space}.")}
    spaces = (PLANT, MOTION, GOALS, COMPUTE, OWN)
    return {key: value for key, value in values.items() if key != DRIVE and key.split(".")[0] not in spaces}
