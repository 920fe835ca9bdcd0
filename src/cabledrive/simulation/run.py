"""The run: chunk after chunk of steps, recorded, committed, taken to its end or gone on with."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.files import check_writable, one_process
from cabledrive.parameters.terminal import TerminalLine, on_a_terminal
from cabledrive.simulation.case import Case
from cabledrive.simulation.checkpoint import RESULT, left_behind, part_of
from cabledrive.simulation.netcdf import Content, write_netcdf
from cabledrive.simulation.plan import RADIUS, copy_state
from cabledrive.simulation.records import PreparedRun, Records, RecordsInFolder, RecordsInMemory
from cabledrive.simulation.result import SimulationResult, energy_handled, rest_energy, slack_events

if TYPE_CHECKING:
    from cabledrive.simulation.network.result import NetworkResult


SECONDS_BETWEEN = 0.5


class Progress:
    """Progress of a run of some length [s], rewritten twice a second, by default where a terminal reads."""

    def __init__(self, duration: float, shown: bool | None) -> None:
        self._duration = duration
        self._shown = on_a_terminal() if shown is None else shown
        self._began = self._last = time.monotonic()
        self._from: float | None = None
        self._line = TerminalLine()

    def at(self, simulated: float) -> None:
        """Show the time reached in the run [s]."""
        now = time.monotonic()
        if self._from is None:
            self._from, self._began = simulated, now
        if not self._shown or now - self._last < SECONDS_BETWEEN or simulated <= self._from:
            return
        self._last = now
        left = (now - self._began) * (self._duration - simulated) / (simulated - self._from)
        share = 100.0 * simulated / self._duration
        words = f"{simulated:.4g} s of {self._duration:.4g} s ({share:.0f} %)"
        self._line.write(f"{words}, {rounded_time(left)} left")

    def end(self) -> None:
        """Clear the line."""
        self._line.clear()


def rounded_time(seconds: float) -> str:
    """A time [s] in seconds, minutes or hours."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = seconds / 60.0
    return f"{minutes:.0f} min" if minutes < 90.0 else f"{minutes / 60.0:.1f} h"


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


# What comes out of a kind of run: a frozen dataclass with `path` and `stopped`.
Kept = TypeVar("Kept", bound=Any)


def keep_run(
    case: PreparedRun,
    result_of: Callable[[Records, Outcome], Kept],
    content_of: Callable[[Kept], Content],
    *,
    output: str | Path | None,
    force: bool,
    resume: bool,
    progress: bool | None,
) -> tuple[Kept, Outcome]:
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
    result_of: Callable[[Records, Outcome], Kept],
    content_of: Callable[[Kept], Content],
    path: Path,
    *,
    force: bool,
    progress: bool | None,
) -> tuple[Kept, Outcome]:
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


MOST_LOADED = 1_000_000_000  # bytes


def result_of(case: Case, records: Records, outcome: Outcome) -> SimulationResult:
    """Result of a run, as far as it went."""
    rows, fields = records.arrays()
    rows = loaded(rows[: outcome.records])
    every = case.recording.fields or 1
    time: Array = np.arange(len(rows), dtype=np.float64) * case.grid.interval
    fields = fields[: -(-len(rows) // every)]
    return SimulationResult(
        time=time,
        rows=rows,
        probes=(
            *((span, 0.5 * float(case.mesh.position[0, -1])) for span in case.mesh.spans),
            *case.recording.probes,
        ),
        field_time=np.array(time[::every][: len(fields)]),
        fields=loaded(fields),
        spans=case.mesh.spans,
        position=case.mesh.position,
        steps=int(outcome.state.counts[0]),
        step=case.grid.step,
        cfl=case.grid.cfl,
        energy_handled=energy_handled(rows, rest_energy(case.drive, case.mesh, case.law)),
        slack_events=slack_events(case, outcome.state),
        extremes=_extremes(case, outcome),
        provenance=_provenance(case),
        stopped=outcome.stopped,
        wall_time=outcome.wall_time,
    )


def loaded(array: Array) -> Array:
    """Moderate records in memory; larger ones stay in their file, which lives as long as it is mapped."""
    return np.array(array) if array.nbytes <= MOST_LOADED else array


def _extremes(case: Case, outcome: Outcome) -> dict[str, float]:
    found = {}
    for k, shaft in enumerate(("drive", "load", "motor")):
        for side, word in enumerate(("min", "max")):
            place = float(outcome.state.extremes[2 * k + side])
            found[f"{shaft}_angle_{word}"] = (
                place / float(case.plan.shaft[RADIUS, k]) if np.isfinite(place) else 0.0
            )
    for number, span in enumerate(case.mesh.spans):
        found[f"{span}_v_peak"] = float(outcome.state.extremes[6 + 2 * number])
        found[f"{span}_w_peak"] = float(outcome.state.extremes[7 + 2 * number])
    return found


def _provenance(case: Case) -> dict[str, Any]:
    scheme = case.scheme
    return {
        "cabledrive": case.fingerprint["cabledrive"],
        "drive": case.drive.name,
        "drive_hash": case.fingerprint["drive_hash"],
        "method": {
            "name": scheme.method,
            "model": case.law_name,
            "compiled": case.interpreted is None,
            "interpreted": case.interpreted,
            "segments": case.mesh.segments,
            "step": case.grid.step,
            "largest_step": case.grid.largest_step,
            "cfl": case.grid.cfl,
            "friction": scheme.friction,
            "smoothing_speed": scheme.smoothing_speed if scheme.friction == "smoothed" else None,
            "slack": scheme.slack,
        },
        "duration": case.grid.steps * case.grid.step,
        "torque": case.torque.fingerprint,
        "torque_offset": case.offset,
    }


Result = TypeVar("Result", bound="SimulationResult | NetworkResult")


def whole(result: Result) -> Result:
    """A result of a run that came to its end; `NotComputed` with the reason of one that did not."""
    if result.stopped is not None:
        raise NotComputed(result.stopped)
    return result


class SimulationInterrupted(KeyboardInterrupt):
    """The run was interrupted from outside; its line says how to go on.

    Attributes
    ----------
    result : SimulationResult or NetworkResult
        Everything up to there.
    """

    def __init__(self, message: str, result: "SimulationResult | NetworkResult") -> None:
        super().__init__(message)
        self.result = result
