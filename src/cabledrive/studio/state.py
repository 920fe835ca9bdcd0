"""What a person looks at, what the routes of a studio share, and kernels made ready in the background."""

import copy
import shlex
import subprocess
import sys
import threading
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlencode

from starlette.requests import Request

from cabledrive.modal import modes
from cabledrive.parameters import InputRefused, Machine, load_drive, packaged_drives
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.parameters.files import require_regular
from cabledrive.parameters.toml_values import toml_of
from cabledrive.studio.jobs import Jobs
from cabledrive.studio.library import LONGEST_TEXT, Library
from cabledrive.studio.log_store import LogStore

MOST_SETTINGS = 200
LONGEST_SETTING = 400
FIRST = "dissertation-2"


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """A drive with settings."""

    drive: str  # name in the library
    settings: tuple[tuple[str, str], ...] = ()  # keys and values as ``--set`` takes them

    @property
    def overrides(self) -> list[str]:
        """The settings as ``load_drive`` takes them."""
        return [f"{key}={value}" for key, value in self.settings]

    @property
    def query(self) -> str:
        """The state as part of an address."""
        return urlencode([("drive", self.drive), *(("set", setting) for setting in self.overrides)])


def first_state(library: Library, source: str | None) -> State:
    """The state of a new studio, refused if the source is no drive; a file's text is kept."""
    if source is None:
        return State(drive=FIRST)
    loaded = load_drive(source)
    if source in packaged_drives() and not Path(source).is_file():
        return State(drive=source)
    text = require_regular(source, "give the path of a drive file").read_text(encoding="utf-8-sig")
    return State(drive=library.keep(text, loaded.name, given=source))


def state_of(query: str, first: State) -> State:
    """Read a state from an address, or the first where it names no drive; refused if too long."""
    try:
        pairs = parse_qsl(query, keep_blank_values=True, max_num_fields=2 * MOST_SETTINGS)
    except ValueError:
        raise InputRefused(f"the address has more than {MOST_SETTINGS} settings: edit the text") from None
    drive = next((value for name, value in pairs if name == "drive"), None)
    settings = [value for name, value in pairs if name == "set"]
    if len(settings) > MOST_SETTINGS or any(len(one) > LONGEST_SETTING for one in settings):
        raise InputRefused(f"more than {MOST_SETTINGS} settings, or one too long: edit the text instead")
    if drive is None:
        return first
    parted = [one.partition("=") for one in settings]
    return State(drive=drive, settings=tuple((key.strip(), value) for key, _, value in parted))


def drive_of(library: Library, state: State) -> Machine:
    """The drive of a state. Raises `InputRefused` as `load_drive` does."""
    return drive_from_text(library.text(state.drive), overrides=state.overrides)


def tables_of(library: Library, state: State) -> dict[str, Any]:
    """The plain tables of a state's file, as written there, without the settings; refused if no TOML."""
    return copy.deepcopy(_parsed(library.text(state.drive).encode()))


_parsed = lru_cache(maxsize=16)(toml_of)


def edited(library: Library, text: str) -> State:
    """Check and keep an edited text. Raises `InputRefused` if it describes no drive; nothing is kept then."""
    if len(text) > LONGEST_TEXT:
        raise InputRefused(f"the text is longer than {LONGEST_TEXT} characters: lump carriages together")
    text = text.replace("\r\n", "\n")
    return State(drive=library.keep(text, drive_from_text(text).name))


def command_line(library: Library, state: State, command: str, *options: str) -> str:
    """The line that does the same in a terminal."""
    settings = [f"--set={setting}" for setting in state.overrides]
    return shlex.join(["cabledrive", command, library.shown_source(state.drive), *settings, *options])


def arguments(library: Library, state: State, command: str, *options: str) -> list[str]:
    """Arguments of a command of the package for a state; values never stand alone, so none is an option."""
    settings = [f"--set={setting}" for setting in state.overrides]
    return [command, library.source(state.drive), *settings, *options]


class Warm:
    """Runs each calculation, if it is wanted at all, once, in a thread or a process; knows which is next."""

    def __init__(self, *, wanted: bool) -> None:
        self.words = _words(_CALCULATIONS[0][0]) if wanted else ""
        self._waits, self._ended = wanted, False
        self._process: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Start the thread, once: when the first page has gone out, which is not to wait for it."""
        if self._waits:
            self._waits = False
            threading.Thread(target=self._run, daemon=True, name="warm").start()

    def end(self) -> None:
        """Start no further calculation, and end the one that runs in a process."""
        self._ended = True
        if self._process is not None:
            self._process.kill()

    def _run(self) -> None:
        for words, command in _CALCULATIONS:
            if self._ended:
                break
            self.words = _words(words)
            if command:
                self._compile(command)
                continue
            for name in ("dissertation-3", "dissertation-transporter"):
                modes(load_drive(name), count=8)
                modes(load_drive(name), count=8, motor="held")
        self.words = ""

    def _compile(self, command: tuple[str, ...]) -> None:
        """Run a command for the kernels that it leaves in the cache; what it refuses the page will say."""
        self._process = subprocess.Popen(
            (sys.executable, "-m", "cabledrive", *command, "--quiet", "--json"),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        if self._ended:  # in the meantime
            self._process.kill()
        self._process.wait()


def _words(calculation: str) -> str:
    return f"Getting ready: {calculation}. The page can be used meanwhile; the first result may take longer."


_CALCULATIONS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("modes", ()),
    ("internal resonance", ("resonance", "dissertation-2")),
    ("the rig of the controllers", ("track", "dissertation-3", "--controller=darc-4", "--bandwidth=30")),
)
"""What is made ready: its words, and the command whose kernels it needs, compiled in a process of its own so
that the server does not hold them until a page asks; without one, modes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Desk:
    """What the routes share."""

    library: Library
    first: State  # where an address names no drive
    jobs: Jobs
    logs: LogStore
    warm: Warm


async def bounded_body(request: Request, most: int) -> bytes:
    """The body of a request; refused if it is longer than ``most`` bytes."""
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise InputRefused(f"the request is longer than {most} bytes: send less")
        parts.append(part)
    return b"".join(parts)
