"""The folder of a studio: what it keeps has names of its own; no path comes from the page."""

import hashlib
import re
from contextlib import suppress
from pathlib import Path

from cabledrive.parameters import InputRefused, packaged_drives, packaged_text
from cabledrive.parameters.files import write_whole

DRIVES, LOGS, WORK = "drives", "logs", "work"
LONGEST_TEXT = 1_000_000
"""Characters of a drive's text."""
EMPTY = "empty-machine"
EMPTY_TEXT = """\
schema = 1
name = "my-machine"
title = "My machine"
kind = "loop"                  # "loop": cable round two pulleys; "line": cable between two ends

# The values below are placeholders: replace each by that of your machine.
[cable]
axial_rigidity = "10 kN"
mass_per_length = "5 g/m"
pretension = "50 N"

[layout]
span_length = "1 m"

[[pulley]]                     # the drive pulley
radius = "3 cm"
inertia = "1e-4 kg m^2"

[[pulley]]                     # the load pulley
radius = "3 cm"
inertia = "1e-4 kg m^2"
"""
_ID = re.compile(r"[a-z0-9-]{1,40}-[0-9a-f]{12}")


class Library:
    """What a studio keeps, in a folder that is made with its parts when something is kept."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._given: dict[str, str] = {}

    def part(self, name: str) -> Path:
        """A folder inside the studio's, made if it is missing; ``name``: `DRIVES`, `LOGS` or `WORK`."""
        place = self.folder / name
        place.mkdir(parents=True, exist_ok=True)
        return place

    def text(self, drive: str) -> str:
        """The text of a drive: a packaged one, the empty machine, or one kept here; refused if none is."""
        if drive in packaged_drives():
            return packaged_text(drive)
        if drive == EMPTY:
            return EMPTY_TEXT
        return self._path(drive).read_text(encoding="utf-8")

    def keep(self, text: str, name: str, given: str | None = None) -> str:
        """Keep a text, a person's ``given``, under a name by drive and content; refused if too long."""
        if len(text) > LONGEST_TEXT:
            raise InputRefused(f"the text is longer than {LONGEST_TEXT} characters: lump carriages together")
        content = hashlib.sha256(text.encode()).hexdigest()[:12]
        kept = f"{slug(name)}-{content}"
        path = self.part(DRIVES) / f"{kept}.toml"
        if not path.is_file():
            write_whole(path, text)
        if given is not None:
            self._given[kept] = given
        return kept

    def source(self, drive: str) -> str:
        """What a command takes for a drive: a packaged name, or a path; refused if there is none."""
        if drive in packaged_drives():
            return drive
        if drive == EMPTY:
            drive = self.keep(EMPTY_TEXT, EMPTY)
        return str(self._path(drive))

    def shown_source(self, drive: str) -> str:
        """As `source`; the path by which a person knows the drive, where the same text still stands there."""
        given = Path(self._given.get(drive, ""))
        with suppress(OSError, ValueError):
            if given.is_file() and given.read_text(encoding="utf-8-sig") == self.text(drive):
                return str(given)
        return self.source(drive)

    def kept(self) -> list[str]:
        """Names of the drives that are kept here, the newest first."""
        place = self.folder / DRIVES
        files = [path for path in place.glob("*.toml") if _ID.fullmatch(path.stem)] if place.is_dir() else []
        return [path.stem for path in sorted(files, key=lambda path: -path.stat().st_mtime)]

    def _path(self, drive: str) -> Path:
        """File of a kept drive, refused if none is; looked for by names of the form that `keep` gives."""
        path = self.folder / DRIVES / f"{drive}.toml"
        if not _ID.fullmatch(drive) or not path.is_file() or path.is_symlink():
            raise InputRefused(f'"{drive[:60]}" is no drive of this studio: open one from the list')
        return path


def slug(name: str) -> str:
    """A name as part of a file name: small letters, digits, hyphens, at most 40."""
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")[:40] or "drive"
