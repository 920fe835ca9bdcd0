"""A machine as a study sees it: one class for loads on pulleys, one for a guided carriage."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive
from cabledrive.studies.study.carriage_case import CarriageModel
from cabledrive.studies.study.carriage_controller import CarriageController
from cabledrive.studies.study.check_stage import DemandResult
from cabledrive.studies.study.controller_stage import ControllerResult, LawSetting
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.modes_stage import ModelResult, ModesResult
from cabledrive.studies.study.stage_cache import Logs, Made

Array = NDArray[np.float64]
EXCEEDED = "the motion exceeds the limits of the drive"


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """What one run left."""

    # peak, rest: largest error [rad] or [m], and the largest while a carriage is to stand [m]; None: the run
    # ended before its time, or nothing is to stand
    peak: float | None
    # torque, tension: largest torque [N m] and, of a carriage, smallest tension of a strand [N]
    torque: float | None
    saturated: float  # share of the samples at the torque's limit
    rest: float | None = None
    tension: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RunHistory:
    """One run over time, each of shape (samples,): [s], [rad] or [m], the same, [N m]."""

    time: Array
    reference: Array
    error: Array
    torque: Array


class ClosedLoop(Protocol):
    """A law that can be run on one plant after another."""

    @property
    def encoders(self) -> int:
        """Encoders whose phases are drawn."""

    def run(self, values: Mapping[str, float], phases: Array) -> Score:
        """What a plant with these quantities leaves, its encoders at these phases, shape (encoders,)."""

    def history(self, values: Mapping[str, float], phases: Array) -> RunHistory:
        """The same run over time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidates:
    """Model, controller and laws of a plant, as far as it has them."""

    model: ModelResult | CarriageModel | None = None
    controller: ControllerResult | CarriageController | None = None
    laws: tuple[LawSetting, ...] = ()  # simplest first
    bound: float | None = None  # stated for the law of the chain [rad]
    reason: str = ""  # why there is no law; empty where there is one


class Plant(Protocol):
    """What a study asks of a machine, in the order in which it asks."""

    @property
    def kind(self) -> str:
        """Of the plants that decide: "lumped" or "carriage"."""

    @property
    def drive(self) -> Drive:
        """With the best values, once they are known."""

    @property
    def no_models(self) -> str:
        """Why the reduced models do not apply; empty where they do."""

    @property
    def no_cable(self) -> str:
        """Why there are no plants on the distributed cable; empty where there are."""

    def quantities(self, logs: Logs) -> Knowledge:
        """What is known of the machine."""

    def knowing(self, known: Knowledge) -> "Plant":
        """The machine with the best value of every quantity."""

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """Model, controller and laws; ``possible``: whether the drive has what the motion asks for."""

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made[ClosedLoop]:
        """A law ready to run; ``cable``: on the distributed nonlinear cable."""
