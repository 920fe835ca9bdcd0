"""Everything that a verdict is made of."""

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
from cabledrive.studies.study.resonance_stage import ResonanceResult
from cabledrive.studies.study.tried_laws import TriedLaws


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """What the verdict is made of.

    Attributes
    ----------
    goals : Goals
    check : CheckResult
    knowledge : Knowledge
    demand : DemandResult
    resonance : ResonanceResult
    controller : ControllerResult or None
        The damped law of the chain, by its bound.
    laws : TriedLaws or None
        Every law under one acceptance test.
    lumped, cable : AcceptanceResult
        Of the law that is chosen.
    carriage : CarriageStages or None
        Of a drive whose one carriage the scheduled law covers.
    drive : Drive or None
        With the best values.
    """

    goals: Goals
    check: CheckResult
    knowledge: Knowledge
    demand: DemandResult
    resonance: ResonanceResult
    controller: ControllerResult | None
    laws: TriedLaws | None
    lumped: AcceptanceResult
    cable: AcceptanceResult
    carriage: CarriageStages | None = None
    drive: Drive | None = None

    @property
    def chosen(self) -> LawScore | None:
        """The law that is chosen, on the plants that decide first; None: no law was run."""
        if self.carriage is not None:
            return self.carriage.score(self.goals)
        if self.laws is None or self.laws.chosen is None:
            return None
        name = self.laws.chosen.controller
        return next(one for one in self.laws.scores if one.controller == name)

    @property
    def cable_score(self) -> LawScore | None:
        """The chosen law on the distributed cable; None: it was not run there."""
        if self.laws is None or self.laws.chosen is None:
            return None
        name = self.laws.chosen.controller
        return next((one for one in self.laws.cable_scores if one.controller == name), None)

    @property
    def median(self) -> float | None:
        """Error that half of the runs of the chosen law keep below [rad] or [m]."""
        if self.carriage is not None:
            return self.carriage.acceptance.quantile(0.5) if self.carriage.acceptance else None
        return self.lumped.quantile(0.5)
