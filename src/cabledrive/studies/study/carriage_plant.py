"""A guided carriage, with or without a mass below it, under its scheduled law."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive
from cabledrive.rig.carriage.carriage_loop import FORCE, TENSIONS
from cabledrive.rig.carriage.transporter_kernels import CarriageLoop
from cabledrive.studies.study.carriage_case import (
    CarriageCase,
    case_of,
    errors,
    loop_at,
    torque_of,
    whole_run,
)
from cabledrive.studies.study.carriage_controller import design_carriage_law
from cabledrive.studies.study.carriage_demand import carriage_demand, carriage_model, left_out_of
from cabledrive.studies.study.carriage_machine import know_carriage
from cabledrive.studies.study.demand_stage import DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.law_settings import LawSetting
from cabledrive.studies.study.log_files import Logs
from cabledrive.studies.study.modes_stage import ModesResult
from cabledrive.studies.study.plant import EXCEEDED, Array, Candidates, ClosedLoop, RunHistory, Score
from cabledrive.studies.study.stage_cache import Made, StageCache

NO_MODELS = "a carriage divides the span; see the model of the carriage below"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriagePlant:
    """A drive whose one carriage the scheduled law covers; logs do not identify it.

    Attributes
    ----------
    drive : Drive
    goals : Goals
    cache : StageCache
    known : Knowledge or None
        None: not yet.
    """

    drive: Drive
    goals: Goals
    cache: StageCache
    known: Knowledge | None = None

    kind = "carriage"
    no_models = no_cable = NO_MODELS

    @property
    def bare(self) -> Drive:
        """The drive without its words."""
        return replace(self.drive, name="", title="", source="")

    @property
    def task(self) -> Goals:
        """Goals without what only the acceptance, the logs or the verdict depend on."""
        plain = Goals()
        names = ("carriage_error", "draws", "cable_draws", "carriage_draws", "seed", "columns", "spreads")
        return replace(self.goals, **{name: getattr(plain, name) for name in names})

    def quantities(self, logs: Logs) -> Knowledge:
        """Data sheet, goals and estimates."""
        logged, spreads = bool(logs.arguments[0]), self.goals.spreads
        return self.cache.staged("knowledge", know_carriage, self.bare, self.task, spreads, logged=logged)

    def knowing(self, known: Knowledge) -> "CarriagePlant":
        """The same machine: no log has moved its values."""
        return replace(self, drive=released(self.drive), known=known)

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""
        return self.cache.staged("demand", carriage_demand, self.bare, self.task)

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """The model of the carriage and the scheduled law at its bandwidth."""
        note, staged = self.cache.note, self.cache.staged
        assert self.known is not None
        note("[5/8] model of the carriage")
        model = staged("model", carriage_model, self.bare, self.task)
        if model.reason or not possible:
            return Candidates(model=model, reason=model.reason or EXCEEDED)
        note("[6/8] controller: bandwidth of the scheduled law")
        law = staged(
            "controller", design_carriage_law, self.bare, self.task, self.known.quantities, model.left_out
        )
        setting = LawSetting(controller=law.name, model=None, value=law.bandwidth, filter="")
        laws = () if law.bandwidth is None else (setting,)
        return Candidates(model=model, controller=law, laws=laws, reason="" if laws else law.reason)

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made[ClosedLoop]:
        """The scheduled law; there is no plant on the distributed cable."""
        assert not cable
        return Made(carriage_loop, (self.bare, self.task, law.value))


def carriage_loop(drive: Drive, goals: Goals, bandwidth: float) -> "CarriageRuns":
    """The scheduled law at a bandwidth [Hz]; what the model leaves out is added to every error."""
    case = case_of(drive, goals)
    return CarriageRuns(case, loop_at(case, bandwidth), left_out_of(case))


@dataclass(frozen=True, slots=True, eq=False)
class CarriageRuns:
    """The scheduled law on plants with a carriage; ``left_out`` [m] is added to every error."""

    case: CarriageCase
    loop: CarriageLoop
    left_out: float

    encoders = 2

    def run(self, values: Mapping[str, float], phases: Array) -> Score:
        """Errors of the carriage and of the mass below it, whichever is larger."""
        case = self.case
        log = whole_run(case, self.loop, values, phases)
        off, standing = np.abs(errors(case, log)).max(axis=0), case.standing[: len(log)]
        torque, saturated = torque_of(case, log)
        tension = float(log[:, TENSIONS : TENSIONS + 3].min())
        rest = float(off[standing].max()) if standing.any() else 0.0
        lasted = len(log) == len(case.reference)
        return Score(
            peak=float(off.max()) + self.left_out if lasted else None,
            rest=rest + self.left_out if lasted else None,
            torque=torque,
            tension=tension,
            saturated=saturated,
        )

    def history(self, values: Mapping[str, float], phases: Array) -> RunHistory:
        """Motion and error of the carriage, or of the mass below it where that errs more."""
        case = self.case
        log = whole_run(case, self.loop, values, phases)
        both = errors(case, log)
        return RunHistory(
            time=np.asarray(case.interval * np.arange(len(log)), dtype=np.float64),
            reference=case.wanted[: len(log)],
            error=both[int(np.argmax(np.abs(both).max(axis=1)))],
            torque=log[:, FORCE] * case.design.radius,
        )
