"""A load on the pulleys, and a guided carriage, as a study takes them through its stages."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.rig.carriage import FORCE, TENSIONS, CarriageLoop
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.setting import Motion
from cabledrive.rig.tuning import LawSetting
from cabledrive.studies.study.bandwidth_cost import CarriageController, design_carriage_law
from cabledrive.studies.study.carriage_case import (
    CarriageCase,
    CarriageModel,
    carriage_demand,
    carriage_model,
    case_of,
    errors,
    left_out_of,
    loop_at,
    torque_of,
    whole_run,
)
from cabledrive.studies.study.carriage_machine import know_carriage
from cabledrive.studies.study.check_stage import DemandResult, demand_of
from cabledrive.studies.study.controller_stage import (
    ControllerResult,
    design_controller,
    law_of,
    tuned_laws,
)
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge, know, known_drive
from cabledrive.studies.study.modes_stage import ModelResult, ModesResult, choose_reduced_model
from cabledrive.studies.study.sampled_plants import crept, joined_loop, with_values
from cabledrive.studies.study.stage_cache import Logs, Made, StageCache

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidates:
    """Model, controller and laws of a plant, as far as it has them."""

    model: ModelResult | CarriageModel | None = None
    controller: ControllerResult | CarriageController | None = None
    laws: tuple[LawSetting, ...] = ()  # simplest first
    bound: float | None = None  # stated for the law of the chain [rad]
    reason: str = ""  # why there is no law; empty where there is one


AXIS = "the lumped chain of an axis is run, its machine's spans are in the network of `simulate`"
LINE = "the cable plant is a loop round two pulleys, this drive is a line"
BACKLASH = "the distributed cable does not support motor.backlash"
SLIDES = "the distributed cable does not slide on its pulleys"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadPlant:
    """A drive whose load pulley follows the motion."""

    drive: Drive
    goals: Goals
    cache: StageCache
    known: Knowledge | None = None  # None: not yet
    missing: str = ""  # what the file lacks for a controller; empty where one can be designed

    kind = "lumped"

    @property
    def no_models(self) -> str:
        """Why the reduced models do not apply."""
        return self.missing

    @property
    def no_cable(self) -> str:
        """Why there are no plants on the distributed cable."""
        if isinstance(self.drive, AxisDrive):
            return AXIS
        if self.drive.kind != "loop":
            return LINE
        if self.known is not None and "slip_torque" in self.known.quantities:
            return SLIDES
        motor = self.drive.motor
        return BACKLASH if motor is not None and motor.backlash > 0.0 else ""

    def quantities(self, logs: Logs) -> Knowledge:
        """What is identified from the logs; the rest from the data sheet."""
        goals = self.goals
        return self.cache.staged(
            "knowledge", know, self.drive, logs, goals.spreads, goals.load_inertia, backlash=goals.backlash
        )

    def knowing(self, known: Knowledge) -> "LoadPlant":
        """The drive with the best values; as its file says where something is missing."""
        drive = self.drive if self.missing else known_drive(self.drive, known)
        return replace(self, drive=released(drive), known=known)

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""
        slides = None if self.known is None else self.known.quantities.get("slip_torque")
        limits = self.goals.torque, None if slides is None else slides.high
        return self.cache.staged("demand", demand_of, self.drive, self.goals.motion, limits)

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """The reduced model, the damped law of the chain by its bound, and every law at its best setting."""
        if self.missing or not possible:
            return Candidates(reason=self.missing or EXCEEDED)
        goals, note, staged, known = self.goals, self.cache.note, self.cache.staged, self.known
        assert known is not None
        asked = bare(self.drive), goals.motion
        note("[5/8] choice of the reduced model")
        model = staged("model", choose_reduced_model, *asked, goals.error, modes.models)
        note("[6/8] controllers: settings of each law")
        # The model called for, then the others that bend the cable, and up to where each holds [Hz].
        holds = {one.model: one.holds_5 for one in modes.models}
        others = [number for number in (4, 3) if number in holds and number != model.chosen]
        models = {number: holds[number] for number in (model.chosen, *others)}
        controller = staged("controller", design_controller, *asked, known.quantities, models, goals.torque)
        laws = staged("laws", tuned_laws, *asked, known, controller, goals.torque, every_law=goals.every_law)
        return Candidates(model=model, controller=controller, laws=laws, bound=controller.bound)

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made["ClosedLoop"]:
        """A law on this drive."""
        goals = self.goals
        return Made(load_loop, (bare(self.drive), goals.motion, self.known, law, goals.torque, cable))


def bare(drive: Drive) -> Drive:
    """The drive without its words."""
    return replace(drive, name="", title="", source="")


def load_loop(
    drive: Drive, motion: Motion, known: Knowledge, law: LawSetting, torque: float | None, cable: bool
) -> "LoadLoop":
    """A law at its setting; ``drive``: with the best values; ``torque``: largest of the goals [N m]."""
    made = law_of(law, drive, motion, known)
    return LoadLoop(joined_loop(drive, made, motion, torque, cable=cable), drive)


@dataclass(frozen=True, slots=True, eq=False)
class LoadLoop:
    """A law on the plants of a drive, whose best values stand in ``drive``."""

    loop: Loop
    drive: Drive

    @property
    def encoders(self) -> int:
        """Encoders that are read."""
        return len(self.loop.rig.phases)

    def run(self, values: Mapping[str, float], phases: Array) -> Score:
        """Eccentricity of the load's encoder, which the law follows, and creep are added to the error."""
        moved = with_values(self.loop, self.drive, values, phases)
        done = run(moved, log=False)
        found = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=False))
        share = found["saturated"] / len(moved.target)
        if done.failed:
            return Score(peak=None, torque=None, saturated=share)
        peak = found["peak"] / moved.gear + values.get("eccentricity", 0.0) + crept(moved, values)
        return Score(peak=peak, torque=found["peak_torque"], saturated=share)

    def history(self, values: Mapping[str, float], phases: Array) -> dict[str, Array]:
        """The wanted angle of the load, its error, and the command."""
        moved = with_values(self.loop, self.drive, values, phases)
        log, rig = run(moved).log, moved.rig
        return {
            "time": rig.interval * np.arange(len(log), dtype=np.float64),
            "reference": moved.target / moved.gear,
            "error": moved.load_error(log),
            "torque": log[:, 2 * moved.chain.size + 1 + len(rig.encoders)],
        }


