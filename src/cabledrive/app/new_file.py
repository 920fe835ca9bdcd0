"""Files that a command is going to write: checked before the work, written whole or not at all."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from cabledrive.app.messages import note
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import check_writable, write_whole

PAGE, OBJECT = (".html", ".htm", ""), (".json", "")
"""Endings of files that have one format each; a bare name will do."""
TAKEN, FORCE = "cabledrive.taken", "cabledrive.force"


@dataclass(frozen=True, slots=True)
class NewFile:
    """A file that a command is going to write."""

    path: Path
    force: bool  # whether an existing file may be replaced

    def write(self, content: str | bytes) -> None:
        """Write it whole or not at all, and say so."""
        write_whole(self.path, content, force=self.force)
        note(f"written to {self.path}")


class NewFileType(click.ParamType):  # type: ignore[type-arg]
    """Path of a file to write; refused before the work starts where it could not be written."""

    name = "file"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> NewFile:
        """Check a path to be written: refused if there (without ``--force``), of a wrong ending, or twice."""
        assert ctx is not None
        force = bool(ctx.meta.get(FORCE))
        path = check_writable(value, force=force)
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            endings = " or ".join(filter(None, self.suffixes))
            raise InputRefused(f"{path}: does not end in {endings}: rename it")
        taken = ctx.meta.setdefault(TAKEN, set())
        if path.resolve() in taken:
            raise InputRefused(f"{path}: is to be written twice: give two names")
        taken.add(path.resolve())
        return NewFile(path, force)
