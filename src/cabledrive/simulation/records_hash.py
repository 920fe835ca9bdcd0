"""Running hashes of the records of a run, remembered where the run can be resumed from."""

import hashlib
from pathlib import Path
from typing import Any

BLOCK = 1 << 24  # bytes


class RecordsHash:
    """SHA-256 of rows and fields as they are appended.

    The digests of the last two record counts are kept: a commit that was called for by an interrupt may stand
    for fewer records than have been appended.
    """

    def __init__(self) -> None:
        self._hashes = [hashlib.sha256(), hashlib.sha256()]
        self._count = 0
        self._digests = {0: self._now()}

    def add(self, records: int, *content: bytes) -> None:
        """Count in records by their rows and their fields."""
        for running, part in zip(self._hashes, content, strict=True):
            running.update(part)
        self._count += records
        kept = dict(list(self._digests.items())[-1:])
        self._digests = kept | {self._count: self._now()}

    def at(self, records: int) -> list[str]:
        """Digests of rows and fields up to one of the last two numbers of records counted in."""
        return self._digests[records]

    def read(self, records: int, *parts: tuple[Path, int]) -> list[str]:
        """Digests of what lies in files already, counted in before anything else.

        ``*parts``: file of the rows and of the fields, and how many of its bytes belong to these records.
        `OSError` if a file is shorter, or cannot be read.
        """
        for running, (path, size) in zip(self._hashes, parts, strict=True):
            _hash_file(running, path, size)
        self._count = records
        self._digests = {records: self._now()}
        return self.at(records)

    def _now(self) -> list[str]:
        return [running.hexdigest() for running in self._hashes]


def _hash_file(running: Any, path: Path, size: int) -> None:
    left = size
    with path.open("rb") as file:
        while left > 0:
            part = file.read(min(left, BLOCK))
            if not part:
                raise OSError(f"{path.name} holds {size - left} of {size} bytes")
            running.update(part)
            left -= len(part)
