"""The public door: one run of the nonlinear cable loop."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.own_model import Model
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.files import check_writable
from cabledrive.parameters.one_process import one_process
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.simulation.audit import energy_handled, rest_energy, slack_events
from cabledrive.simulation.case import CarriageForce, Case, Recording, case_of
from cabledrive.simulation.error_estimate import error_estimate_of
from cabledrive.simulation.netcdf import write_netcdf
from cabledrive.simulation.plan import RADIUS
from cabledrive.simulation.records import Records, RecordsInFolder, RecordsInMemory
from cabledrive.simulation.result import SimulationResult
from cabledrive.simulation.run import Outcome, integrate_run
from cabledrive.simulation.run_folder import RESULT, left_behind, part_of
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Function, Signal
from cabledrive.simulation.start import Start
from cabledrive.simulation.stopped import SimulationInterrupted, SimulationStopped

MOST_LOADED = 1_000_000_000  # bytes


def simulate(
    drive: Drive,
    duration: float,
    *,
    torque: Signal | float | Function = 0.0,
    forces: Sequence[CarriageForce] = (),
    start: Start | None = None,
    scheme: Scheme | None = None,
    recording: Recording | None = None,
    model: Model | None = None,
    error_estimate: bool = False,
    output: str | Path | None = None,
    force: bool = False,
    resume: bool = False,
    progress: bool | None = False,
) -> SimulationResult:
    """Nonlinear motion of cable and pulleys in time.

    Parameters
    ----------
    drive : Drive
    duration : float
        Length of the run [s].
    torque : Signal, float or callable, default 0.0
        Torque of the motor, of the drive pulley where there is none [N m]: a number, a function of time, or
        one of the signals of `cabledrive.simulation.signals`.
    forces : sequence of CarriageForce, optional
        Forces on carriages.
    start : Start, optional
        Plucks, angles and speeds at t = 0; by default the straight cable at rest.
    scheme : Scheme, optional
        Cable law, method, resolution, friction, what slack means.
    recording : Recording, optional
        What is kept, and how often.
    model : str or subclass of CableLaw, optional
        Cable law, in place of that of `scheme`, see `Scheme`.
    error_estimate : bool, default False
        Whether to estimate the discretisation error from a second run with half as many segments.
    output : path-like, optional
        NetCDF file to write. While the run lasts its records lie beside it, in a folder of that name with
        ".part" behind it.
    force : bool, default False
        Whether an existing file, or what is left of an interrupted run, may be replaced.
    resume : bool, default False
        Go on with an interrupted run of the same settings.
    progress : bool or None, default False
        Whether to show on standard error how far the run is; None: where that is a terminal.

    Returns
    -------
    SimulationResult

    Raises
    ------
    InputRefused
        If anything about the run is not possible; nothing was written.
    SimulationStopped
        If the run could not go on: slack, a number that is not finite, a full disk. It carries the result so
        far.
    SimulationInterrupted
        On Ctrl-C. It carries the result so far.
    """
    require_two_pulleys(drive, "`simulate`")
    scheme = scheme or Scheme()
    if model is not None:
        scheme = replace(scheme, model=model)
    prepare = partial(
        case_of, drive, duration, torque=torque, forces=forces, start=start, recording=recording
    )
    case = prepare(scheme=scheme)
    if output is None:
        if resume:
            raise InputRefused("resume needs the output of the interrupted run: name it")
        records: Records = RecordsInMemory(case)
        outcome = integrate_run(case, records, progress=progress)
        result = _result(case, records, outcome)
    else:
        result, outcome = _run_to_file(case, Path(output), force=force, resume=resume, progress=progress)
    if error_estimate and result.stopped is None:
        try:
            estimate = error_estimate_of(result.rows, lambda other: prepare(scheme=other), scheme)
        except KeyboardInterrupt:
            if output is None:
                raise
            raise KeyboardInterrupt(f"{output} is written, its error was not estimated") from None
        result = replace(result, error_estimate=estimate)
    if outcome.interrupted:
        raise SimulationInterrupted(_how_to_go_on(result, output), result)
    if result.stopped is not None:
        raise SimulationStopped(result.stopped, result)
    return result


def _run_to_file(
    case: Case, path: Path, *, force: bool, resume: bool, progress: bool | None
) -> tuple[SimulationResult, Outcome]:
    check_writable(path, force=force)
    folder = part_of(path)
    if left_behind(folder) and not (resume or force):
        raise InputRefused(
            f"{folder}: left by an interrupted run: go on with it (resume) or replace it (force)"
        )
    with one_process(folder):
        check_writable(path, force=force)  # by now another process may have ended with this file
        try:
            return _run_in(folder, case, path, force=force, resume=resume, progress=progress)
        except KeyboardInterrupt:  # before the first step, or at the end
            if not left_behind(folder):
                raise
            raise KeyboardInterrupt("go on with the same command and --resume") from None
        except OSError as error:
            why = f"cannot be written ({error.strerror or error})"
            raise NotComputed(f"{folder}: {why}: free space and go on with --resume") from error


def _run_in(
    folder: Path, case: Case, path: Path, *, force: bool, resume: bool, progress: bool | None
) -> tuple[SimulationResult, Outcome]:
    records = RecordsInFolder(folder, case, resume=resume)
    try:
        outcome = integrate_run(case, records, resumed=records.resumed, progress=progress)
        if outcome.interrupted or outcome.unwritten:
            return _result(case, records, outcome), outcome
        records.check(outcome.records)
        result = _result(case, records, outcome)
        try:
            write_netcdf(result, path, folder / RESULT, force=force)
        except OSError as error:
            stopped = f"{path}: cannot be written ({error.strerror or error}): free space and resume"
            return replace(result, stopped=stopped), outcome
        try:
            records.remove()
        except KeyboardInterrupt:
            records.remove()
            raise KeyboardInterrupt(f"{path} was written before") from None
        return replace(result, path=path), outcome
    finally:
        records.close()


def _how_to_go_on(result: SimulationResult, output: str | Path | None) -> str:
    reached = f"{result.steps * result.step:.6g} s were simulated"
    if output is None:
        return f"{reached}; with an output file the run could be resumed"
    return f"{reached}; go on with the same command and --resume"


def _result(case: Case, records: Records, outcome: Outcome) -> SimulationResult:
    """Result of a run, as far as it went."""
    rows, fields = records.arrays()
    rows = _loaded(rows[: outcome.records])
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
        fields=_loaded(fields),
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


def _loaded(array: Array) -> Array:
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
