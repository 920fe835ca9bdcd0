"""A load on the pulleys, and a guided carriage, as a study takes them through its stages: laws and runs.

Besides the limits of `cabledrive.rig.tuning` a setting keeps its runs on plants drawn for tuning alone, from
what is known of the drive; the acceptance draws others.
"""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from cabledrive.control.darc import RATIO
from cabledrive.control.numbers import HIGH, LOW
from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.rig.carriage import FORCE, TENSIONS, run_carriage
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.laws.load_learning import KINDS
from cabledrive.rig.laws.registry import MAIN_LAWS
from cabledrive.rig.plant_samples import Disturbances
from cabledrive.rig.setting import DEGREE, sample_interval
from cabledrive.rig.tracking import summarize
from cabledrive.rig.tuning import TUNING_DRAWS, TUNING_SEED, LawSetting, setting_of
from cabledrive.studies.study import bandwidth_cost, carriage
from cabledrive.studies.study.check_stage import demand_of
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.knowledge_stage import Knowledge, know, known_drive
from cabledrive.studies.study.machine import DemandResult
from cabledrive.studies.study.modes_stage import ModelResult, ModesResult, choose_reduced_model
from cabledrive.studies.study.sampled_plants import LoadCase, LoadLoop, Score, sampled_plant, with_values
from cabledrive.studies.study.stage_cache import Logs, Made, StageCache

