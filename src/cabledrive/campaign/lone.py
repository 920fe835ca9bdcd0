"""Rows in a process of their own, which they may end: a trial of the first ones, a chunk that ended one."""

import multiprocessing
import signal
from multiprocessing.sharedctypes import Synchronized
from typing import Any

from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.work import Plan, Report, chosen_chunk, do_chunk, untried_chunk
from cabledrive.parameters import NotComputed

CERTAIN = 2
"""Times that a process has to end at the same row before the row is blamed."""
STARTING = -1


def trial_alone(spec: CampaignSpec, workers: int) -> int:
    """Rows of a chunk by a trial of the first rows; a fixed number where they end their process.

    ``workers``: that share the rows.
    """
    context = multiprocessing.get_context("spawn")
    reader, writer = context.Pipe(duplex=False)
    child = context.Process(target=_try_rows, args=(spec, workers, writer), daemon=True)
    child.start()
    writer.close()
    try:
        rows: int = reader.recv()
    except EOFError:
        return untried_chunk(spec, workers)
    finally:
        child.join()
        reader.close()
    return rows


def _try_rows(spec: CampaignSpec, workers: int, writer: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the driver's business
    writer.send(chosen_chunk(spec, workers))


def do_alone(number: int, plan: Plan) -> Report:
    """Compute a chunk in processes of its own, and mark the rows that end them.

    The chunk is tried as any other first, to the same bits; row by row where that ends the process.
    Raises `NotComputed` if the processes end before any row.
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
    context = multiprocessing.get_context("spawn")
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
