"""Stage 6: bandwidth by what modes, sensors, torque and uncertainty allow; the bound that goes with it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from cabledrive.control.numbers import HIGH, LOW
from cabledrive.parameters import Drive
from cabledrive.rig.controllers import Controller
from cabledrive.rig.loop import run
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.tracking import told
from cabledrive.studies.study.bandwidth_cost import Candidate, evaluate
from cabledrive.studies.study.closed_loop import joined_loop, make_law, rig_options
from cabledrive.studies.study.machine import Quantity

BANDWIDTHS = (5.0, 7.5, 10.0, 14.0, 19.0, 23.0, 27.0, 32.0, 38.0, 45.0, 55.0)
RIPPLE = 1.5
"""Largest torque, over that of the calmest bandwidth, that encoder counts may cost."""

SAMPLES_PER_PERIOD = 40.0


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
    model: int,
    holds: float,
    torque: float | None,
) -> ControllerResult:
    """The bandwidth with the smallest bound among those that modes, sampling and torque allow.

    Parameters
    ----------
    drive : Drive
        With the best values.
    motion : Motion
    quantities : mapping of str to Quantity
    model : {1, 3, 4}
    holds : float
        Up to which frequency the model is right to 5 % [Hz].
    torque : float or None
        Largest torque of the goals [N m].

    Returns
    -------
    ControllerResult
    """
    assert drive.sensors is not None
    assert drive.sensors.sample_rate is not None
    highest = min(holds, drive.sensors.sample_rate / SAMPLES_PER_PERIOD)
    candidates: list[Candidate] = []
    best, parts, calm = None, {}, float("inf")
    for hertz in (h for h in BANDWIDTHS if h <= highest):
        found, shares = evaluate(drive, motion, quantities, model, hertz, torque)
        calm = min(calm, found.torque if found.torque is not None else calm)
        loud = found.torque is not None and found.torque > RIPPLE * calm
        if loud and not found.refused:
            found = replace(found, refused=f"encoder counts raise the torque to {found.torque:.3g} N m")
        candidates.append(found)
        if found.bound is not None and not found.refused and (best is None or _below(found, best)):
            best, parts = found, shares
        if loud:
            break
    if best is None:
        return _without(model, tuple(candidates), highest)
    law = make_law(drive, motion, quantities, model, best.bandwidth)
    return ControllerResult(
        model=model,
        name=law.name,
        bandwidth=best.bandwidth,
        sliding_rate=float(law.gains["sliding_rate_hz"]),
        bound=best.bound,
        chosen=best,
        candidates=tuple(candidates),
        lower=tuple(float(v) for v in law.law.learning[LOW]),
        upper=tuple(float(v) for v in law.law.learning[HIGH]),
        shares=parts,
        broken=_broken(drive, motion, law),
        reason=_reason(best, highest, holds),
    )


def _below(one: Candidate, other: Candidate) -> bool:
    assert one.bound is not None
    assert other.bound is not None
    return one.bound < other.bound


def _without(model: int, candidates: tuple[Candidate, ...], highest: float) -> ControllerResult:
    why = candidates[0].refused if candidates else f"none is below {highest:.3g} Hz"
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
    found = told(loop, run(loop), drive, drive, motion, rig_options(drive), 0)
    return tuple(found.summary["broken_assumptions"])


def _reason(best: Candidate, highest: float, holds: float) -> str:
    assert best.bound is not None
    limit = "the model's validity" if holds <= highest else "the sample rate"
    return (
        f"{best.bandwidth:g} Hz has the smallest bound, {best.bound / DEGREE:.3g} deg, of those whose torque "
        f"encoder counts leave calm; {limit} would let pass {highest:.3g} Hz"
    )
