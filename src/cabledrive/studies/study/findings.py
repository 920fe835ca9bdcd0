"""Everything that a verdict is made of."""

from dataclasses import dataclass

from cabledrive.parameters import Drive
from cabledrive.studies.study.acceptance_stage import AcceptanceResult
from cabledrive.studies.study.carriage_pipeline import CarriageStages
from cabledrive.studies.study.check_stage import CheckResult
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.demand_stage import DemandResult
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.resonance_stage import ResonanceResult


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
    lumped, cable : AcceptanceResult
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
    lumped: AcceptanceResult
    cable: AcceptanceResult
    carriage: CarriageStages | None = None
    drive: Drive | None = None
