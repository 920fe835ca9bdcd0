"""A study from end to end: one order of stages for every plant, and what is left without a chain."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cabledrive.mechanics.network.span_table import pulley_rows, route_warnings, span_rows
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.modal import modes
from cabledrive.parameters import Drive, InputRefused, NotComputed, content_hash
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.reduction.network_axis import as_axis
from cabledrive.rig.run_limits import check_record
from cabledrive.studies.route_pairs import route_resonance
from cabledrive.studies.study.acceptance_stage import Trial, TriedLaws, no_runs, try_laws
from cabledrive.studies.study.check_stage import CheckResult, check, goals_for
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import mechanical
from cabledrive.studies.study.modes_stage import ModesResult, find_modes, resonance_of
from cabledrive.studies.study.plants import CarriagePlant, LoadPlant, Plant
from cabledrive.studies.study.stage_cache import StageCache, key_of, log_files, logs_of
from cabledrive.studies.study.verdict_stage import Verdict, judge


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResult(Findings):
    """Everything that a study found, with its verdict.

    Attributes
    ----------
    drive, known : Drive
        As its file says, and with the best values, after identification.
    goals : Goals
    check : CheckResult
    knowledge : Knowledge
    modes : ModesResult
    resonance : ResonanceResult
    demand : DemandResult
    model : ModelResult, CarriageModel or None
    controller : ControllerResult, CarriageController or None
        The damped law of the chain, by its bound; the scheduled law of a carriage, by its estimated error.
    laws : TriedLaws or None
        Every law under one acceptance test.
    runs, cable : AcceptanceResult
        Of the law that is chosen, on the plants that decide first and on the distributed cable.
    verdict : Verdict
    key : str
        Hash of all inputs.
    """

    drive: Drive
    known: Drive
    modes: ModesResult
    verdict: Verdict
    key: str


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
    if drive.sensors is not None and drive.sensors.sample_rate is not None:
        duration = goals.motion.trajectory.duration
        check_record(duration, duration * drive.sensors.sample_rate)
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
    inputs = {"drive": content_hash(drive), "name": drive.name, "title": drive.title, "logs": hashes}
    verdict, key = judge(Findings(**stages)), key_of("study", {**inputs, "goals": goals})
    return StudyResult(drive=drive, modes=modes, verdict=verdict, key=key, **stages)


def plant_of(drive: Drive, goals: Goals, cache: StageCache, checked: CheckResult) -> Plant:
    """The plant that a drive is; one that no controller can be designed for is asked for its loads alone."""
    if drive.carriage and not checked.missing:
        return CarriagePlant(drive=drive, goals=goals, cache=cache)
    return LoadPlant(drive=drive, goals=goals, cache=cache, missing="; ".join(checked.missing))


COUNT = 6
METHOD = "certified modes, pairs near internal resonance, tensions at rest"
REMEDY = "name another axis (--axis), or give a machine whose load is the end of a chain"


def study_without_chain(drive: RoutedDrive, why: str, logs: int) -> dict[str, Any]:
    """Plain data of a study's results, SI; ``why``: no controller; ``logs``: how many were given."""
    found, statics = modes(drive, count=COUNT), statics_of(drive)
    spans, pulleys = span_rows(drive, statics), pulley_rows(drive, statics)
    resonance, reasons = _resonance(drive)
    cautions = [*route_warnings(drive), *found.warnings]
    if logs:
        cautions.append(f"{logs} logs were not used: without a chain there is nothing to identify")
    return {
        "verdict": "unknown",
        "headline": f"no controller: {why}",
        "candidates": [],
        "reasons": [f"no controller: {why}", *reasons],
        "findings": [
            {"id": "no-chain", "value": None, "value_reason": why, "limit": None, "unit": "", "decides": True}
        ],
        "remedies": [REMEDY],
        "cautions": cautions,
        "margins": {
            "lowest_tension": min(min(row["tension_start"], row["tension_end"]) for row in spans),
            "safety_factor": min(
                (row["safety_factor"] for row in spans if row["safety_factor"] is not None), default=None
            ),
            "spans": spans,
            "pulleys": pulleys,
        },
        "drive": drive.name,
        "drive_hash": content_hash(drive),
        "stages": {
            "modes": {
                "longitudinal_hz": [mode.frequency for mode in found.longitudinal],
                "transverse_hz": [mode.frequency for mode in found.transverse],
                "certified": found.certified,
                "certified_reason": found.certified_reason,
            },
            "resonance": resonance,
        },
        "provenance": {
            "cabledrive": __version__,
            "drive": drive.name,
            "drive_hash": content_hash(drive),
            "method": METHOD,
        },
    }


def _resonance(drive: RoutedDrive) -> tuple[dict[str, Any] | None, list[str]]:
    """The internal resonance, and what it says."""
    try:
        found = route_resonance(drive)
    except (InputRefused, NotComputed) as refusal:
        return None, [f"internal resonance not computed: {refusal}"]
    data = {
        "verdict": found.verdict,
        "threshold_torque": found.threshold_torque,
        "longitudinal_hz": found.longitudinal_hz,
        "frequency_ratio": found.frequency_ratio,
        "nearest_span": found.nearest_span,
    }
    return data, [f"internal resonance: {found.verdict}; {found.reasons[0]}"]