NO_MODELS = "a carriage divides the span; see the model of the carriage below"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriagePlant:
    """A drive whose one carriage the scheduled law covers; logs do not identify it."""

    drive: Drive
    goals: Goals
    cache: StageCache
    known: Knowledge | None = None  # None: not yet

    kind = "carriage"
    no_models = no_cable = NO_MODELS

    @property
    def task(self) -> Goals:
        """Goals without what only the acceptance, the logs or the verdict depend on."""
        plain = Goals()
        names = ("carriage_error", "draws", "cable_draws", "carriage_draws", "seed", "columns", "spreads")
        return replace(self.goals, **{name: getattr(plain, name) for name in names})

    def quantities(self, logs: Logs) -> Knowledge:
        """Data sheet, goals and estimates."""
        logged, spreads = bool(logs.arguments[0]), self.goals.spreads
        return self.cache.staged(
            "knowledge", know_carriage, bare(self.drive), self.task, spreads, logged=logged
        )

    def knowing(self, known: Knowledge) -> "CarriagePlant":
        """The same machine: no log has moved its values."""
        return replace(self, drive=released(self.drive), known=known)

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""
        return self.cache.staged("demand", carriage_demand, bare(self.drive), self.task)

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """The model of the carriage and the scheduled law at its bandwidth."""
        note, staged = self.cache.note, self.cache.staged
        assert self.known is not None
        note("[5/8] model of the carriage")
        model = staged("model", carriage_model, bare(self.drive), self.task)
        if model.reason or not possible:
            return Candidates(model=model, reason=model.reason or EXCEEDED)
        note("[6/8] controller: bandwidth of the scheduled law")
        law = staged(
            "controller",
            design_carriage_law,
            bare(self.drive),
            self.task,
            self.known.quantities,
            model.left_out,
        )
        setting = LawSetting(controller=law.name, bandwidth=law.bandwidth)
        laws = () if law.bandwidth is None else (setting,)
        return Candidates(model=model, controller=law, laws=laws, reason="" if laws else law.reason)

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made["ClosedLoop"]:
        """The scheduled law; there is no plant on the distributed cable."""
        assert not cable
        return Made(carriage_loop, (bare(self.drive), self.task, law.bandwidth))


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

    def history(self, values: Mapping[str, float], phases: Array) -> dict[str, Array]:
        """Motion and error of the carriage, or of the mass below it where that errs more."""
        case = self.case
        log = whole_run(case, self.loop, values, phases)
        both = errors(case, log)
        return {
            "time": case.interval * np.arange(len(log), dtype=np.float64),
            "reference": case.wanted[: len(log)],
            "error": both[int(np.argmax(np.abs(both).max(axis=1)))],
            "torque": log[:, FORCE] * case.design.radius,
        }


Plant = LoadPlant | CarriagePlant
"""What a study takes through its stages."""
ClosedLoop = LoadLoop | CarriageRuns
"""A law that can be run on one plant after another."""
