"""Logs."""

from pathlib import Path


class LogStore:
    """Logs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