BANDWIDTHS = (5.0, 7.5, 10.0, 14.0, 19.0, 23.0, 27.0, 32.0, 38.0, 45.0, 55.0, 70.0, 90.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerResult:
    """The controller, and the bound that is stated for it."""

    model: int
    name: str
    # bandwidth, sliding_rate: [Hz]; None: no bandwidth could be used
    bandwidth: float | None = None
    sliding_rate: float | None = None
    bound: float | None = None  # stated bound of the load's error [rad]
    chosen: bandwidth_cost.Candidate | None = None
    candidates: tuple[bandwidth_cost.Candidate, ...]
    # lower, upper: bounds of the estimates p2 to p5 [kg m^2], [N m s/rad], [N m], [N m]
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()
    shares: dict[str, float] = field(default_factory=dict)  # what each quantity adds to the bound [rad]
    # assumptions of the theorem that do not hold on the rig; the other parts of the bound answer them
    broken: tuple[str, ...] = ()
    reason: str


def design_controller(case: LoadCase, models: Mapping[int, float]) -> ControllerResult:
    """The law and bandwidth of least bound; ``models``: up to where each is right to 5 % [Hz]."""
    rate = 1.0 / sample_interval(case.drive) / bandwidth_cost.SAMPLES_PER_PERIOD
    candidates: tuple[bandwidth_cost.Candidate, ...] = ()
    best, parts = None, {}
    for model, holds in models.items():
        hertz = [h for h in BANDWIDTHS if h <= min(holds, rate)]
        tried = (bandwidth_cost.evaluate(case, model, h) for h in hertz)
        found, one, shares = bandwidth_cost.cheapest(tried, "bound")
        candidates += found
        if one is not None and (best is None or one.bound < best.bound):
            best, parts = one, shares
    if best is None:
        model, holds = next(iter(models.items()))
        limit = f"a fortieth of the sample rate, {rate:.3g} Hz"
        if holds < rate:
            limit = f"where Model {model} is right to 5 %, {holds:.3g} Hz"
        why = f"the lowest one tried, {BANDWIDTHS[0]:g} Hz, lies above {limit}"
        why = candidates[0].refused if candidates else why
        return ControllerResult(
            model=model,
            name=f"darc-{model}-damped",
            candidates=candidates,
            reason=f"no bandwidth can be used: {why}",
        )
    holds, first = models[best.model], next(iter(models))
    limit, highest = ("the model's validity", holds) if holds <= rate else ("the sample rate", rate)
    more = f"; the law of Model {best.model} has a smaller bound than that of Model {first}, whose "
    more = "" if best.model == first else more + "springs it neglects (counted in the unmatched part)"
    law = case.chain_law(best.model, best.bandwidth)
    loop = replace(case, torque=None).loop(law)
    seen = summarize(loop, run(loop))
    return ControllerResult(
        model=best.model,
        name=law.name,
        bandwidth=best.bandwidth,
        sliding_rate=RATIO[best.model] * best.bandwidth,
        bound=best.bound,
        chosen=best,
        candidates=candidates,
        lower=tuple(float(v) for v in law.law.learning[LOW]),
        upper=tuple(float(v) for v in law.law.learning[HIGH]),
        shares=parts,
        broken=tuple(seen.summary["broken_assumptions"]),
        reason=f"{best.bandwidth:g} Hz gives the smallest bound ({best.bound / DEGREE:.3g} deg) without "
        f"excessive torque ripple from quantisation; {limit} permits up to {highest:.3g} Hz{more}",
    )


FIXED = ("pd", "shaper", "pid", "dob", "lqg", "lqi", "hinf", "l1", "mrac")
"""Tried before the law of the chain, simplest first; after it those that learn the load along the motion."""
MOST_TORQUE = 2.0 / 3.0
"""Share of the torque limit that the tuning may use: the acceptance draws plants that need more."""


def tuned_laws(
    case: LoadCase, chain_law: ControllerResult, *, every_law: bool = False
) -> tuple[LawSetting, ...]:
    """Each law at its best setting, simplest first: those that a comparison offers, or every one."""
    hertz, why = chain_law.bandwidth, chain_law.reason
    chain = LawSetting(
        controller=chain_law.name, model=chain_law.model, bandwidth=hertz, reason="" if hertz else why
    )
    fixed, learning = (
        [_tuned(name, case) for name in names if every_law or name in MAIN_LAWS] for names in (FIXED, KINDS)
    )
    return (*fixed, chain, *learning)


def _tuned(name: str, case: LoadCase) -> LawSetting:
    def error(loop: Loop, draw: int) -> float:
        count, known = len(loop.rig.phases), case.correlations
        values, phases = sampled_plant(case.quantities, count, TUNING_SEED, draw, known)
        done = run(with_values(loop, values, phases), log=False)
        if done.failed or done.score["peak_torque"] > MOST_TORQUE * loop.rig.torque_limit:
            return float("inf")
        return done.score["peak"] / loop.gear

    def worst(made: Controller) -> float:
        """Largest error over the plants for tuning [rad]; infinite where one ends early or asks too much."""
        loop = case.loop(made)
        first = error(loop, 0)
        if first == float("inf"):
            return first
        with ThreadPoolExecutor(2) as pool:
            return max(first, *pool.map(lambda k: error(loop, k), range(1, TUNING_DRAWS)))

    more = f", and {100 * MOST_TORQUE:.0f} % of the torque limit on the plants for tuning"
    return replace(setting_of(name, case.spec, Disturbances(), worst, more), seconds=0.0)


EXCEEDED = "the motion exceeds the limits of the drive"


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidates:
    """Model, controller and laws of a plant, as far as it has them."""

    model: ModelResult | carriage.CarriageModel | None = None
    controller: ControllerResult | bandwidth_cost.CarriageController | None = None
    laws: tuple[LawSetting, ...] = ()  # simplest first
    bound: float | None = None  # stated for the law of the chain [rad]
    reason: str = ""  # why there is no law; empty where there is one


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plant:
    """What a study takes through its stages: a drive whose load pulley follows the motion."""

    drive: Drive
    goals: Goals
    cache: StageCache
    known: Knowledge | None = None  # None: not yet
    no_models: str = ""  # what the file lacks for models and a controller; empty where it has all

    kind = "lumped"

    @property
    def no_cable(self) -> str:
        """Why there are no plants on the distributed cable."""
        if not self.drive.closed:
            return "the cable plant is a loop round two pulleys, this drive is a line"
        if self.known is not None and "slip_torque" in self.known.quantities:
            return "the distributed cable does not slide on its pulleys"
        motor = self.drive.motor
        loose = motor is not None and motor.backlash > 0.0
        return "the distributed cable does not support motor.backlash" if loose else ""

    def quantities(self, logs: Logs) -> Knowledge:
        """What is identified from the logs; the rest from the data sheet."""
        goals = self.goals
        return self.cache.staged(
            "knowledge", know, self.drive, logs, goals.spreads, goals.load_inertia, backlash=goals.backlash
        )

    def knowing(self, known: Knowledge) -> "Plant":
        """The drive with the best values; as its file says where something is missing."""
        drive = self.drive if self.no_models else known_drive(self.drive, known)
        return replace(self, drive=released(drive), known=known)

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""
        slides = None if self.known is None else self.known.quantities.get("slip_torque")
        limits = self.goals.torque, None if slides is None else slides.high
        return self.cache.staged("demand", demand_of, self.drive, self.goals.motion, limits)

    @property
    def case(self) -> LoadCase:
        """What its laws are designed and run for."""
        assert self.known is not None
        return load_case(bare(self.drive), self.goals, self.known)

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """The reduced model, the damped law of the chain by its bound, and every law at its best setting."""
        if self.no_models or not possible:
            return Candidates(reason=self.no_models or EXCEEDED)
        goals, note, staged, case = self.goals, self.cache.note, self.cache.staged, self.case
        note("[5/8] choice of the reduced model")
        model = staged("model", choose_reduced_model, case.drive, case.motion, goals.error, modes.models)
        note("[6/8] controllers: settings of each law")
        # The model called for, then the others that bend the cable, and up to where each holds [Hz].
        holds = {one.model: one.holds_5 for one in modes.models}
        others = [number for number in (4, 3) if number in holds and number != model.chosen]
        models = {number: holds[number] for number in (model.chosen, *others)}
        controller = staged("controller", design_controller, case, models)
        laws = staged("laws", tuned_laws, case, controller, every_law=goals.every_law)
        return Candidates(model=model, controller=controller, laws=laws, bound=controller.bound)

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made["ClosedLoop"]:
        """A law on this drive."""
        return Made(LoadLoop, (self.case, law, cable))


def bare(drive: Drive) -> Drive:
    """The drive without its words."""
    return replace(drive, name="", title="", source="")


def load_case(drive: Drive, goals: Goals, known: Knowledge) -> LoadCase:
    """A load with its goals; ``drive``: with the best values."""
    return LoadCase(
        drive=drive,
        motion=goals.motion,
        torque=goals.torque,
        quantities=known.quantities,
        correlations=known.correlations,
    )


NO_MODELS = "a carriage divides the span; see the model of the carriage below"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriagePlant(Plant):
    """A drive whose one carriage the scheduled law covers; logs do not identify it."""

    no_models: str = NO_MODELS

    kind = "carriage"
    no_cable = NO_MODELS

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
            "knowledge", carriage.know_carriage, bare(self.drive), self.task, spreads, logged=logged
        )

    def demand(self) -> DemandResult:
        """What the motion asks of motor and cable."""
        return self.cache.staged("demand", carriage.carriage_demand, bare(self.drive), self.task)

    def candidates(self, modes: ModesResult, *, possible: bool) -> Candidates:
        """The model of the carriage and the scheduled law at its bandwidth."""
        note, staged, about = self.cache.note, self.cache.staged, (bare(self.drive), self.task)
        assert self.known is not None
        note("[5/8] model of the carriage")
        model = staged("model", carriage.carriage_model, *about)
        if model.reason or not possible:
            return Candidates(model=model, reason=model.reason or EXCEEDED)
        note("[6/8] controller: bandwidth of the scheduled law")
        law = staged(
            "controller", bandwidth_cost.design_carriage_law, *about, self.known.quantities, model.left_out
        )
        setting = LawSetting(controller=law.name, bandwidth=law.bandwidth)
        laws = () if law.bandwidth is None else (setting,)
        return Candidates(model=model, controller=law, laws=laws, reason="" if laws else law.reason)

    def closed_loop(self, law: LawSetting, *, cable: bool) -> Made["ClosedLoop"]:
        """The scheduled law; there is no plant on the distributed cable."""
        assert not cable
        return Made(CarriageRuns, (bare(self.drive), self.task, law.bandwidth))


class CarriageRuns:
    """The scheduled law at a bandwidth [Hz]; what the model leaves out is added to every error."""

    encoders = 2

    def __init__(self, drive: Drive, goals: Goals, bandwidth: float) -> None:
        self.case = carriage.CarriageCase(drive, goals)
        self.loop, self.left_out = self.case.loop(bandwidth), self.case.left_out

    def run(self, values: Mapping[str, float], phases: Array) -> Score:
        """Errors of the carriage and of the mass below it, whichever is larger."""
        case = self.case
        log = run_carriage(self.loop, case.plant(values), phases)
        off, standing = np.abs(case.errors(log)).max(axis=0), case.standing[: len(log)]
        torque, saturated = case.torque(log)
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
        log = run_carriage(self.loop, case.plant(values), phases)
        both = case.errors(log)
        return {
            "time": case.interval * np.arange(len(log), dtype=np.float64),
            "reference": case.wanted[: len(log)],
            "error": both[int(np.argmax(np.abs(both).max(axis=1)))],
            "torque": log[:, FORCE] * case.design.radius,
        }


ClosedLoop = LoadLoop | CarriageRuns
"""A law that can be run on one plant after another."""
