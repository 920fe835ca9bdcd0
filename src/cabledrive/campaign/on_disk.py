"""What a loss of power may take from a store: chunks are on the disk before they count as done."""

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cabledrive.parameters.files import sync_folder

AT_ONCE = 8
"""Files that wait for the disk at a time."""


def sync_chunk(store: Path, names: Iterable[str], number: int) -> None:
    """Bring a chunk of some arrays to the disk; one that holds nothing but its fill value has no file.

    All files at once, since the disk then writes its journal once for many of them.
    """
    files: list[Path] = []
    folders: set[Path] = set()
    for name in names:
        place = store / name / "c" / str(number)
        found = [path for path in (place.rglob("*") if place.is_dir() else [place]) if path.is_file()]
        files += found
        folders |= {store / name / "c", *(path.parent for path in found)}
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(_sync, files))
        list(pool.map(sync_folder, folders))


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
