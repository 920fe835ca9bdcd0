"""The run: chunk after chunk of steps, recorded, committed, watched for whatever ends it early."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cabledrive.simulation.plan import copy_state
from cabledrive.simulation.prepared_run import PreparedRun
from cabledrive.simulation.progress import Progress
from cabledrive.simulation.records import Records

NODE_STEPS_PER_CHUNK = 20_000_000
SECONDS_PER_COMMIT = 5.0
INTERRUPTED, UNWRITTEN = "interrupted", "the records cannot be written"


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """How a run ended."""

    state: Any  # at the end
    stopped: str | None  # why it ended early, in one line; None if it did not
    interrupted: bool  # from outside
    unwritten: bool  # the disk refused its records
    records: int  # records that belong to the run so far
    wall_time: float  # how long it took [s]


def integrate_run(
    case: PreparedRun,
    records: Records,
    *,
    resumed: tuple[Any, int] | None = None,
    progress: bool | None = False,
) -> Outcome:
    """Take all steps of a run, or as many as can be taken.

    ``records``: gets the records; ``resumed``: state and number of records from which to go on; ``progress``:
    whether to show on standard error how far it is; None: where that is a terminal.
    """
    began = time.perf_counter()
    state, done = resumed or (case.first_state(), 0)
    watch = Progress(case.grid.records * case.grid.interval, progress)
    state, done, stopped = _chunks(case, records, state, done, watch)
    watch.end()
    return Outcome(
        state=state,
        stopped=stopped,
        interrupted=stopped == INTERRUPTED,
        unwritten=(stopped or "").startswith(UNWRITTEN),
        records=done,
        wall_time=time.perf_counter() - began,
    )


def _chunks(
    case: PreparedRun, records: Records, state: Any, done: int, watch: Progress
) -> tuple[Any, int, str | None]:
    """Integrate to the end; returns the state there, the records, and why the run stopped before, if so."""
    stepper = case.stepper()
    per_chunk = max(1, NODE_STEPS_PER_CHUNK // (case.nodes * case.grid.every))
    committed = time.monotonic()
    try:
        while done < case.grid.records:
            count = min(per_chunk, case.grid.records - done)
            fresh = copy_state(state)
            rows, fields, stopped = stepper.chunk(fresh, done, count)
            unwritten = _written(records.append, rows, fields)
            if unwritten:
                return state, done, stopped or unwritten
            if stopped:
                return fresh, done + len(rows), stopped
            state, done = fresh, done + count
            watch.at(done * case.grid.interval)
            if time.monotonic() - committed > SECONDS_PER_COMMIT:
                if unwritten := _written(records.commit, state, done):
                    return state, done, unwritten
                committed = time.monotonic()
        rows, fields, stopped = stepper.last(state)
        stopped = stopped or _written(records.append, rows, fields)
        return state, done + (0 if stopped else 1), stopped
    except KeyboardInterrupt:
        _written(records.commit, state, done)
        return state, done, INTERRUPTED


def _written(action: Callable[..., None], *content: Any) -> str | None:
    """Write something; returns one line where the disk refuses."""
    try:
        action(*content)
    except OSError as error:
        return f"{UNWRITTEN} ({error.strerror}): free space and resume"
    return None
