"""Stage 6: bandwidth by what modes, sensors, torque and uncertainty allow, and the laws to try.

Besides the limits of `cabledrive.rig.tuning` a setting keeps its runs on plants drawn for tuning alone, from
what is known of the drive; the acceptance draws others.
"""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

from cabledrive.control.darc import RATIO
from cabledrive.control.numbers import HIGH, LOW
from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.load_learning import KINDS
from cabledrive.rig.laws.registry import MAIN_LAWS
from cabledrive.rig.plant_samples import Disturbances
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.tracking import summarize
from cabledrive.rig.tuning import TUNING_DRAWS, TUNING_SEED, LawSetting, law_at, setting_of
from cabledrive.studies.study.bandwidth_cost import SAMPLES_PER_PERIOD, Candidate, cheapest, evaluate
from cabledrive.studies.study.knowledge_stage import Knowledge
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.sampled_plants import (
    joined_loop,
    make_law,
    near_encoder,
    rig_options,
    sampled_plant,
    with_values,
)

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
    chosen: Candidate | None = None
    candidates: tuple[Candidate, ...]
    # lower, upper: bounds of the estimates p2 to p5 [kg m^2], [N m s/rad], [N m], [N m]
    lower: tuple[float, ...] = ()
    upper: tuple[float, ...] = ()
    shares: dict[str, float] = field(default_factory=dict)  # what each quantity adds to the bound [rad]
    # assumptions of the theorem that do not hold on the rig; the other parts of the bound answer them
    broken: tuple[str, ...] = ()
    reason: str


def design_controller(
    drive: Drive,
    motion: Motion,
    quantities: Mapping[str, Quantity],
    models: Mapping[int, float],
    torque: float | None,
) -> ControllerResult:
    """The law and bandwidth of least bound; ``models``: up to where each is right to 5 % [Hz]."""
    assert drive.sensors is not None
    assert drive.sensors.sample_rate is not None
    rate = drive.sensors.sample_rate / SAMPLES_PER_PERIOD
    candidates: tuple[Candidate, ...] = ()
    best, parts = None, {}
    for model, holds in models.items():
        hertz = [h for h in BANDWIDTHS if h <= min(holds, rate)]
        tried = (evaluate(drive, motion, quantities, model, h, torque) for h in hertz)
        found, one, shares = cheapest(tried, "bound")
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
    law = make_law(drive, motion, quantities, best.model, best.bandwidth)
    loop = joined_loop(drive, law, motion, None)
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
        reason=_reason(best, models, rate),
    )


def _reason(best: Candidate, models: Mapping[int, float], rate: float) -> str:
    assert best.bound is not None
    holds, first = models[best.model], next(iter(models))
    limit, highest = ("the model's validity", holds) if holds <= rate else ("the sample rate", rate)
    more = f"; the law of Model {best.model} has a smaller bound than that of Model {first}, whose "
    more = "" if best.model == first else more + "springs it neglects (counted in the unmatched part)"
    return (
        f"{best.bandwidth:g} Hz gives the smallest bound ({best.bound / DEGREE:.3g} deg) without excessive "
        f"torque ripple from quantisation; {limit} permits up to {highest:.3g} Hz{more}"
    )


FIXED = ("pd", "shaper", "pid", "dob", "lqg", "lqi", "hinf", "l1", "mrac")
"""Tried before the law of the chain, simplest first; after it those that learn the load along the motion."""
MOST_TORQUE = 2.0 / 3.0
"""Share of the torque limit that the tuning may use: the acceptance draws plants that need more."""


def tuned_laws(
    drive: Drive,
    motion: Motion,
    known: Knowledge,
    chain_law: ControllerResult,
    torque: float | None,
    *,
    every_law: bool = False,
) -> tuple[LawSetting, ...]:
    """Each law at its best setting, simplest first: those that a comparison offers, or every one."""
    hertz, why = chain_law.bandwidth, chain_law.reason
    chain = LawSetting(
        controller=chain_law.name, model=chain_law.model, bandwidth=hertz, reason="" if hertz else why
    )
    fixed, learning = (
        [_tuned(name, drive, motion, known, torque) for name in names if every_law or name in MAIN_LAWS]
        for names in (FIXED, KINDS)
    )
    return (*fixed, chain, *learning)


def law_of(setting: LawSetting, drive: Drive, motion: Motion, known: Knowledge) -> Controller:
    """A law at its setting, ready to run; ``setting``: with a value; ``drive``: with the best values."""
    assert setting.bandwidth is not None
    if setting.model is not None:
        return make_law(drive, motion, known.quantities, setting.model, setting.bandwidth)
    spec = DesignSpec(drive, motion, feedback=near_encoder(drive), options=rig_options(drive))
    return law_at(setting.controller, setting.bandwidth, setting.filter, spec)


def _tuned(name: str, drive: Drive, motion: Motion, known: Knowledge, torque: float | None) -> LawSetting:
    spec = DesignSpec(drive, motion, feedback=near_encoder(drive), options=rig_options(drive))

    def worst(made: Controller) -> float:
        """Largest error over the plants for tuning [rad]; infinite where one ends early or asks too much."""
        loop = joined_loop(drive, made, motion, torque)
        first = _error(loop, drive, known, 0)
        if first == float("inf"):
            return first
        with ThreadPoolExecutor(2) as pool:
            return max(first, *pool.map(lambda k: _error(loop, drive, known, k), range(1, TUNING_DRAWS)))

    more = f", and {100 * MOST_TORQUE:.0f} % of the torque limit on the plants for tuning"
    return replace(setting_of(name, spec, Disturbances(), worst, more), seconds=0.0)


def _error(loop: Loop, drive: Drive, known: Knowledge, draw: int) -> float:
    values, phases = sampled_plant(
        known.quantities, len(loop.rig.phases), TUNING_SEED, draw, known.correlations
    )
    done = run(with_values(loop, drive, values, phases), log=False)
    score = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=True))
    if done.failed or score["peak_torque"] > MOST_TORQUE * loop.rig.torque_limit:
        return float("inf")
    return score["peak"] / loop.gear
