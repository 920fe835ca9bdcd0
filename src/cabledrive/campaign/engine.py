"""What hands out the chunks: this process, processes of this machine, or the workers of a cluster.

Each is an executor of `concurrent.futures`. One whose task ended its process is opened anew; the chunks that
it had in hand are handed out once more, and one that was lost twice is computed alone in the end.
"""

import multiprocessing
import os
import signal
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager, suppress
from multiprocessing.connection import wait as wait_for
from threading import Thread
from typing import Any
from unittest.mock import patch

from cabledrive.campaign.rows import Chunk, compute_rows, joined, lost_row
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.store import write_chunk
from cabledrive.campaign.work import Plan, chosen_chunk, do_chunk, untried_chunk
from cabledrive.parameters import InputRefused, NotComputed

METHOD = "forkserver" if sys.platform == "linux" else "spawn"
"""Elsewhere libraries of the system do not stand a fork after they were loaded."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
OF_ALL = ("cabledrive.campaign.engine", "cabledrive.campaign.loaded_kernels", "zarr.codecs")
"""Modules of every process; one that is not installed is passed over."""
CERTAIN = 2
"""Times that a row, or a chunk, has to end its process before it is blamed."""


BEGIN = 0.05
"""Of a task that does nothing but begin a process [s]."""


Counts = dict[str, int]
"""Rows done, refused and failed."""


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


Opened = Callable[[CampaignSpec], AbstractContextManager[Executor]]


class Engine:
    """Hands out chunks to the executor that it opens; ``count``: tasks that it does at a time."""

    def __init__(
        self,
        name: str,
        count: int,
        opened: Opened,
        lost: tuple[type[Exception], ...] = (BrokenExecutor, MemoryError),
    ) -> None:
        self.name, self._count, self._opened, self._lost = name, count, opened, lost

    def chunk(self, spec: CampaignSpec) -> int:
        """Rows of a chunk by a trial of the first rows; a fixed number where they end their process."""
        with self._opened(spec) as executor:
            try:
                rows: int = executor.submit(chosen_chunk, spec, self._count).result()
            except self._lost:
                return untried_chunk(spec, self._count)
            return rows

    def reports(self, plan: Plan, todo: Sequence[int]) -> Iterator[Counts | None]:
        """Rows of each chunk as it is done, None when they begin; `OSError` if the disk refuses."""
        left, losses = deque(todo), Counter[int]()
        while left:
            with self._opened(plan.spec) as executor:
                if self._count > 1:  # one worker compiles the kernels that the others load
                    wait([executor.submit(compute_rows, plan.spec, 0, 1)])
                    wait([executor.submit(time.sleep, BEGIN) for _ in range(self._count)])
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
            while left and not broken and len(busy) < self._count:
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
                except self._lost:
                    broken = True
                    losses[number] += 1
                    if losses[number] < CERTAIN:
                        left.append(number)


@contextmanager
def chosen_engine(
    workers: int | None, scheduler: str | None, part: tuple[int, int] | None
) -> Iterator[Engine]:
    """The engine that was asked for; refused: a scheduler that does not answer, or together with a part."""
    if part is not None and scheduler is not None:
        raise InputRefused("--part and --scheduler do not go together: give one of them")
    if scheduler is not None:
        from cabledrive.campaign.cluster import cluster_at

        with cluster_at(scheduler) as (count, opened, lost):
            yield Engine(scheduler, count, opened, lost)
    else:
        name = "this process" if workers is None else f"{workers} local workers"
        name = f"{name}, part {part_words(part)}" if part else name
        yield Engine(name, workers or 1, lambda spec: Here() if workers is None else Processes(spec, workers))


def part_words(part: tuple[int, int] | None) -> str:
    """A part in words, "3 of 16"; empty for the whole."""
    return "" if part is None else f"{part[0]} of {part[1]}"


def do_alone(number: int, plan: Plan) -> Counts:
    """Compute a chunk that may have ended a process: as any other first, to the same bits, then row by row.

    `NotComputed` if processes end before any row.
    """
    with Processes(plan.spec, 1) as process, suppress(BrokenExecutor):
        found: Counts = process.submit(do_chunk, number, plan).result()
        return found
    first, last = plan.bounds(number)
    return write_chunk(plan.store, first, joined([_row_alone(plan.spec, row) for row in range(first, last)]))


def _row_alone(spec: CampaignSpec, row: int) -> Chunk:
    """One row, marked as not completed where it ends its process each time."""
    why = ""
    for _ in range(CERTAIN):
        with Processes(spec, 1) as process:
            try:
                process.submit(os.getpid).result()
            except BrokenExecutor:
                raise NotComputed(f"row {row}: its process ended before the row began") from None
            (worker,) = process.processes
            try:
                chunk: Chunk = process.submit(compute_rows, spec, row, row + 1).result()
            except BrokenExecutor:
                process.shutdown()  # reads how it ended; whoever asks at the same time may find nothing
                why = _how(worker.exitcode)
            else:
                return chunk
    return lost_row(spec, row, why)


def _how(status: int) -> str:
    """How a process ended, in words."""
    if status >= 0:
        return f"exit status {status}"
    known = -status in {number.value for number in signal.Signals}
    return f"signal {signal.Signals(-status).name if known else -status}"
