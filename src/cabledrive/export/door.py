"""`export_to`: a controller, a plant or a loop in a form that runs elsewhere."""

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cabledrive.control.own_controller import OwnController
from cabledrive.export.blocks import cable_block, controller_block, system_block
from cabledrive.export.c99 import controller_package, system_package
from cabledrive.export.descriptions import klipper_files, mjcf_files, modelica_files
from cabledrive.export.fmu import fmu_package
from cabledrive.export.single_precision import single_precision
from cabledrive.export.source import NOTE, ExportSource, read_machine, read_source
from cabledrive.parameters import InputRefused, content_hash
from cabledrive.parameters.files import umask
from cabledrive.reduction.network_axis import as_axis, axis_notes

FORMATS = ("c99", "fmu2", "fmu3", "mjcf", "modelica", "klipper")
LINEAR = "links are linear: valid while no span goes slack"
PARTS = ("controller", "plant", "loop", "cable")

Files = Mapping[str, str | bytes]
Made = tuple[Files, float | None, str | None, list[str]]
"""Files by name, time from one step to the next [s], content hash of the drive, notes."""


def export_to(
    folder: str | os.PathLike[str],
    source: Any,
    format: str,
    *,
    controller: str | OwnController | None = None,
    axis: str | None = None,
    what: str = "controller",
    float32: bool = False,
    anyway: bool = False,
) -> dict[str, Any]:
    """Write a controller, a plant or a loop in a form that runs elsewhere.

    Parameters
    ----------
    folder : str or path
        New folder that receives the files.
    source : Machine, Drive, str or path
        A drive, its name or file; a study's folder; a controller.json.
    format : {"c99", "fmu2", "fmu3", "mjcf", "modelica", "klipper"}
        What to write.
    controller : str or OwnController, optional
        Law for a drive; default: the one that its joint calls for. A controller of your own, such as an
        `OwnController`, whose step keeps to the subset of Python that is translated.
    axis : str, optional
        Of a machine with routes: its load, such as "head.x"; default: the first that is a chain.
    what : {"controller", "plant", "loop", "cable"}
        Which part; "cable": the distributed cable in modes, or the network of a machine with routes.
    float32 : bool, default False
        Single precision, where the law holds in it.
    anyway : bool, default False
        Also the law of a study whose verdict is not yes; the reason stands in the files.

    Returns
    -------
    dict
        ``format``, ``files`` (names in the folder), ``sample_time`` [s], ``drive_hash``, ``notes``.

    Raises
    ------
    InputRefused
        If the source, the law or the format cannot be exported, or the folder is not empty.
    """
    if format not in FORMATS:
        raise InputRefused(f"format = {format!r} is not known: take one of {', '.join(FORMATS)}")
    if what not in PARTS:
        raise InputRefused(f"what = {what!r} is not known: take one of {', '.join(PARTS)}")
    place = checked_folder(folder)
    if float32 and (format != "c99" or what != "controller"):
        raise InputRefused(
            f"float32 is for --format c99 --what controller, not {format} {what}: leave it out"
        )
    if what == "cable":
        files, sample_time, drive_hash, notes = _cable(source, format, controller, axis)
    elif format in ("c99", "fmu2", "fmu3"):
        found = read_source(source, controller, axis)
        if found.caution and what != "plant" and not anyway:
            raise InputRefused(f"{source}: {found.caution}: add --anyway to export its law all the same")
        if found.law.own is not None and (float32 or what != "controller"):
            said = f'controller "{found.law.name}" is your own: it is exported alone and in double precision'
            raise InputRefused(f"{said}; the plant is exported from the drive without it")
        files, notes = _package(found, format, what, float32)
        sample_time, drive_hash = found.law.sample_time, found.law.drive_hash
        notes = [*([found.caution] if found.caution else []), *notes]
    else:
        files, sample_time, drive_hash, notes = _model(source, format, what, axis)
    write_folder(place, files)
    return {
        "format": format,
        "files": sorted(files),
        "sample_time": sample_time,
        "drive_hash": drive_hash,
        "notes": notes,
    }


def _package(found: ExportSource, format: str, what: str, float32: bool) -> tuple[Files, list[str]]:
    """Files of a controller, plant or loop, and notes."""
    if format in ("fmu2", "fmu3"):
        block = controller_block(found) if what == "controller" else system_block(found, what)
        return fmu_package(block, int(format[-1]))
    if what != "controller":
        return system_package(found, what), [*found.notes, NOTE]
    tolerance = None
    if float32:
        found, _, tolerance = single_precision(found)
    return controller_package(found, tolerance), list(found.notes)


def _cable(source: Any, format: str, controller: Any, axis: str | None) -> Made:
    """The cable of a drive in modes as an FMU."""
    if format not in ("fmu2", "fmu3"):
        raise InputRefused(f"what = cable is written as fmu2 or fmu3, whose sources are C99, not as {format}")
    if controller is not None or axis is not None:
        raise InputRefused("the cable holds no controller and all axes: leave --controller and --axis out")
    drive = read_machine(source)
    block = cable_block(drive)
    files, notes = fmu_package(block, int(format[-1]))
    return files, block.interval, content_hash(drive), notes


def _model(source: Any, format: str, what: str, axis: str | None) -> Made:
    """A model of the mechanics, or lines for a printer."""
    if what == "loop":
        raise InputRefused(f"{format} holds no controller: leave --what loop out, or take fmu2, fmu3 or c99")
    if format == "klipper":
        return klipper_files(source), None, None, []
    drive = as_axis(read_machine(source), axis)
    files = mjcf_files(drive) if format == "mjcf" else modelica_files(drive)
    rate = drive.sensors.sample_rate if drive.sensors else None
    slack = "a slack span carries nothing, its damping stays" if format == "mjcf" else LINEAR
    return files, None if rate is None else 1.0 / rate, content_hash(drive), [slack, *axis_notes(drive)]


def checked_folder(folder: str | os.PathLike[str]) -> Path:
    """A folder that can be made; refused before the work starts."""
    place = Path(folder)
    if not str(folder):
        raise InputRefused("--output names no folder: give one")
    if place.exists() and (not place.is_dir() or any(place.iterdir())):
        raise InputRefused(f"{folder}: exists and is not empty: give a new folder")
    parent = place.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputRefused(f"{folder}: its folder {parent} cannot be written: give another")
    return place


def write_folder(place: Path, files: Files) -> None:
    """Write all files or none: beside the folder first, then under its name."""
    part = Path(tempfile.mkdtemp(prefix=f"{place.name}.part", dir=place.parent))
    try:
        part.chmod(0o777 & ~umask())
        for name, content in files.items():
            path = part / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        if place.exists():
            place.rmdir()
        part.rename(place)
    finally:
        shutil.rmtree(part, ignore_errors=True)
