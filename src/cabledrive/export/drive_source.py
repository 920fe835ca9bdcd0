"""The drive of a source, for the formats that describe mechanics."""

from pathlib import Path
from typing import Any

from cabledrive.export.source import DRIVE
from cabledrive.parameters import Drive, InputRefused, load_drive
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.models import highest_model, lumped_model
from cabledrive.reduction.network_axis import as_axis
from cabledrive.rig.laws.controller_file import FILE


def read_drive(source: Any, axis: str | None = None) -> Drive:
    """A drive, its name or file, or a study's identified one; an axis of one with routes; else refused."""
    return as_axis(read_machine(source), axis)


def read_machine(source: Any) -> Drive | RoutedDrive:
    """As `read_drive`, a machine with routes as it stands."""
    if isinstance(source, Drive | RoutedDrive):
        return source
    place = Path(str(source))
    if place.is_dir() or place.name == FILE:
        beside = (place if place.is_dir() else place.parent) / DRIVE
        if not beside.is_file():
            raise InputRefused(f"{source}: no {DRIVE} beside it, and mechanics are wanted: give the drive")
        return load_drive(str(beside))
    return load_drive(str(source))


def lumped_models(drive: Drive) -> dict[int, LumpedChain]:
    """Models 1 to 4 of a drive that its data allow, by number; refused with the highest's reason if none."""
    found = {}
    for number in (1, 2, 3, 4):
        try:
            found[number] = lumped_model(drive, number)
        except InputRefused:
            continue
    return found or {0: lumped_model(drive, highest_model(drive))}
