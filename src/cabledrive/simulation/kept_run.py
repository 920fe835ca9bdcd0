"""A prepared run taken to its end, in memory or into a file that can be gone on with after an interrupt."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.files import check_writable
from cabledrive.parameters.one_process import one_process
from cabledrive.simulation.labels import Content
from cabledrive.simulation.netcdf import write_netcdf
from cabledrive.simulation.prepared_run import PreparedRun
from cabledrive.simulation.records import Records, RecordsInFolder, RecordsInMemory
from cabledrive.simulation.run import Outcome, integrate_run
from cabledrive.simulation.run_folder import RESULT, left_behind, part_of

# What comes out of a kind of run: a frozen dataclass with `path` and `stopped`.
Result = TypeVar("Result", bound=Any)


def keep_run(
    case: PreparedRun,
    result_of: Callable[[Records, Outcome], Result],
    content_of: Callable[[Result], Content],
    *,
    output: str | Path | None,
    force: bool,
    resume: bool,
    progress: bool | None,
) -> tuple[Result, Outcome]:
    """Take a run to its end, or as far as it goes; options as of `cabledrive.simulation.simulate`."""
    if output is None:
        if resume:
            raise InputRefused("resume needs the output of the interrupted run: name it")
        records = RecordsInMemory(case)
        outcome = integrate_run(case, records, progress=progress)
        return result_of(records, outcome), outcome
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
                return _take(kept, case, result_of, content_of, path, force=force, progress=progress)
            finally:
                kept.close()
        except KeyboardInterrupt:  # before the first step, or at the end
            if not left_behind(folder):
                raise
            raise KeyboardInterrupt("go on with the same command and --resume") from None
        except OSError as error:
            why = f"cannot be written ({error.strerror or error})"
            raise NotComputed(f"{folder}: {why}: free space and go on with --resume") from error


def _take(
    records: RecordsInFolder,
    case: PreparedRun,
    result_of: Callable[[Records, Outcome], Result],
    content_of: Callable[[Result], Content],
    path: Path,
    *,
    force: bool,
    progress: bool | None,
) -> tuple[Result, Outcome]:
    outcome = integrate_run(case, records, resumed=records.resumed, progress=progress)
    if outcome.interrupted or outcome.unwritten:
        return result_of(records, outcome), outcome
    records.check(outcome.records)
    result = result_of(records, outcome)
    try:
        write_netcdf(content_of(result), path, records.folder / RESULT, force=force)
    except OSError as error:
        stopped = f"{path}: cannot be written ({error.strerror or error}): free space and resume"
        return replace(result, stopped=stopped), outcome
    try:
        records.remove()
    except KeyboardInterrupt:
        records.remove()
        raise KeyboardInterrupt(f"{path} was written before") from None
    return replace(result, path=path), outcome


def keep_again(content: Content, path: Path) -> None:
    """Replace a file that was just written by one that says more."""
    with one_process(part_of(path)):
        try:
            write_netcdf(content, path, part_of(path) / RESULT, force=True)
        except OSError as error:
            why = f"cannot be written again ({error.strerror or error})"
            raise NotComputed(f"{path}: {why}: it lacks the estimate of its error") from error


def how_to_go_on(reached: float, output: str | Path | None) -> str:
    """One line about an interrupted run; ``reached``: time up to there [s]."""
    line = f"{reached:.6g} s were simulated"
    if output is None:
        return f"{line}; with an output file the run could be resumed"
    return f"{line}; go on with the same command and --resume"
