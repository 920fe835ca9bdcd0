"""Stages 2 and 5 to 7 of a drive whose one carriage the scheduled law covers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cabledrive.parameters import Drive
from cabledrive.studies.study.candidates import LawScore, score
from cabledrive.studies.study.carriage_acceptance import CarriageAcceptance, accept_carriage
from cabledrive.studies.study.carriage_controller import CarriageController, design_carriage_law
from cabledrive.studies.study.carriage_demand import CarriageModel, carriage_demand, carriage_model
from cabledrive.studies.study.carriage_machine import carriage_quantities
from cabledrive.studies.study.demand_stage import DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge, with_load
from cabledrive.studies.study.stage_cache import StageCache

NO_MODELS = "a carriage divides the span; see the model of the carriage below"
UNUSED = "the regression models have no carriage: the logs were not used, all values are from the data sheet"


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageStages:
    """What the study of a carriage found.

    Attributes
    ----------
    model : CarriageModel
    controller : CarriageController or None
        None: the model is not right, or the motion asks for more than there is.
    acceptance : CarriageAcceptance or None
        None: there is no controller.
    """

    model: CarriageModel
    controller: CarriageController | None
    acceptance: CarriageAcceptance | None

    def score(self, goals: Goals) -> LawScore | None:
        """The one law of a carriage, as every law is scored; None: it was not run."""
        law, runs = self.controller, self.acceptance
        if law is None or runs is None:
            return None
        setting = f"{law.bandwidth:g} Hz"
        return score(law.name, setting, "carriage", runs.peaks, runs.draws, goals.carriage_error)


def know_carriage(drive: Drive, goals: Goals, logs: Sequence[str]) -> Knowledge:
    """What is known of a drive with a carriage: the data sheet, the goals and estimates.

    ``logs``: hashes of the logs that were given.
    """
    found = Knowledge(
        quantities=carriage_quantities(drive, goals),
        undetermined=(UNUSED,) if logs else (),
        open_names=(),
        findings=(),
        residual=None,
        method="no log: data-sheet values with stated uncertainty",
    )
    return found if goals.load_inertia is None else with_load(found, goals.load_inertia)


def demand_of_carriage(cache: StageCache, drive: Drive, goals: Goals) -> DemandResult:
    """What the motion asks of motor and cable, from the cache where it was done before."""
    inputs = {"drive": drive, "goals": motion_goals(goals)}
    return cache.staged("demand", DemandResult, inputs, lambda: carriage_demand(drive, goals))


def motion_goals(goals: Goals) -> Goals:
    """Goals without what only the acceptance, the logs or the verdict depend on."""
    plain = Goals()
    names = ("carriage_error", "draws", "cable_draws", "carriage_draws", "seed", "columns", "spreads")
    return replace(goals, **{name: getattr(plain, name) for name in names})


def carriage_stages(
    cache: StageCache, drive: Drive, goals: Goals, known: Knowledge, *, possible: bool, stages: int
) -> CarriageStages:
    """Model, controller and acceptance of a carriage.

    ``possible``: whether motor and cable have what the motion asks for; ``stages``: how many the study has,
    for the notes.
    """
    cache.note(f"[5/{stages}] model of the carriage")
    bare = replace(drive, name="", title="", source="")
    inputs = {"drive": bare, "goals": motion_goals(goals)}
    model = cache.staged("model", CarriageModel, inputs, lambda: carriage_model(drive, goals))
    if model.reason or not possible:
        return CarriageStages(model=model, controller=None, acceptance=None)
    cache.note(f"[6/{stages}] controller: bandwidth of the scheduled law")
    inputs |= {"known": known.quantities, "left_out": model.left_out}
    controller = cache.staged(
        "controller",
        CarriageController,
        inputs,
        lambda: design_carriage_law(drive, goals, known.quantities, model.left_out),
    )
    if controller.bandwidth is None:
        return CarriageStages(model=model, controller=controller, acceptance=None)
    cache.note(f"[7/{stages}] acceptance: {controller.name} at {controller.bandwidth:g} Hz")
    bandwidth = controller.bandwidth
    inputs |= {"bandwidth": bandwidth, "seed": goals.seed}
    acceptance = cache.staged(
        "acceptance-carriage",
        CarriageAcceptance,
        {**inputs, "draws": goals.carriage_draws, "error": goals.carriage_error},
        lambda: accept_carriage(
            drive, goals, known.quantities, bandwidth, model.left_out, cache=cache, inputs=inputs
        ),
    )
    return CarriageStages(model=model, controller=controller, acceptance=acceptance)
