"""A study from end to end: one order of stages for every plant, each kept when it is done."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.reduction.network_axis import as_axis
from cabledrive.studies.study.acceptance_stage import no_runs
from cabledrive.studies.study.assumed_motion import goals_for
from cabledrive.studies.study.carriage_plant import CarriagePlant
from cabledrive.studies.study.check_stage import CheckResult, check
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.load_plant import LoadPlant
from cabledrive.studies.study.log_files import log_files, logs_of
from cabledrive.studies.study.machine import mechanical
from cabledrive.studies.study.modes_stage import find_modes
from cabledrive.studies.study.plant import Plant
from cabledrive.studies.study.resonance_stage import resonance_of
from cabledrive.studies.study.result import StudyResult
from cabledrive.studies.study.stage_cache import StageCache, key_of
from cabledrive.studies.study.tried_laws import Trial, TriedLaws, try_laws
from cabledrive.studies.study.verdict_stage import judge


def run_study(
    drive: Drive | RoutedDrive,
    logs: Sequence[Path] = (),
    goals: Goals | None = None,
    *,
    axis: str | None = None,
    folder: Path | None = None,
    note: Callable[[str], None] | None = None,
) -> StudyResult:
    """Study a drive: from data sheet and logs to a controller with a verdict.

    Parameters
    ----------
    drive : Drive or RoutedDrive
        Of a machine with routes the chain of its axis, where it is one.
    logs : sequence of Path
        Measured logs.
    goals : Goals, optional
    axis : str, optional
        Of a machine with routes: its load, such as "head.x".
    folder : Path, optional
        Where finished stages are kept; nothing is kept without one.
    note : callable, optional
        Called with a line that says what is being done.

    Returns
    -------
    StudyResult

    Raises
    ------
    InputRefused
        If goals or logs do not fit the drive, or the load of a machine with routes is not the end of a chain.
    """
    drive = as_axis(drive, axis)
    goals, note = goals_for(drive, goals or Goals()), note or (lambda line: None)
    cache, files = StageCache(folder=folder, note=note), log_files(logs)
    records, hashes = logs_of(files, goals.columns), [file.sha256 for file in files]
    note("[1/8] check of drive and data")
    checked = cache.staged("check", check, drive, records, hashes)
    plant = plant_of(drive, goals, cache, checked)
    note("[2/8] identification from the logs")
    known = plant.quantities(records)
    plant = plant.knowing(known)
    note("[3/8] certified modes, reduced models")
    bare = mechanical(plant.drive)
    modes = cache.staged("modes", find_modes, bare, plant.no_models)
    note("[4/8] internal resonance under the planned motion")
    resonance = cache.staged("resonance", resonance_of, bare, goals.motion)
    demand = plant.demand()
    found = plant.candidates(modes, possible=not demand.exceeded)
    laws: TriedLaws | None = None
    if found.laws:
        note(f"[7/8] acceptance of {', '.join(one.controller for one in found.laws)}")
        trial = Trial(plant=plant, goals=goals, known=known, bound=found.bound, cache=cache)
        laws = try_laws(trial, found.laws)
    note("[8/8] verdict")
    stages: dict[str, Any] = {
        "goals": goals,
        "known": plant.drive,
        "check": checked,
        "knowledge": known,
        "demand": demand,
        "resonance": resonance,
        "model": found.model,
        "controller": found.controller,
        "laws": laws,
        "runs": no_runs(plant.kind, found.reason) if laws is None else laws.runs,
        "cable": no_runs("cable", plant.no_models or found.reason) if laws is None else laws.cable,
    }
    verdict, key = judge(Findings(**stages)), study_key(drive, hashes, goals)
    return StudyResult(drive=drive, modes=modes, verdict=verdict, key=key, **stages)


def plant_of(drive: Drive, goals: Goals, cache: StageCache, checked: CheckResult) -> Plant:
    """The plant that a drive is; one that no controller can be designed for is asked for its loads alone."""
    if drive.carriage and not checked.missing:
        return CarriagePlant(drive=drive, goals=goals, cache=cache)
    return LoadPlant(drive=drive, goals=goals, cache=cache, missing="; ".join(checked.missing))


def study_key(drive: Drive, hashes: Sequence[str], goals: Goals) -> str:
    """Hash of all inputs of a study.

    ``hashes``: of the log files.
    """
    inputs = {"drive": content_hash(drive), "name": drive.name, "title": drive.title, "logs": list(hashes)}
    return key_of("study", {**inputs, "goals": goals})
