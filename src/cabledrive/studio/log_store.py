"""Logs that were dropped onto the page: streamed to disk, drawn by least and largest value for each pixel."""

import re
import secrets
import shutil
import threading
from collections import OrderedDict
from collections.abc import AsyncIterator
from pathlib import Path

import anyio

from cabledrive.identification.logs.opening import FORMATS, open_table
from cabledrive.identification.logs.quantities import name_and_unit, recognise
from cabledrive.identification.logs.table import Table
from cabledrive.parameters import InputRefused
from cabledrive.studio.curves import Curves

LARGEST = 2_000_000_000
"""Bytes of one log."""
SOUND = ".wav"
MOST_OPEN = 4
MOST_SHOWN = 4
"""Columns that are shown unasked."""
_ID = re.compile(r"[0-9a-f]{16}")


class LogStore:
    """The logs of a studio, in one folder each."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._open: OrderedDict[str, Curves] = OrderedDict()
        self._lock = threading.Lock()

    async def receive(self, name: str, content: AsyncIterator[bytes]) -> str:
        """Write an upload to disk as it comes; its name in the studio.

        Raises `InputRefused` if its name ends like no log, or it is longer than `LARGEST`.
        """
        kept = safe_name(name)
        log = secrets.token_hex(8)
        place = self._folder / f".{log}"
        place.mkdir(parents=True)
        try:
            size = 0
            async with await anyio.open_file(place / kept, "wb") as file:
                async for part in content:
                    size += len(part)
                    if size > LARGEST:
                        raise InputRefused(f"{kept}: larger than {LARGEST / 1e9:g} GB: cut the log")
                    await file.write(part)
            if size == 0:
                raise InputRefused(f"{kept}: is empty: give a log with rows of numbers")
            place.rename(self._folder / log)
        except BaseException:
            shutil.rmtree(place, ignore_errors=True)
            raise
        return log

    def path(self, log: str) -> Path:
        """File of a log. Raises `InputRefused` if there is none of that name."""
        place = self._folder / log
        if _ID.fullmatch(log) and place.is_dir() and not place.is_symlink():
            for path in sorted(place.iterdir()):
                if path.is_file() and not path.is_symlink():
                    return path
        raise InputRefused(f'"{log[:40]}" is no log of this studio: drop the file again')

    def listed(self) -> list[tuple[str, str]]:
        """Names in the studio and of the files, the newest first."""
        places = [place for place in self._folder.glob("*") if _ID.fullmatch(place.name) and place.is_dir()]
        newest = sorted(places, key=lambda place: -place.stat().st_mtime)
        return [(place.name, self.path(place.name).name) for place in newest if any(place.glob("*.*"))]

    def table(self, log: str) -> Table:
        """The columns of a log; only its head is read. Raises `InputRefused` if the reader does."""
        path = self.path(log)
        if path.suffix.lower() == SOUND:
            raise InputRefused(f"{path.name}: a recording: use it for the tension of a plucked span")
        return open_table(path)

    def curves(self, log: str) -> Curves:
        """What is drawn of a log; a few logs are kept ready."""
        with self._lock:
            if log not in self._open:
                table = self.table(log)
                self._open[log] = Curves(table, time_column(table), self._folder / log / ".columns")
            self._open.move_to_end(log)
            while len(self._open) > MOST_OPEN:
                self._open.popitem(last=False)
            return self._open[log]


def safe_name(name: str) -> str:
    """A file name of letters, digits and ``. _ -`` only; refused if it ends like no log."""
    kept = re.sub(r"[^A-Za-z0-9._-]+", "_", name.replace("\\", "/").rpartition("/")[2]).lstrip("._-")[-80:]
    if Path(kept).suffix.lower() not in (*FORMATS, SOUND):
        raise InputRefused(f"{name[:80]!r}: logs end in {', '.join((*FORMATS, SOUND))}: rename or unpack it")
    return kept


def time_column(table: Table) -> str | None:
    """The one column whose head says that it is the time."""
    found = [name for name in table.names if (seen := recognise(name)) and seen.channel == "time"]
    return found[0] if len(found) == 1 else None


def shown_columns(table: Table) -> list[str]:
    """Columns that are drawn unasked: those that a head recognises, else the first ones."""
    time = time_column(table)
    rest = [name for name in table.names if name != time]
    known = [name for name in rest if recognise(name) is not None]
    return (known or rest)[:MOST_SHOWN]


def unit_of(table: Table, column: str) -> str:
    """Unit that a log states for a column; empty where it states none."""
    return table.units.get(column) or name_and_unit(column)[1]
