"""How chunks get done: by this process, by processes of this machine, or by the workers of a cluster.

Each is an executor of `concurrent.futures`. One whose task ended its process is opened anew; the chunks that
it had in hand are handed out once more, and one that was lost twice is computed alone in the end.
"""

import logging
import multiprocessing
import os
import signal
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from threading import Thread
from typing import Any
from unittest.mock import patch

import numpy as np

from cabledrive.campaign.rows import Chunk, compute_rows, lost_row
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.store import EXTRA, write_chunk
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.version import __version__

WORK = 5.0
"""Of a chunk, where the SPEC leaves it open [s]."""
PROBE = 0.5
"""How long rows are tried to learn how long they take [s]."""
MOST_ROWS = 25_000
"""Of a chunk: so that a campaign of fast rows has chunks to divide."""
UNTRIED = 100
"""Rows of a chunk where the trial ended its process."""
CHUNKS_EACH = 4
"""Least chunks for each worker, where there are rows enough."""
METHOD = "forkserver" if sys.platform == "linux" else "spawn"
"""Elsewhere libraries of the system do not stand a fork after they were loaded."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
OF_ALL = ("cabledrive.campaign.engine", "cabledrive.campaign.loaded_kernels", "zarr.codecs")
"""Modules of every process; one that is not installed is passed over."""
CERTAIN = 2
"""Times that a row, or a chunk, has to end its process before it is blamed."""
BEGIN = 0.05
"""Of a task that does nothing but begin a process [s]."""
PATIENCE = 20.0
"""Until a scheduler has to answer [s]."""
TASKS_EACH = 2
"""Chunks that a worker of a cluster has in hand, so that it does not wait for the next one."""
LOGGERS = (*(f"distributed{part}" for part in ("", ".nanny", ".scheduler", ".worker")), "tornado.application")

Counts = dict[str, int]
"""Rows done, refused and failed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plan:
    """A campaign with its store."""

    spec: CampaignSpec
    store: Path
    chunk: int  # rows of a chunk

    @property
    def chunks(self) -> range:
        """Numbers of the chunks."""
        return range(-(-self.spec.design.rows // self.chunk))

    def bounds(self, number: int) -> tuple[int, int]:
        """First row of a chunk and the row behind its last one."""
        return number * self.chunk, min((number + 1) * self.chunk, self.spec.design.rows)


def do_chunk(number: int, plan: Plan) -> Counts:
    """Compute a chunk and write it; `OSError` if the disk refuses."""
    first, last = plan.bounds(number)
    return write_chunk(plan.store, first, compute_rows(plan.spec, first, last))


def chosen_chunk(spec: CampaignSpec, workers: int) -> int:
    """Rows of about five seconds of work, by a trial of the first rows; kernels are compiled by then."""
    rows = spec.design.rows
    if rows == 1:
        return 1
    compute_rows(spec, 0, 1)
    if spec.chunk is not None:
        return min(spec.chunk, rows)
    tried, spent, count = 1, 0.0, 1  # the first row's time is that of compiling
    while spent < PROBE and tried < rows:
        last = min(tried + count, rows)
        began = time.perf_counter()
        compute_rows(spec, tried, last)
        spent += time.perf_counter() - began
        tried, count = last, 2 * count
    fitting = int(WORK * (tried - 1) / max(spent, 1e-9))
    return max(1, min(fitting, shared_rows(spec, workers), MOST_ROWS, rows))


def shared_rows(spec: CampaignSpec, workers: int) -> int:
    """Rows of a chunk at which each worker has enough of them."""
    return -(-spec.design.rows // (CHUNKS_EACH * workers))


class Here(Executor):
    """Does each task at once, in this process."""

    def submit(self, task: Callable[..., Any], /, *given: Any, **named: Any) -> Future[Any]:
        """The task, done."""
        done: Future[Any] = Future()
        try:
            done.set_result(task(*given, **named))
        except Exception as error:
            done.set_exception(error)
        return done


class Processes(ProcessPoolExecutor):
    """Processes of this machine, which end with this one, or when they are closed, whatever they do.

    They are forked from one that has loaded what the rows import, and computes nothing, so that it has one
    thread: eight that load it each for itself are busy for four times as long on two cores.
    """

    def __init__(self, spec: CampaignSpec, count: int) -> None:
        context: Any = multiprocessing.get_context(METHOD)
        if METHOD == "forkserver":
            from multiprocessing.forkserver import ensure_running

            needed = [
                name for part in (spec.computation, spec.design) for name in getattr(part, "modules", ())
            ]
            context.set_forkserver_preload([*OF_ALL, *needed])
            with patch.dict(os.environ, ONE_THREAD):
                ensure_running()
        self._others = set(multiprocessing.active_children())
        super().__init__(count, mp_context=context, initializer=_follow_driver)

    @property
    def processes(self) -> list[Any]:
        """Those that run."""
        return [one for one in multiprocessing.active_children() if one not in self._others]

    def __exit__(self, *why: object) -> None:
        """End the processes."""
        for process in self.processes:
            process.kill()
        self.shutdown(cancel_futures=True)


def _follow_driver() -> None:
    """Leave an interrupt to the driver, and end when it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    driver = multiprocessing.parent_process()
    assert driver is not None

    def end() -> None:
        wait_for([driver.sentinel])
        os._exit(1)

    Thread(target=end, daemon=True).start()


@dataclass(frozen=True, slots=True, eq=False)
class Engine:
    """Hands out chunks to the executor that it opens."""

    name: str
    count: int  # tasks that the executor does at a time
    opened: Callable[[CampaignSpec], AbstractContextManager[Executor]]
    lost: tuple[type[Exception], ...] = (BrokenExecutor, MemoryError)  # what a lost task raises

    def chunk(self, spec: CampaignSpec) -> int:
        """Rows of a chunk by a trial of the first rows; a fixed number where they end their process."""
        with self.opened(spec) as executor:
            try:
                return executor.submit(chosen_chunk, spec, self.count).result()
            except self.lost:
                return min(spec.chunk or min(UNTRIED, shared_rows(spec, self.count)), spec.design.rows)

    def reports(self, plan: Plan, todo: Sequence[int]) -> Iterator[Counts | None]:
        """Rows of each chunk as it is done, None when they begin; `OSError` if the disk refuses."""
        left, losses = deque(todo), Counter[int]()
        while left:
            with self.opened(plan.spec) as executor:
                if self.count > 1:  # one worker compiles the kernels that the others load
                    wait([executor.submit(compute_rows, plan.spec, 0, 1)])
                    wait([executor.submit(time.sleep, BEGIN) for _ in range(self.count)])
                yield None
                yield from self._until_lost(executor, plan, left, losses)
        for number, times in losses.items():
            if times >= CERTAIN:
                yield do_alone(number, plan)

    def _until_lost(
        self, executor: Executor, plan: Plan, left: deque[int], losses: Counter[int]
    ) -> Iterator[Counts]:
        """The same until no chunk is left, or a process has ended; what it had in hand is left once more."""
        busy: dict[Future[Counts], int] = {}
        broken = False
        while busy or (left and not broken):
            while left and not broken and len(busy) < self.count:
                number = left.popleft()
                try:
                    busy[executor.submit(do_chunk, number, plan)] = number
                except BrokenExecutor:  # a process ended between two tasks
                    broken = True
                    left.append(number)
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                number = busy.pop(future)
                try:
                    yield future.result()
                except self.lost:
                    broken = True
                    losses[number] += 1
                    if losses[number] < CERTAIN:
                        left.append(number)


@contextmanager
def chosen_engine(workers: int | None, scheduler: str | None, part: str) -> Iterator[Engine]:
    """The engine that was asked for; refused: a scheduler that does not answer, or together with a part."""
    if part and scheduler is not None:
        raise InputRefused("--part and --scheduler do not go together: give one of them")
    if scheduler is not None:
        with cluster_at(scheduler) as engine:
            yield engine
    else:
        name = "this process" if workers is None else f"{workers} local workers"
        name = f"{name}, {part}" if part else name
        yield Engine(name, workers or 1, lambda spec: Here() if workers is None else Processes(spec, workers))


def do_alone(number: int, plan: Plan) -> Counts:
    """Compute a chunk that may have ended a process: as any other first, to the same bits, then row by row.

    A row is marked as not completed where it ends its process each time; `NotComputed` if processes end
    before any row.
    """
    (first, last), rows = plan.bounds(number), list[Chunk]()
    with suppress(NotComputed):
        found: Counts | None = _alone(plan.spec, f"chunk {number}", do_chunk, number, plan)[0]
        if found is not None:
            return found
    for row in range(first, last):
        for _ in range(CERTAIN):
            chunk, status = _alone(plan.spec, f"row {row}", compute_rows, plan.spec, row, row + 1)
            if chunk is not None:
                break
        rows.append(lost_row(plan.spec, row, _how(status)) if chunk is None else chunk)
    return write_chunk(
        plan.store, first, {name: np.concatenate([one[name] for one in rows]) for name in rows[0]}
    )


def _alone(spec: CampaignSpec, name: str, task: Callable[..., Any], *given: Any) -> tuple[Any, int]:
    """What a task gives in a process of its own, None where it ends it, and how that ended."""
    with Processes(spec, 1) as process:
        try:
            process.submit(os.getpid).result()
        except BrokenExecutor:
            raise NotComputed(f"{name}: its process ended before the row began") from None
        (worker,) = process.processes
        try:
            return process.submit(task, *given).result(), 0
        except BrokenExecutor:
            process.shutdown()  # reads how it ended; whoever asks at the same time may find nothing
            return None, worker.exitcode


def _how(status: int) -> str:
    """How a process ended, in words."""
    if status >= 0:
        return f"exit status {status}"
    known = -status in {number.value for number in signal.Signals}
    return f"signal {signal.Signals(-status).name if known else -status}"


@contextmanager
def cluster_at(url: str) -> Iterator[Engine]:
    """The workers of a scheduler of dask.distributed that is there already, such as tls://host:8786.

    Refused if it does not answer, or has no workers, or one has another version of the package.
    """
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise InputRefused(f"--scheduler: {EXTRA}") from None
    with ExitStack() as stack:
        for name in LOGGERS:  # what matters of the library's own lines is said by the campaign
            logger = logging.getLogger(name)
            stack.callback(logger.setLevel, logger.level)
            logger.setLevel(logging.CRITICAL + 1)
        try:
            client = stack.enter_context(Client(url, timeout=PATIENCE, set_as_default=False))
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InputRefused(
                f"--scheduler {url}: does not answer ({why}): check address and port"
            ) from None

        @contextmanager
        def opened(spec: CampaignSpec) -> Iterator[Executor]:
            """The workers, of which one on each machine has compiled the kernels."""
            known: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
            one_each = {worker["host"]: address for address, worker in known.items()}
            client.run(compute_rows, spec, 0, 1, workers=[*one_each.values()], on_error="ignore")
            executor = client.get_executor(pure=False)
            try:
                yield executor
            finally:
                executor.shutdown(wait=False)

        versions = client.run(_version)
        if not versions:
            raise InputRefused(f"--scheduler {url}: has no workers: start some first")
        for worker, version in sorted(versions.items()):
            if version != __version__:
                said = f"--scheduler {url}: worker {worker} has cabledrive {version}, this is {__version__}"
                raise InputRefused(f"{said}: install one version everywhere")
        yield Engine(url, TASKS_EACH * len(versions), opened, (KilledWorker, MemoryError))


def _version() -> str:
    """Version of the package on a worker."""
    try:
        from cabledrive.parameters.version import __version__ as theirs
    except ImportError:
        return "not installed"
    return theirs
