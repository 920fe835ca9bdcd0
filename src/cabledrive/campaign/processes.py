"""Processes of a campaign on this machine: each does one task after another, and may be ended by a row.

They are forked from one that has loaded the package, where that is safe: eight that load it each for itself
are busy for four times as long on two cores.
"""

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from typing import Any

from cabledrive.campaign.rows import Chunk, compute_rows, counts, joined, lost_row
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.store import write_chunk
from cabledrive.campaign.work import Plan, Report, chosen_chunk, do_chunk, untried_chunk
from cabledrive.parameters import NotComputed

METHOD = "forkserver" if sys.platform == "linux" else "spawn"
"""Elsewhere libraries of the system do not stand a fork after they were loaded."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
OF_ALL = ("cabledrive.campaign.processes", "cabledrive.campaign.loaded_kernels", "zarr.codecs")
"""Modules of every process; one that is not installed is passed over."""
CERTAIN = 2
"""Times that a row has to end its process before it is blamed."""


def process_context(spec: CampaignSpec) -> Any:
    """What begins the processes of a campaign.

    The process that they are forked from loads what the rows import, and computes nothing, so that it has
    one thread. Where it runs already, or there is none, each process loads what it lacks.
    """
    context: Any = multiprocessing.get_context(METHOD)
    if METHOD == "forkserver":
        from multiprocessing.forkserver import ensure_running

        needed = [name for part in (spec.computation, spec.design) for name in getattr(part, "modules", ())]
        context.set_forkserver_preload([*OF_ALL, *needed])
        with _environment(ONE_THREAD):
            ensure_running()
    return context


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """Variables of the environment, for the processes that begin meanwhile."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


class WorkerEnded(Exception):
    """A process that ended instead of answering, and how, in words."""


class Worker:
    """A process that does the tasks it is given; it ends with this one, or when it is closed."""

    def __init__(self, spec: CampaignSpec) -> None:
        context = process_context(spec)
        self.pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def begin(self, task: Callable[..., Any], *given: Any) -> None:
        """Hand over a task; a process that has ended says so when it is asked for its answer."""
        with suppress(OSError):
            self.pipe.send((task, given))

    def answer(self) -> Any:
        """What the task gave or raised; `WorkerEnded`."""
        try:
            found = self.pipe.recv()
        except (EOFError, OSError):
            self._process.join()
            raise WorkerEnded(_how(self._process.exitcode)) from None
        if isinstance(found, Exception):
            raise found
        return found

    def close(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _serve(pipe: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the driver's business
    with suppress(EOFError, OSError):  # the driver has ended
        while True:
            task, given = pipe.recv()
            try:
                found = task(*given)
            except Exception as error:
                found = error
            pipe.send(found)


def _how(status: int | None) -> str:
    """How a process ended, in words."""
    if status is not None and status < 0:
        try:
            return f"signal {signal.Signals(-status).name}"
        except ValueError:
            return f"signal {-status}"
    return f"exit status {status}"


def tried_chunk(spec: CampaignSpec, workers: int) -> int:
    """Rows of a chunk by a trial in a process of its own; a fixed number where the first rows end it."""
    with closing(Worker(spec)) as worker:
        worker.begin(chosen_chunk, spec, workers)
        try:
            rows: int = worker.answer()
        except WorkerEnded:
            return untried_chunk(spec, workers)
        return rows


def do_alone(number: int, plan: Plan) -> Report:
    """Compute a chunk that may have ended a process: as any other first, to the same bits, then row by row.

    `NotComputed` if processes end before any row.
    """
    began = time.perf_counter()
    with closing(Worker(plan.spec)) as worker, suppress(WorkerEnded):
        worker.begin(do_chunk, number, plan)
        report: Report = worker.answer()
        return report
    first, last = plan.bounds(number)
    with closing(Worker(plan.spec)) as worker:
        worker.begin(os.getpid)
        try:
            worker.answer()
        except WorkerEnded as how:
            raise NotComputed(
                f"rows {first} to {last - 1}: the process ended before the first row ({how})"
            ) from None
    chunk = joined([_row_alone(plan.spec, row) for row in range(first, last)])
    write_chunk(plan.store, first, chunk)
    return Report(number=number, **counts(chunk.code), seconds=time.perf_counter() - began)


def _row_alone(spec: CampaignSpec, row: int) -> Chunk:
    """One row, marked as not completed where it ends its process each time."""
    why = ""
    for _ in range(CERTAIN):
        with closing(Worker(spec)) as worker:
            worker.begin(compute_rows, spec, row, row + 1)
            try:
                chunk: Chunk = worker.answer()
            except WorkerEnded as how:
                why = str(how)
            else:
                return chunk
    return lost_row(spec, row, why)
