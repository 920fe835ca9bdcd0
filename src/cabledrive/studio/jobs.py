"""Long work: the package's own commands as processes, with progress, cancelled as by Ctrl-C."""

import asyncio
import contextlib
import ctypes
import json
import os
import shlex
import signal
import sys
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import write_whole

MOST_RUNNING = 2
MOST_LINES = 2000
PATIENCE = 1.2
"""Seconds from Ctrl-C to the end of a process that does not end."""
WORDS = {0: "done", 2: "refused", 3: "not completed", 130: "cancelled"}
RUNNING, INTERRUPTED = "running", "interrupted"
CARD = "job.json"
LARGEST_ANSWER = 20_000_000
_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux


@dataclass(slots=True, eq=False)
class Job:
    """One command."""

    number: int
    title: str
    shown: str  # the line that does the same in a terminal
    arguments: list[str]  # of the command `cabledrive`, but for ``--json``
    folder: Path  # where it runs and what it writes into
    status: str = INTERRUPTED  # "running", "interrupted", or one of `WORDS`
    lines: list[str] = field(default_factory=list)  # what it said on standard error
    process: asyncio.subprocess.Process | None = None
    news: asyncio.Event = field(default_factory=asyncio.Event)
    ending: bool = False  # asked to end: before its libraries are loaded it does so with any status

    @property
    def answer(self) -> dict[str, Any]:
        """The JSON object that it printed; empty while there is none."""
        path = self.folder / "answer.json"
        with contextlib.suppress(OSError, ValueError):
            if path.stat().st_size <= LARGEST_ANSWER:
                return dict(json.loads(path.read_text(encoding="utf-8")))
        return {}

    @property
    def files(self) -> list[str]:
        """Files that a person may take: those of the first two levels, by name within the folder."""
        found = [*self.folder.glob("*"), *self.folder.glob("*/*")]
        own = (CARD, "answer.json")
        taken = [path for path in found if path.is_file() and not path.is_symlink() and path.name not in own]
        names = [path.relative_to(self.folder).as_posix() for path in taken]
        return sorted(name for name in names if not any(part.startswith(".") for part in name.split("/")))

    def card(self) -> str:
        """What outlives the studio."""
        return json.dumps(
            {"title": self.title, "shown": self.shown, "arguments": self.arguments, "status": self.status}
        )


class Jobs:
    """All commands of a studio, in one folder each."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.all: dict[int, Job] = {}
        self._watchers: set[asyncio.Task[None]] = set()
        for path in sorted(folder.glob(f"*/{CARD}")) if folder.is_dir() else []:
            with contextlib.suppress(OSError, ValueError, KeyError):
                self._restore(path)

    def _restore(self, path: Path) -> None:
        """A job of an earlier studio; one that ran then was interrupted."""
        card, number = json.loads(path.read_text(encoding="utf-8")), int(path.parent.name)
        self.all[number] = Job(
            number=number,
            title=str(card["title"]),
            shown=str(card["shown"]),
            arguments=[str(part) for part in card["arguments"]],
            folder=path.parent,
            status=INTERRUPTED if card["status"] == RUNNING else str(card["status"]),
        )

    def new_folder(self) -> tuple[int, Path]:
        """Number and folder of the next job."""
        number = max(self.all, default=0) + 1
        folder = self._folder / f"{number:04d}"
        while folder.exists():
            number += 1
            folder = self._folder / f"{number:04d}"
        folder.mkdir(parents=True)
        return number, folder.absolute()

    async def start(self, place: tuple[int, Path], title: str, arguments: Sequence[str]) -> Job:
        """Start a command in its folder; refused if too many are running."""
        self.check_room()
        number, folder = place
        shown = shlex.join(["cabledrive", *arguments])
        job = Job(number=number, title=title, shown=shown, arguments=list(arguments), folder=folder)
        self.all[number] = job
        await self._run(job)
        return job

    async def resume(self, job: Job) -> None:
        """Give the same command again; refused if it runs, or too many others do."""
        if job.status == RUNNING:
            raise InputRefused(f"{job.title}: is running: wait until it ends, or cancel it")
        self.check_room()
        job.lines.clear()
        await self._run(job)

    def check_room(self) -> None:
        """Refuse more work than the machine should do at once."""
        running = [job.title for job in self.all.values() if job.status == RUNNING]
        if len(running) >= MOST_RUNNING:
            raise InputRefused(
                f"{len(running)} are running ({', '.join(running)}): wait until one ends, or cancel one"
            )

    async def _run(self, job: Job) -> None:
        job.status, job.ending = RUNNING, False
        write_whole(job.folder / CARD, job.card(), force=True)
        with (job.folder / "answer.json").open("wb") as answer:
            job.process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "cabledrive", *job.arguments, "--json"),
                cwd=job.folder,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=answer,
                stderr=asyncio.subprocess.PIPE,
                start_new_session=True,
                preexec_fn=_as_a_shell_starts_it if os.name == "posix" else None,
                env=os.environ | {"MPLBACKEND": "Agg"},
            )
        task = asyncio.create_task(self._watch(job))
        self._watchers.add(task)
        task.add_done_callback(self._watchers.discard)

    async def _watch(self, job: Job) -> None:
        assert job.process is not None
        assert job.process.stderr is not None
        while line := await _line(job.process.stderr):
            if len(job.lines) < MOST_LINES:
                job.lines.append(line.decode(errors="replace").rstrip())
            _tell(job)
        code = await job.process.wait()
        job.status = WORDS.get(code, "cancelled" if code < 0 or job.ending else "failed")
        write_whole(job.folder / CARD, job.card(), force=True)
        _tell(job)

    async def cancel(self, job: Job) -> None:
        """Ctrl-C; what does not end by itself is ended, with all its processes."""
        process = job.process
        if process is None or process.returncode is not None:
            return
        job.ending = True
        _signal(process.pid, signal.SIGINT)
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), PATIENCE)
        _signal(process.pid, signal.SIGKILL)
        await process.wait()

    async def end(self) -> None:
        """Cancel all that run; the studio ends."""
        await asyncio.gather(*(self.cancel(job) for job in self.all.values()))
        await asyncio.gather(*self._watchers, return_exceptions=True)

    async def events(self, job: Job, seen: int) -> AsyncIterator[str]:
        """Server-sent events: every line not seen yet, then the end; a page that lost them asks again."""
        seen = min(seen, len(job.lines))
        while True:
            news = job.news  # taken before the lines are counted: what comes after sets it
            while seen < len(job.lines):
                seen += 1
                yield f"id: {seen}\ndata: {json.dumps(job.lines[seen - 1])}\n\n"
            if job.status != RUNNING:
                yield f"event: end\ndata: {json.dumps(job.status)}\n\n"
                return
            try:
                await asyncio.wait_for(news.wait(), 15.0)
            except TimeoutError:
                yield ": waiting\n\n"


async def _line(stream: asyncio.StreamReader) -> bytes:
    """The next line; what is too long for one is cut."""
    try:
        return await stream.readline()
    except ValueError:
        return b"...\n"


def _tell(job: Job) -> None:
    """Wake all pages that watch, each of which waits on the event of this moment."""
    job.news.set()
    job.news = asyncio.Event()


def _signal(group: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, number)


def _as_a_shell_starts_it() -> None:
    """In the new process: Ctrl-C counts, and the end of the studio, however it comes, is one."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, signal.SIGINT)
