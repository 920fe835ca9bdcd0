"""A study from end to end: one order of stages for every plant, and what it leaves besides its report."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cabledrive.answers.figures import Row
from cabledrive.answers.result import Result
from cabledrive.parameters import Drive, Machine, content_hash
from cabledrive.parameters.fields import described, meaning
from cabledrive.reduction.network_axis import as_axis
from cabledrive.studies.study import stage_cache
from cabledrive.studies.study.acceptance_stage import no_laws, run_as_exported, try_laws
from cabledrive.studies.study.check_stage import check, goals_for
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import mechanical
from cabledrive.studies.study.modes_stage import ModesResult, find_modes, resonance_of
from cabledrive.studies.study.plants import CarriagePlant, Plant
from cabledrive.studies.study.stage_cache import Made, StageCache
from cabledrive.studies.study.verdict_stage import Verdict, judge


@described
@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class StudyResult(Findings, Result):
    """Everything that a study found, with its verdict."""

    _table = "verdict.margins"
    _shown = (
        Row("drive.name", "drive"),
        Row("verdict.answer", "verdict"),
        Row("verdict.reasons", "reasons"),
        Row("verdict.remedies", "what would help"),
    )

    drive: Drive = meaning("as its file says")
    known: Drive = meaning("with the best values, after identification")
    modes: ModesResult = meaning("distributed and lumped")
    verdict: Verdict = meaning("yes, no or unknown, and why")
    key: str = meaning("hash of all inputs")


def run_study(
    drive: Machine | Drive,
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
    drive : Machine or Drive
        A machine whose axis is a chain, or the drive of that axis.
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
    if drive.sensors is not None and drive.sensors.sample_rate is not None:
        goals.motion.samples(1.0 / drive.sensors.sample_rate)  # refuses what would not fit into memory
    cache, files = StageCache(folder=folder, note=note), stage_cache.log_files(logs)
    records = Made(stage_cache.read_all, (files, goals.columns))  # where a stage needs them
    hashes = [file.sha256 for file in files]
    note("[1/8] check of drive and data")
    checked = cache.staged("check", check, drive, records, hashes)
    plant = Plant(drive=drive, goals=goals, cache=cache, no_models="; ".join(checked.missing))
    if drive.carriage and not checked.missing:
        plant = CarriagePlant(drive=drive, goals=goals, cache=cache)
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
    laws, exported = no_laws(plant.kind, found.reason, plant.no_models or found.reason), None
    if found.laws:
        note(f"[7/8] acceptance of {', '.join(one.controller for one in found.laws)}")
        laws = try_laws(plant, found.laws, found.bound)
    if laws.chosen is not None and not drive.carriage:
        exported = cache.staged("exported", run_as_exported, plant.case, laws.chosen, goals)
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
        "exported": exported,
    }
    inputs = {"drive": content_hash(drive), "name": drive.name, "title": drive.title, "logs": hashes}
    verdict, key = judge(Findings(**stages)), stage_cache.key_of("study", {**inputs, "goals": goals})
    return StudyResult(drive=drive, modes=modes, verdict=verdict, key=key, **stages)
