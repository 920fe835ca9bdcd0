"""What a study found."""

from dataclasses import dataclass

from cabledrive.parameters import Drive
from cabledrive.studies.study.findings import Findings
from cabledrive.studies.study.modes_stage import ModesResult
from cabledrive.studies.study.verdict_stage import Verdict


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
