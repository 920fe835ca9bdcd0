"""Stage 6: bandwidth by what modes, sensors, torque and uncertainty allow; the bound that goes with it."""

from collections.abc import Mapping
from dataclasses import dataclass

from cabledrive.control.darc import RATIO
from cabledrive.control.numbers import HIGH, LOW
from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop import run
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.tracking import summarize
from cabledrive.studies.study.bandwidth_cost import Candidate, evaluate
from cabledrive.studies.study.bandwidth_search import SAMPLES_PER_PERIOD, while_quiet
from cabledrive.studies.study.closed_loop import joined_loop, make_law, rig_options
from cabledrive.studies.study.machine import Quantity

BANDWIDTHS = (5.0, 7.5, 10.0, 14.0, 19.0, 23.0, 27.0, 32.0, 38.0, 45.0, 55.0, 70.0, 90.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerResult:
    """The controller, and the bound that is stated for it.

    Attributes
    ----------
    model : int
    name : str
    bandwidth, sliding_rate : float or None
        [Hz]; None: no bandwidth could be used.
    bound : float or None
        Stated bound of the load's error [rad].
    chosen : Candidate or None
    candidates : tuple of Candidate
    lower, upper : tuple of float
        Bounds of the estimates p2 to p5 [kg m^2], [N m s/rad], [N m], [N m].
    shares : dict of str to float
        What each uncertain quantity adds to the bound [rad].
    broken : tuple of str
        Assumptions of the theorem that do not hold on the rig; the other parts of the bound answer them.
    reason : str
    """

    model: int
    name: str
    bandwidth: float | None
    sliding_rate: float | None
    bound: float | None
    chosen: Candidate | None
    candidates: tuple[Candidate, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    shares: dict[str, float]
    broken: tuple[str, ...]
    reason: str


def design_controller(
    drive: Drive,
    motion: Motion,
    quantities: Mapping[str, Quantity],
    models: Mapping[int, float],
    torque: float | None,
) -> ControllerResult:
    """The law and bandwidth with the smallest bound among those that modes, sampling and torque allow.

    ``drive``: with the best values; ``models``: Models that the law may be made for, the one that the motion
    calls for first, and up to which frequency each is right to 5 % [Hz]; ``torque``: largest torque of the
    goals [N m].
    """
    assert drive.sensors is not None
    assert drive.sensors.sample_rate is not None
    rate = drive.sensors.sample_rate / SAMPLES_PER_PERIOD
    candidates: list[Candidate] = []
    best, parts = None, {}
    for model, holds in models.items():
        hertz = [h for h in BANDWIDTHS if h <= min(holds, rate)]
        for found, shares in while_quiet(
            evaluate(drive, motion, quantities, model, h, torque) for h in hertz
        ):
            candidates.append(found)
            if found.bound is not None and not found.refused and (best is None or _below(found, best)):
                best, parts = found, shares
    if best is None:
        return _without(models, tuple(candidates), rate)
    model = best.model
    law = make_law(drive, motion, quantities, best.model, best.bandwidth)
    return ControllerResult(
        model=model,
        name=law.name,
        bandwidth=best.bandwidth,
        sliding_rate=RATIO[model] * best.bandwidth,
        bound=best.bound,
        chosen=best,
        candidates=tuple(candidates),
        lower=tuple(float(v) for v in law.law.learning[LOW]),
        upper=tuple(float(v) for v in law.law.learning[HIGH]),
        shares=parts,
        broken=_broken(drive, motion, law),
        reason=_reason(best, models, rate),
    )


def _below(one: Candidate, other: Candidate) -> bool:
    assert one.bound is not None
    assert other.bound is not None
    return one.bound < other.bound


def _without(models: Mapping[int, float], candidates: tuple[Candidate, ...], rate: float) -> ControllerResult:
    model, holds = next(iter(models.items()))
    limit = f"a fortieth of the sample rate, {rate:.3g} Hz"
    if holds < rate:
        limit = f"where Model {model} is right to 5 %, {holds:.3g} Hz"
    why = f"the lowest one tried, {BANDWIDTHS[0]:g} Hz, lies above {limit}"
    why = candidates[0].refused if candidates else why
    return ControllerResult(
        model=model,
        name=f"darc-{model}-damped",
        bandwidth=None,
        sliding_rate=None,
        bound=None,
        chosen=None,
        candidates=candidates,
        lower=(),
        upper=(),
        shares={},
        broken=(),
        reason=f"no bandwidth can be used: {why}",
    )


def _broken(drive: Drive, motion: Motion, law: Controller) -> tuple[str, ...]:
    loop = joined_loop(drive, drive, law, motion, None)
    found = summarize(loop, run(loop), drive, drive, motion, rig_options(drive), 0)
    return tuple(found.summary["broken_assumptions"])


def _reason(best: Candidate, models: Mapping[int, float], rate: float) -> str:
    assert best.bound is not None
    holds, first = models[best.model], next(iter(models))
    limit, highest = ("the model's validity", holds) if holds <= rate else ("the sample rate", rate)
    words = (
        f"{best.bandwidth:g} Hz gives the smallest bound ({best.bound / DEGREE:.3g} deg) without excessive "
        f"torque ripple from quantisation; {limit} permits up to {highest:.3g} Hz"
    )
    if best.model != first:
        words += (
            f"; the law of Model {best.model} has a smaller bound than that of Model {first}, whose springs "
        )
        words += "it neglects (counted in the unmatched part)"
    return words
