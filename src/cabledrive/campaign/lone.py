"""Rows in a process of their own, which they may end: a trial of the first ones, a chunk that ended one."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.sharedctypes import Synchronized
from typing import Any

from cabledrive.campaign.processes import process_context
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.work import Plan, Report, chosen_chunk, do_chunk, untried_chunk
from cabledrive.parameters import NotComputed

CERTAIN = 2
"""Times that a process has to end at the same row before the row is blamed."""
STARTING = -1


class Trial:
    """A trial of the first rows in a process of its own, which begins at once and is waited for later."""

    def __init__(self, spec: CampaignSpec, workers: int) -> None:
        """``workers``: that share the rows."""
        context = process_context(spec)
        self._spec, self._workers = spec, workers
        self._reader, writer = context.Pipe(duplex=False)
        self._child = context.Process(target=_try_rows, args=(spec, workers, writer), daemon=True)
        self._child.start()
        writer.close()

    def chunk(self) -> int:
        """Rows of a chunk; a fixed number where the first rows end their process."""
        try:
            rows: int = self._reader.recv()
        except EOFError:
            return untried_chunk(self._spec, self._workers)
        return rows

    def end(self) -> None:
        """End the process, whether or not it has answered."""
        self._child.kill()
        self._child.join()
        self._reader.close()


@contextmanager
def trial_begun(spec: CampaignSpec, workers: int) -> Iterator[Trial]:
    """A trial, ended with the context."""
    trial = Trial(spec, workers)
    try:
        yield trial
    finally:
        trial.end()


def _try_rows(spec: CampaignSpec, workers: int, writer: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the driver's business
    writer.send(chosen_chunk(spec, workers))


def do_alone(number: int, plan: Plan) -> Report:
    """Compute a chunk in processes of its own, and mark the rows that end them.

    The chunk is tried as any other first, to the same bits; row by row where that ends the process.
    `NotComputed` if the processes end before any row.
    """
    poisoned: dict[int, str] = {}
    ended: dict[int, int] = {}
    at_once = True
    while True:
        report, row, why = _try(number, plan, poisoned, at_once)
        if report is not None:
            return report
        if at_once and row == STARTING:
            at_once = False
            continue
        ended[row] = ended.get(row, 0) + 1
        if ended[row] < CERTAIN:
            continue
        if row == STARTING:
            first, last = plan.bounds(number)
            raise NotComputed(f"rows {first} to {last - 1}: the process ended before the first row ({why})")
        poisoned[row], at_once = why, True


def _try(number: int, plan: Plan, poisoned: dict[int, str], at_once: bool) -> tuple[Report | None, int, str]:
    """The report, or the row at which the process ended, and how."""
    context = process_context(plan.spec)
    row = context.Value("q", STARTING)
    reader, writer = context.Pipe(duplex=False)
    child = context.Process(
        target=_in_child, args=(number, plan, poisoned, at_once, row, writer), daemon=True
    )
    child.start()
    writer.close()
    answer: Any = None
    try:
        answer = reader.recv()
    except EOFError:
        pass
    finally:
        child.join()
        reader.close()
    if isinstance(answer, BaseException):
        raise answer
    return answer, row.value, _how(child.exitcode)


def _in_child(
    number: int, plan: Plan, poisoned: dict[int, str], at_once: bool, row: "Synchronized[int]", writer: Any
) -> None:
    def begin(now: int) -> None:
        row.value = now

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the driver's business
    try:
        writer.send(do_chunk(number, plan, poisoned=poisoned, begin=begin, at_once=at_once))
    except Exception as error:
        writer.send(error)


def _how(status: int | None) -> str:
    """How a process ended, in words."""
    if status is not None and status < 0:
        try:
            return f"signal {signal.Signals(-status).name}"
        except ValueError:
            return f"signal {-status}"
    return f"exit status {status}"
