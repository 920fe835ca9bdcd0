r"""What a bandwidth costs: parts of the bound, torque and error that encoder counts make.

In the linear closed loop (filter at its last gains, estimates at rest, no Coulomb friction) an error of the
readings :math:`|\nu_j| \le q_j/2` moves the load by at most :math:`\tfrac{q_j}{2}\sum_k|g_j(k)|` with the
impulse response :math:`g_j`; the unknown phase of an encoder is a step of at most :math:`q_j/2`.

The bandwidth of a carriage's law: the smallest error that torque, sampling and stability allow.
"""

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.bound import impulse_response
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.rig.carriage import run_carriage
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.margins import closed_loop, sampled_controller, sampled_plant
from cabledrive.rig.tracking import summarize
from cabledrive.studies.study.carriage import CarriageCase
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.sampled_plants import LoadCase, with_values

UNSTABLE = 1e3
SAMPLES_PER_PERIOD = 40.0


def sensor_bound(loop: Loop) -> float | None:
    """Largest error of the load by counts and phases of the encoders [rad]; None if the loop is unstable."""
    transition, readings, _ = closed_loop(sampled_controller(loop), sampled_plant(loop))
    if np.abs(np.linalg.eigvals(transition)).max() > 1.0 + 1e-6:
        return None
    load = np.eye(len(transition))[loop.chain.size - 1]
    impulse = impulse_response(transition, readings, load, len(loop.target))
    total, highest = np.abs(impulse).sum(axis=0), np.abs(np.cumsum(impulse, axis=0)).max(axis=0)
    bound = float(0.5 * loop.rig.counts @ (total + highest) / loop.gear)
    return bound if bound < UNSTABLE else None


FINE = 1e-9
"""Share of a count that stands for none: the filter stays as it is."""
UNMATCHED = (
    *("load_inertia", "cable_stiffness", "cable_damping", "joint_stiffness", "joint_damping", "motor_share"),
    *("load_viscous_friction", "load_coulomb_friction", "backlash", "delay", "ripple_torque"),
)
DIVERGES = "for some parameters within their bounds the drive diverges, or a span goes slack"
RIPPLE = 1.5
"""Largest torque from quantisation, over that of the bandwidth with the least."""
LOUD = "quantisation raises the torque by half and more"


def cheapest(
    tried: Iterable[tuple[Any, dict[str, float]]], cost: str
) -> tuple[tuple[Any, ...], Any, dict[str, float]]:
    """Candidates up to the first that is too loud, which is refused; the cheapest, and its shares."""
    least, lowest, found, best, parts = float("inf"), float("inf"), [], None, dict[str, float]()
    for one, shares in tried:
        least = min(least, one.torque if one.torque is not None else least)
        loud = one.torque is not None and one.torque > RIPPLE * least
        own, price = replace(one, refused=LOUD) if loud and not one.refused else one, getattr(one, cost)
        found.append(own)
        if price is not None and not own.refused and price < lowest:
            best, parts, lowest = own, shares, price
        if loud:
            break
    return tuple(found), best, parts


