"""Everything that a study found."""

from dataclasses import dataclass

from cabledrive.parameters import Drive
from cabledrive.studies.study.acceptance_stage import AcceptanceResult
from cabledrive.studies.study.candidates import LawScore
from cabledrive.studies.study.carriage_pipeline import CarriageStages
from cabledrive.studies.study.check_stage import CheckResult
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.demand_stage import DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.modes_stage import ModelResult, ModesResult
from cabledrive.studies.study.resonance_stage import ResonanceResult
from cabledrive.studies.study.tried_laws import TriedLaws
from cabledrive.studies.study.verdict_stage import Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyResult:
    """Everything that a study found.

    Attributes
    ----------
    drive : Drive
        As its file says.
    known : Drive
        With the best values, after identification.
    goals : Goals
    check : CheckResult
    knowledge : Knowledge
    modes : ModesResult
    resonance : ResonanceResult
    demand : DemandResult
    model : ModelResult or None
    controller : ControllerResult or None
        The damped law of the chain, by its bound.
    laws : TriedLaws or None
        Every law under one acceptance test.
    lumped, cable : AcceptanceResult
        Of the law that is chosen.
    verdict : Verdict
    key : str
        Hash of all inputs.
    carriage : CarriageStages or None
        Model, controller and acceptance of a drive whose one carriage the scheduled law covers.
    """

    drive: Drive
    known: Drive
    goals: Goals
    check: CheckResult
    knowledge: Knowledge
    modes: ModesResult
    resonance: ResonanceResult
    demand: DemandResult
    model: ModelResult | None
    controller: ControllerResult | None
    laws: TriedLaws | None
    lumped: AcceptanceResult
    cable: AcceptanceResult
    verdict: Verdict
    key: str
    carriage: CarriageStages | None = None

    @property
    def scores(self) -> tuple[LawScore, ...]:
        """Every law that was tried, simplest first."""
        if self.carriage is not None:
            found = self.carriage.score(self.goals)
            return () if found is None else (found,)
        return () if self.laws is None else self.laws.scores
