"""Knowing a finished study again, without the libraries that made it."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.version import __version__

RESULTS, REPORT, STAGES = "results.json", "report.html", "stages"


def asked_hash(drive: Drive, files: Sequence[str | None], quick: bool) -> str:
    """Hash of what the command was given: this version, the drive with its words, the bytes of every file.

    Parameters
    ----------
    drive : Drive
    files : sequence of str or None
        Goals, then logs; None: not given.
    quick : bool

    Returns
    -------
    str

    Raises
    ------
    InputRefused
        If a file cannot be read.
    """
    words = [__version__, content_hash(drive), drive.name, drive.title, str(quick)]
    words += ["" if file is None else _bytes_hash(file) for file in files]
    words += [Path(file).name for file in files[1:] if file is not None]
    return hashlib.sha256(json.dumps(words).encode()).hexdigest()


def _bytes_hash(file: str) -> str:
    try:
        if Path(file).exists() and not Path(file).is_dir():
            require_regular(file, "give the path of a file")
        with Path(file).open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except InputRefused:
        raise
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputRefused(f"{Path(file)}: cannot be read ({why}): check the path") from None


def finished(folder: Path) -> dict[str, Any] | None:
    """The results of a study that is there already.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    dict or None
        None: there is none, or it was not finished.
    """
    try:
        data = json.loads((folder / RESULTS).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return data if isinstance(data, dict) and (folder / REPORT).is_file() else None


def check_folder(folder: Path) -> None:
    """Refuse a folder that could not be written, before the work starts.

    Parameters
    ----------
    folder : Path

    Raises
    ------
    InputRefused
        If it is a file, or its own folder is missing.
    """
    if folder.exists() and not folder.is_dir():
        raise InputRefused(f"{folder}: is a file, a study needs a folder: choose another name")
    if not folder.exists() and not folder.parent.is_dir():
        raise InputRefused(f"{folder}: its folder {folder.parent} does not exist: create it first")
    if folder.is_dir() and not finished(folder):
        taken = [name for name in (RESULTS, REPORT) if (folder / name).exists()]
        if taken and not (folder / STAGES).is_dir():
            raise InputRefused(f"{folder}: holds a {taken[0]} that is no study's: choose another folder")
