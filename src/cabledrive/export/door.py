"""`export_to`: a controller, a plant or a loop in a form that runs elsewhere."""

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cabledrive.export.c99 import controller_package
from cabledrive.export.source import read_source
from cabledrive.parameters import InputRefused

FORMATS = ("c99", "fmu2", "fmu3", "mjcf", "modelica", "st", "klipper")
PARTS = ("controller", "plant", "loop")


def export_to(
    folder: str | os.PathLike[str],
    source: Any,
    format: str,
    *,
    controller: str | None = None,
    what: str = "controller",
    float32: bool = False,
) -> dict[str, Any]:
    """Write a controller, a plant or a loop in a form that runs elsewhere.

    Parameters
    ----------
    folder : str or path
        New folder that receives the files.
    source : Drive, str or path
        A drive, its name or file; a study's folder; a controller.json.
    format : {"c99", "fmu2", "fmu3", "mjcf", "modelica", "st", "klipper"}
        What to write.
    controller : str, optional
        Law for a drive; default: the one that its joint calls for.
    what : {"controller", "plant", "loop"}
        Which part.
    float32 : bool, default False
        Single precision, where the law holds in it.

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
    if format != "c99" or what != "controller" or float32:
        raise InputRefused(
            f"format {format}, {what}{', float32' * float32} has not come yet: take c99, controller"
        )
    place = checked_folder(folder)
    found = read_source(source, controller)
    files = controller_package(found)
    write_folder(place, files)
    return {
        "format": format,
        "files": sorted(files),
        "sample_time": found.law.sample_time,
        "drive_hash": found.law.drive_hash,
        "notes": list(found.notes),
    }


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


def write_folder(place: Path, files: Mapping[str, str | bytes]) -> None:
    """Write all files or none: beside the folder first, then under its name."""
    part = Path(tempfile.mkdtemp(prefix=f"{place.name}.part", dir=place.parent))
    try:
        part.chmod(0o777 & ~_umask())
        for name, content in files.items():
            path = part / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        if place.exists():
            place.rmdir()
        part.rename(place)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
