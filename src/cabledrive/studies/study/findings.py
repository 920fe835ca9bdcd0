"""Everything that a verdict is made of."""

from dataclasses import dataclass

from cabledrive.parameters import Drive
from cabledrive.studies.study.acceptance_stage import AcceptanceResult
from cabledrive.studies.study.candidates import LawScore
from cabledrive.studies.study.carriage_controller import CarriageController
from cabledrive.studies.study.carriage_demand import CarriageModel
from cabledrive.studies.study.check_stage import CheckResult
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.demand_stage import DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.modes_stage import ModelResult
from cabledrive.studies.study.resonance_stage import ResonanceResult
from cabledrive.studies.study.tried_laws import TriedLaws


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """What the stages before the verdict found.

    Attributes
    ----------
    goals : Goals
    known : Drive or None
        With the best values, after identification.
    check : CheckResult
    knowledge : Knowledge
    demand : DemandResult
    resonance : ResonanceResult
    model : ModelResult, CarriageModel or None
    controller : ControllerResult, CarriageController or None
        The damped law of the chain, by its bound; the scheduled law of a carriage, by its estimated error.
    laws : TriedLaws or None
        Every law under one acceptance test.
    runs : AcceptanceResult
        Of the law that is chosen, on the plants that decide first.
    cable : AcceptanceResult
        Of the same law on the distributed cable.
    """

    goals: Goals
    known: Drive | None = None
    check: CheckResult
    knowledge: Knowledge
    demand: DemandResult
    resonance: ResonanceResult
    model: ModelResult | CarriageModel | None = None
    controller: ControllerResult | CarriageController | None
    laws: TriedLaws | None
    runs: AcceptanceResult
    cable: AcceptanceResult

    @property
    def carried(self) -> bool:
        """Whether a carriage is controlled, and not a load."""
        return self.runs.plant == "carriage"

    @property
    def scores(self) -> tuple[LawScore, ...]:
        """Every law that was tried, simplest first."""
        return () if self.laws is None else self.laws.scores

    @property
    def chosen(self) -> LawScore | None:
        """The law that is chosen, on the plants that decide first; None: no law was run."""
        if self.laws is None or self.laws.chosen is None:
            return None
        name = self.laws.chosen.controller
        return next(one for one in self.scores if one.controller == name)

    @property
    def cable_score(self) -> LawScore | None:
        """The chosen law on the distributed cable; None: it was not run there."""
        if self.laws is None or self.laws.chosen is None:
            return None
        name = self.laws.chosen.controller
        return next((one for one in self.laws.cable_scores if one.controller == name), None)