def moved_within(
    quantities: Mapping[str, Quantity],
    names: Iterable[str],
    error: Callable[[dict[str, float]], Array | None],
) -> dict[str, Array] | None:
    """How the error moves at either bound of each quantity that is not known for sure, shape (2, ...)."""
    nominal = error({})
    open_ones = {name: quantities[name] for name in names if quantities[name].low < quantities[name].high}
    asked = [(name, value) for name, one in open_ones.items() for value in one.outer]

    def at(item: tuple[str, float]) -> Array | None:
        return nominal if item[1] == open_ones[item[0]].value else error(dict([item]))

    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(at, asked))
    if nominal is None or any(one is None for one in found):
        return None
    moved = [np.asarray(one) - nominal for one in found]
    return {name: np.array(moved[2 * k : 2 * k + 2]) for k, name in enumerate(open_ones)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Costed:
    """One bandwidth and what it costs."""

    bandwidth: float  # [Hz]: lambda/(2 pi); of a carriage's law that of the loop round the rigid whole
    torque: float | None = None  # largest of a run with encoders, their counts included [N m]
    refused: str = ""  # why it cannot be used; empty where it can


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate(Costed):
    """One of the law of a chain."""

    model: int  # {1, 3, 4}: of the law
    theorem: float | None = None  # largest value of the theorem's tube, friction included [rad]
    # what the springs, dampers and the load within their bounds add, the filter in the loop: each by itself,
    # summed, or all at once, whichever is more [rad]
    unmatched: float | None = None
    # what counting and unknown encoder phases add, at the best values or at the ends that push one way [rad]
    sensors: float | None = None
    bound: float | None = None  # all of it [rad]


def evaluate(case: LoadCase, model: int, hertz: float) -> tuple[Candidate, dict[str, float]]:
    """The parts of the bound at one bandwidth [Hz], among them what each quantity adds [rad]."""
    law, quantities = case.chain_law(model, hertz), case.quantities
    ideal, real = case.loop(law, ideal=True), case.loop(law)
    fine = real.rig._replace(counts=FINE * real.rig.counts, phases=np.zeros_like(real.rig.phases))
    smooth = replace(real, rig=fine)
    nominal = summarize(ideal, run(ideal))
    seen = summarize(real, run(real))
    empty = Candidate(model=model, bandwidth=hertz)
    incomplete = nominal.incomplete or seen.incomplete
    sensors = sensor_bound(real)
    if incomplete or nominal.bound is None or sensors is None:
        why = incomplete or "the loop with encoders and filter is unstable"
        return replace(empty, refused=why), {}

    def error(values: Mapping[str, float]) -> Array | None:
        moved = with_values(smooth, values, None)
        done = run(moved)
        return None if done.failed else moved.load_error(done.log)

    own, moved = error({}), moved_within(quantities, [n for n in UNMATCHED if n in quantities], error)
    if own is None or moved is None:
        return replace(empty, refused=DIVERGES), {}
    largest = {name: np.abs(both).max(axis=0) for name, both in moved.items()}
    # By each quantity alone, summed; or by all at the ends that push one way, whichever is more.
    deviation = np.sum([np.zeros(len(own)), *largest.values()], axis=0)
    sample = int(np.argmax(deviation))
    up = {name: int(high[sample] > low[sample]) for name, (low, high) in moved.items()}
    for side in (0, 1) if up else ():
        values = {name: quantities[name].outer[abs(end - side)] for name, end in up.items()}
        joint, cost = error(values), sensor_bound(with_values(real, values, None))
        if joint is None:
            return replace(empty, refused=DIVERGES), {}
        if cost is None:
            why = "for some parameters within their bounds the loop with encoders and filter is unstable"
            return replace(empty, refused=why), {}
        deviation = np.maximum(deviation, np.abs(joint - own))
        sensors = max(sensors, cost)
    unmatched = deviation + np.maximum(np.abs(own) - nominal.bound, 0.0)
    peak = float(seen.summary["peak_torque"])
    saturated = seen.summary["saturated_fraction"] > 0.0
    return Candidate(
        model=model,
        bandwidth=hertz,
        theorem=float(nominal.bound.max()),
        unmatched=float(unmatched.max()),
        sensors=sensors,
        bound=float((nominal.bound + unmatched).max()) + sensors,
        torque=peak,
        refused=f"the torque reaches its limit of {peak:.4g} N m" if saturated else "",
    ), {name: float(each.max()) for name, each in largest.items()}


SHARES = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8)
"""Bandwidths that are tried, over the lowest frequency of the carriage on its cable along the way."""
SWINGS = (1.0, 1.5, 2.0, 3.0, 4.5)
"""The same over the frequency of the swing, where a mass hangs below the carriage."""
CENTRED = np.zeros(2)
OFF = np.array([0.25, -0.25])
"""Encoder phases of the run that measures the effect of quantisation, in counts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageCandidate(Costed):
    """One of the law of a carriage."""

    nominal: float | None = None  # largest error at the best values, encoders that do not count [m]
    # what each number within its bounds adds, by itself; the root of the squares' sum [m]
    uncertain: float | None = None
    sensors: float | None = None  # what counting adds [m]
    estimate: float | None = None  # all of it, with what the model leaves out [m]; no theorem's bound
    # largest real part of a pole along the way, the cable at its best value and at its bounds [1/s]
    growth: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageController:
    """The law of a carriage."""

    name: str
    bandwidth: float | None  # [Hz]; None: none could be used
    chosen: CarriageCandidate | None
    candidates: tuple[CarriageCandidate, ...]
    shares: dict[str, float]  # what each uncertain number adds to the error [m]
    both: bool  # whether the law listens to the encoder of the load pulley as well
    # positions, frequencies: places along the way [m] and the carriage's frequency on its cable there [Hz]
    positions: tuple[float, ...]
    frequencies: tuple[float, ...]
    reason: str


def design_carriage_law(
    drive: Drive, goals: Goals, quantities: Mapping[str, Quantity], left_out: float
) -> CarriageController:
    """The scheduled law with the smallest estimated error; ``left_out``: what the model leaves out [m]."""
    case = CarriageCase(drive, goals)
    lowest, rate = float(case.cable_frequencies.min()), 1.0 / case.interval / SAMPLES_PER_PERIOD
    every = [share * lowest for share in SHARES]
    if case.hanging:
        swing = (case.design.gravity / case.design.line_length) ** 0.5 / (2.0 * pi)
        every += [share * swing for share in SWINGS if share * swing < SHARES[-1] * lowest]
    # From the lowest on; what is too fast for sampling or for the cable is not tried.
    hertz = sorted({float(f"{f:.3g}") for f in every if f <= rate})
    tried = (evaluate_carriage(case, quantities, f, left_out) for f in hertz)
    candidates, best, parts = cheapest(tried, "estimate")
    if best is None:
        why = candidates[0].refused if candidates else f"none is below {rate:.3g} Hz, a fortieth of sampling"
        reason = f"no bandwidth can be used: {why}"
    else:
        reason = (
            f"{best.bandwidth:g} Hz gives the smallest estimated error, {1e3 * best.estimate:.3g} mm, while "
            f"stable along the way with the cable at both of its bounds and without excessive torque ripple "
            f"from quantisation; the carriage vibrates on its cable at {lowest:.3g} Hz and more"
        )
    return CarriageController(
        name="scheduled",
        bandwidth=None if best is None else best.bandwidth,
        chosen=best,
        candidates=candidates,
        shares=parts,
        both=len(case.reads) > 1,
        positions=tuple(float(x) for x in case.places),
        frequencies=tuple(float(f) for f in case.cable_frequencies),
        reason=reason,
    )


def evaluate_carriage(
    case: CarriageCase, quantities: Mapping[str, Quantity], hertz: float, left_out: float
) -> tuple[CarriageCandidate, dict[str, float]]:
    """What one bandwidth costs: ``shares``: what each number adds [m]; ``hertz``, ``left_out`` [Hz], [m]."""
    empty = CarriageCandidate(bandwidth=hertz)
    try:
        ideal, real = (case.loop(hertz, ideal=kind) for kind in (True, False))
    except NotComputed as failure:
        return replace(empty, refused=f"no feedback or observer exists: {failure}"), {}
    cable = quantities["cable_stiffness"]
    tried = {"the cable at its best value": cable.value}
    tried |= dict(zip(("the cable at its softest", "the cable at its stiffest"), cable.outer, strict=True))
    rate, place, bound = max(
        (*case.growth(real, case.plant({"cable_stiffness": stiff})), words) for words, stiff in tried.items()
    )
    empty = replace(empty, growth=rate)
    if rate >= 0.0:
        return replace(empty, refused=f"unstable at {place:.3g} m, {bound}"), {}
    clean, seen = (
        run_carriage(*given) for given in ((ideal, case.design, CENTRED), (real, case.design, OFF))
    )
    if min(len(clean), len(seen)) < len(case.reference):
        return replace(empty, refused="a strand goes slack, or the carriage leaves its span"), {}

    def error(values: Mapping[str, float]) -> Array | None:
        log = run_carriage(ideal, case.plant(values), CENTRED) if values else clean
        return case.errors(log) if len(log) == len(case.reference) else None

    found = moved_within(quantities, quantities, error)
    if found is None:
        why = "for some parameters within their bounds the drive diverges, or a strand goes slack"
        return replace(empty, refused=why), {}
    largest = {name: np.abs(both).max(axis=0) for name, both in found.items()}
    # At every sample by squares: the numbers are drawn independently of one another.
    errors = case.errors(clean)
    moved = np.sqrt(np.sum([np.zeros_like(errors), *(one**2 for one in largest.values())], axis=0))
    nominal = np.abs(errors)
    sensors = float(np.abs(case.errors(seen) - errors).max())
    torque, saturated = case.torque(seen)
    return replace(
        empty,
        nominal=float(nominal.max()),
        uncertain=float(moved.max()),
        sensors=sensors,
        estimate=float((nominal + moved).max()) + sensors + left_out,
        torque=torque,
        refused=f"the torque reaches its limit of {torque:.4g} N m" if saturated else "",
    ), {name: float(one.max()) for name, one in largest.items()}
