"""What a loss of power may take from a store: chunks are on the disk before they count as done."""

import os
from collections.abc import Iterable
from pathlib import Path

from cabledrive.parameters.files import sync_folder


def sync_chunk(store: Path, names: Iterable[str], number: int) -> None:
    """Bring a chunk of some arrays to the disk; one that holds nothing but its fill value has no file."""
    for name in names:
        place = store / name / "c" / str(number)
        for path in place.rglob("*") if place.is_dir() else [place]:
            if path.is_file():
                _sync(path)
                sync_folder(path.parent)
        sync_folder(store / name / "c")


def sync_tree(folder: Path) -> None:
    """Bring a folder with all that is in it to the disk."""
    for path in [*folder.rglob("*"), folder]:
        if path.is_dir():
            sync_folder(path)
        else:
            _sync(path)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
