"""The run: chunk after chunk of steps, recorded, committed, taken to its end or gone on with."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.files import check_writable, one_process
from cabledrive.parameters.terminal import Progress
from cabledrive.simulation.keeping import RESULT, Records, RecordsInFolder, left_behind, part_of
from cabledrive.simulation.netcdf import write_netcdf
from cabledrive.simulation.plan import copy_state
from cabledrive.simulation.prepared import Outcome, PreparedRun
from cabledrive.simulation.result import SimulationResult

NODE_STEPS_PER_CHUNK = 20_000_000
SECONDS_PER_COMMIT = 5.0
MOST_LOADED = 1_000_000_000  # bytes
INTERRUPTED, UNWRITTEN = "interrupted", "the records cannot be written"


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
    watch = Progress(case.grid.records, progress)
    state, done, stopped = _chunks(case, records, *(resumed or (case.first_state(), 0)), watch)
    watch.end()
    rows, fields = records.arrays()
    return Outcome(_loaded(rows[:done]), _loaded(fields), state, stopped, time.perf_counter() - began)


def _loaded(array: Array) -> Array:
    """Moderate records in memory; larger ones stay in their file, which lives as long as it is mapped."""
    return np.array(array) if array.nbytes <= MOST_LOADED else array


def _chunks(
    case: PreparedRun, records: Records, state: Any, done: int, watch: Progress
) -> tuple[Any, int, str | None]:
    """Integrate to the end; returns the state there, the records, and why the run stopped before, if so."""
    per_chunk = max(1, NODE_STEPS_PER_CHUNK // (case.nodes * case.grid.every))
    committed = time.monotonic()
    try:
        while done < case.grid.records:
            count = min(per_chunk, case.grid.records - done)
            fresh = copy_state(state)
            rows, fields, stopped = case.chunk(fresh, done, count)
            unwritten = _written(records.append, rows, fields)
            if unwritten:
                return state, done, stopped or unwritten
            if stopped:
                return fresh, done + len(rows), stopped
            state, done = fresh, done + count
            reached, whole = (n * case.grid.interval for n in (done, case.grid.records))
            watch.at(done, f"{reached:.4g} s of {whole:.4g} s ({100.0 * reached / whole:.0f} %)")
            if time.monotonic() - committed > SECONDS_PER_COMMIT:
                if unwritten := _written(records.commit, state, done):
                    return state, done, unwritten
                committed = time.monotonic()
        rows, fields, stopped = case.last(state)
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


def keep_run(
    case: PreparedRun, *, output: str | Path | None, force: bool, resume: bool, progress: bool | None
) -> SimulationResult:
    """Take a run to its end, or as far as it goes; options as of `cabledrive.simulation.simulate`.

    Raises `SimulationInterrupted` if it was interrupted from outside.
    """
    if output is None:
        if resume:
            raise InputRefused("resume needs the output of the interrupted run: name it")
        return _finished(case.result(integrate_run(case, Records(case), progress=progress)), output)
    path = Path(output)
    check_writable(path, force=force)
    folder = part_of(path)
    if left_behind(folder) and not (resume or force):
        raise InputRefused(
            f"{folder}: left by an interrupted run: go on with it (resume) or replace it (force)"
        )
    with one_process(folder):
        check_writable(path, force=force)  # by now another process may have ended with this file
        try:
            kept = RecordsInFolder(folder, case, resume=resume)
            try:
                outcome = integrate_run(case, kept, resumed=kept.resumed, progress=progress)
                result = case.result(outcome)
                if outcome.stopped != INTERRUPTED and not (outcome.stopped or "").startswith(UNWRITTEN):
                    result = _put(result, path, kept, force=force)
            finally:
                kept.close()
        except KeyboardInterrupt:  # before the first step, or at the end
            if not left_behind(folder):
                raise
            raise KeyboardInterrupt("go on with the same command and --resume") from None
        except OSError as error:
            why = f"cannot be written ({error.strerror or error})"
            raise NotComputed(f"{folder}: {why}: free space and go on with --resume") from error
    return _finished(result, output)


def _put(result: SimulationResult, path: Path, records: RecordsInFolder, *, force: bool) -> SimulationResult:
    """Write the result and delete its records; where the disk refuses, say so and keep them."""
    for file in records.files:
        file.flush()
    try:
        write_netcdf(result.content, path, records.folder / RESULT, force=force)
    except OSError as error:
        stopped = f"{path}: cannot be written ({error.strerror or error}): free space and resume"
        return replace(result, stopped=stopped)
    try:
        records.remove()
    except KeyboardInterrupt:
        records.remove()
        raise KeyboardInterrupt(f"{path} was written before") from None
    return replace(result, path=path)


def _finished(result: SimulationResult, output: str | Path | None) -> SimulationResult:
    """The result of a run that was not interrupted."""
    if result.stopped != INTERRUPTED:
        return result
    go_on = "go on with the same command and --resume"
    if output is None:
        go_on = "with an output file the run could be resumed"
    raise SimulationInterrupted(f"{result.steps * result.step:.6g} s were simulated; {go_on}", result)


Kept = TypeVar("Kept", bound=SimulationResult)


def whole(result: Kept) -> Kept:
    """A result of a run that came to its end; `NotComputed` with the reason of one that did not."""
    if result.stopped is not None:
        raise NotComputed(result.stopped)
    return result


class SimulationInterrupted(KeyboardInterrupt):
    """The run was interrupted from outside; its line says how to go on.

    Attributes
    ----------
    result : SimulationResult
        Everything up to there.
    """

    def __init__(self, message: str, result: SimulationResult) -> None:
        super().__init__(message)
        self.result = result
