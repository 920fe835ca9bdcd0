"""The folder of a run in progress, OUT.part: which files it holds, and how they are written and removed."""

import os
from pathlib import Path
from typing import BinaryIO

from cabledrive.parameters.files import sync_folder
from cabledrive.parameters.one_process import LOCK

ROWS, FIELDS, CHECKPOINT, SETTING = "rows.f64", "fields.f64", "checkpoint", "run.json"
RESULT, NEW = "result.nc", ".new"
MADE_HERE = {name + end for name in (ROWS, FIELDS, CHECKPOINT, SETTING, RESULT) for end in ("", NEW)}
MADE_HERE |= {"checkpoint.npz"}  # by version 0.1


def clear(folder: Path, names: list[str]) -> None:
    """Delete files `left_behind` so that what is left by a kill can be resumed: the setting last."""
    for name in sorted(names, key=lambda name: (name == SETTING, name != CHECKPOINT)):
        (folder / name).unlink()


def part_of(path: Path) -> Path:
    """Folder of a run in progress, from the path of the result."""
    return path.with_name(path.name + ".part")


def left_behind(folder: Path) -> list[str]:
    """Names of what an ended run left in its folder, if it is there."""
    return [name for name in os.listdir(folder) if name != LOCK] if folder.is_dir() else []


def open_at(path: Path, size: int) -> BinaryIO:
    """Open a file, made where it is absent, for appending after the first bytes, which are kept."""
    path.touch()
    file = path.open("r+b")
    file.truncate(size)
    file.seek(size)
    return file


def replace_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is either the old one or the new one, on disk."""
    fresh = path.with_name(path.name + NEW)
    with fresh.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(fresh, path)
    sync_folder(path.parent)
