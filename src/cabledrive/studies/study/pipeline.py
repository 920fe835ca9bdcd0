"""A study from end to end: every stage by its inputs, from the cache where it was done before."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from cabledrive.identification.logs.column_map import ColumnMap
from cabledrive.identification.logs.log import Log
from cabledrive.identification.logs.reading import read_log
from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route.drive import require_two_pulleys
from cabledrive.studies.study.acceptance_stage import no_runs
from cabledrive.studies.study.assumed_motion import goals_for
from cabledrive.studies.study.carriage_pipeline import (
    NO_MODELS,
    carriage_stages,
    demand_of_carriage,
    know_carriage,
)
from cabledrive.studies.study.check_stage import CheckResult, check, missing_for_control
from cabledrive.studies.study.controller_stage import ControllerResult, design_controller
from cabledrive.studies.study.demand_stage import DemandResult, demand_of
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.goals import Goals, motion_of
from cabledrive.studies.study.knowledge_stage import Knowledge, know, known_drive, usable_log
from cabledrive.studies.study.law_settings import LawSettings, tuned_laws
from cabledrive.studies.study.machine import mechanical
from cabledrive.studies.study.modes_stage import ModelResult, ModesResult, choose_reduced_model, find_modes
from cabledrive.studies.study.resonance_stage import ResonanceResult, resonance_of
from cabledrive.studies.study.result import StudyResult
from cabledrive.studies.study.stage_cache import StageCache, file_hash, key_of
from cabledrive.studies.study.tried_laws import Trial, TriedLaws, try_laws
from cabledrive.studies.study.verdict_stage import judge

STAGES = 8


def study_key(drive: Drive, hashes: Sequence[str], goals: Goals) -> str:
    """Hash of all inputs of a study.

    ``hashes``: of the log files.
    """
    inputs = {"drive": content_hash(drive), "name": drive.name, "title": drive.title, "logs": list(hashes)}
    return key_of("study", {**inputs, "goals": _plain(goals)})


def run_study(
    drive: Drive,
    logs: Sequence[Path] = (),
    goals: Goals | None = None,
    *,
    folder: Path | None = None,
    note: Callable[[str], None] | None = None,
) -> StudyResult:
    """Study a drive: from data sheet and logs to a controller with a verdict.

    Parameters
    ----------
    drive : Drive
    logs : sequence of Path
        Measured logs.
    goals : Goals, optional
    folder : Path, optional
        Where finished stages are kept; nothing is kept without one.
    note : callable, optional
        Called with a line that says what is being done.

    Returns
    -------
    StudyResult
    """
    require_two_pulleys(drive, "`run_study`")
    goals, note = goals_for(drive, goals or Goals()), note or (lambda line: None)
    hashes = [file_hash(path) for path in logs]
    cache = StageCache(folder=folder, note=note)
    reader = _Reader(tuple(logs), goals.columns, [])
    run = _Run(drive, goals, hashes, cache, reader)
    note(f"[1/{STAGES}] check of drive and data")
    checked = run.stage("check", CheckResult, run.about_logs, lambda: check(drive, reader.read(), hashes))
    note(f"[2/{STAGES}] identification from the logs")
    known = run.stage("knowledge", Knowledge, run.about_knowledge, run.identify)
    machine = released(drive if checked.missing or drive.carriage else known_drive(drive, known))
    return _judged(run, checked, known, machine)


@dataclass(frozen=True, slots=True, eq=False)
class _Reader:
    """Logs, read when first needed."""

    paths: tuple[Path, ...]
    columns: ColumnMap
    kept: list[Log]

    def read(self) -> list[Log]:
        if self.paths and not self.kept:
            self.kept.extend(usable_log(read_log(path, self.columns)) for path in self.paths)
        return self.kept


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """What every stage is given."""

    drive: Drive
    goals: Goals
    hashes: list[str]
    cache: StageCache
    reader: _Reader

    def stage(self, name: str, kind: Any, inputs: Mapping[str, Any], compute: Callable[[], Any]) -> Any:
        return self.cache.staged(name, kind, inputs, compute)

    @property
    def about_logs(self) -> dict[str, Any]:
        return {"drive": self.drive, "logs": self.hashes, "columns": _plain(self.goals)["columns"]}

    @property
    def about_knowledge(self) -> dict[str, Any]:
        mechanics = mechanical(self.drive)
        spreads, load = dict(self.goals.spreads), self.goals.load_inertia
        about: dict[str, Any] = {"drive": mechanics, "logs": self.hashes, "carriage": self.carriage_numbers}
        sensors = self.drive.sensors
        about["backlash"] = self.goals.backlash
        about["timing"] = None if sensors is None else [sensors.delay, sensors.sample_rate]
        return about | {"spreads": spreads, "load": load, "columns": _plain(self.goals)["columns"]}

    @property
    def carriage_numbers(self) -> list[float | None]:
        goals = self.goals
        return [goals.hanging_mass, goals.line_length, goals.rail_friction]

    def identify(self) -> Knowledge:
        if self.drive.carriage and not missing_for_control(self.drive):
            return know_carriage(self.drive, self.goals, self.hashes)
        goals = self.goals
        return know(
            self.drive, self.reader.read(), goals.spreads, goals.load_inertia, backlash=goals.backlash
        )


def _judged(run: _Run, checked: CheckResult, known: Knowledge, machine: Drive) -> StudyResult:
    """Stages 3 to 8."""
    goals, note, motion = run.goals, run.cache.note, run.goals.motion
    bare, course = mechanical(machine), motion_of(goals)
    note(f"[3/{STAGES}] certified modes, reduced models")
    why, carried = "; ".join(checked.missing), bool(machine.carriage) and not checked.missing
    alone = NO_MODELS if carried else why
    modes = run.stage("modes", ModesResult, {"drive": bare, "why": alone}, lambda: find_modes(machine, alone))
    note(f"[4/{STAGES}] internal resonance under the planned motion")
    resonance = run.stage(
        "resonance", ResonanceResult, {"drive": bare, "motion": course}, lambda: resonance_of(machine, motion)
    )
    if carried:
        demand = demand_of_carriage(run.cache, machine, goals)
    else:
        limited = {"drive": machine, "motion": course, "torque": goals.torque}
        demand = run.stage("demand", DemandResult, limited, lambda: demand_of(machine, motion, goals.torque))
    model = controller = carriage = laws = None
    if carried:
        possible = not demand.exceeded
        carriage = carriage_stages(run.cache, machine, goals, known, possible=possible, stages=STAGES)
    asked = "the motion exceeds the limits of the drive"
    not_run = alone if checked.missing or carried else asked
    lumped, cable = no_runs("lumped", not_run), no_runs("cable", not_run)
    if not (checked.missing or carried or demand.exceeded):
        model, controller, laws = _controlled(run, known, machine, modes)
        lumped, cable = laws.lumped, laws.cable
    note(f"[8/{STAGES}] verdict")
    findings = Findings(
        goals=goals,
        check=checked,
        knowledge=known,
        demand=demand,
        resonance=resonance,
        controller=controller,
        laws=laws,
        lumped=lumped,
        cable=cable,
        carriage=carriage,
        drive=machine,
    )
    return StudyResult(
        drive=run.drive,
        known=machine,
        goals=goals,
        check=checked,
        knowledge=known,
        modes=modes,
        resonance=resonance,
        demand=demand,
        model=model,
        controller=controller,
        laws=laws,
        lumped=lumped,
        cable=cable,
        carriage=carriage,
        verdict=judge(findings),
        key=study_key(run.drive, run.hashes, goals),
    )


def _controlled(
    run: _Run, known: Knowledge, machine: Drive, modes: ModesResult
) -> tuple[ModelResult, ControllerResult, TriedLaws]:
    """Stages 5 to 7."""
    goals, note, motion, course = run.goals, run.cache.note, run.goals.motion, motion_of(run.goals)
    note(f"[5/{STAGES}] choice of the reduced model")
    inputs = {"drive": replace(machine, name="", title="", source=""), "motion": course, "error": goals.error}
    model: ModelResult = run.stage(
        "model", ModelResult, inputs, lambda: choose_reduced_model(machine, motion, goals.error, modes.models)
    )
    note(f"[6/{STAGES}] controllers: settings of each law")
    models = models_for_the_law(model.chosen, modes)
    del inputs["error"]
    inputs |= {"models": models, "known": known.quantities, "torque": goals.torque}
    controller: ControllerResult = run.stage(
        "controller",
        ControllerResult,
        inputs,
        lambda: design_controller(machine, motion, known.quantities, models, goals.torque),
    )
    inputs["correlations"] = known.correlations
    laws: LawSettings = run.stage(
        "laws",
        LawSettings,
        {**inputs, "chain": [controller.name, controller.bandwidth]},
        lambda: tuned_laws(machine, motion, known, controller, goals.torque),
    )
    note(f"[7/{STAGES}] acceptance of {', '.join(one.controller for one in laws.settings)}")
    trial = Trial(
        drive=machine, goals=goals, known=known, chain_law=controller, cache=run.cache, inputs=inputs
    )
    return model, controller, try_laws(trial, laws.settings)


def models_for_the_law(chosen: int, modes: ModesResult) -> dict[int, float]:
    """The model that the motion calls for, then the others that bend the cable, and up to where they hold.

    ``chosen``, {1, 3, 4}.
    Returns [Hz].
    """
    holds = {one.model: one.holds_5 for one in modes.models}
    others = [number for number in (4, 3) if number in holds and number != chosen]
    return {number: holds[number] for number in (chosen, *others)}


def _plain(goals: Goals) -> dict[str, Any]:
    from cabledrive.studies.study.plain_data import as_plain

    data: dict[str, Any] = as_plain(goals)
    return data
