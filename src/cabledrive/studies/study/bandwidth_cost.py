r"""What a bandwidth costs: parts of the bound, torque and error that encoder counts make.

In the linear closed loop (filter at its last gains, estimates at rest, no Coulomb friction) an error of the
readings :math:`|\nu_j| \le q_j/2` moves the load by at most :math:`\tfrac{q_j}{2}\sum_k|g_j(k)|` with the
impulse response :math:`g_j`; the unknown phase of an encoder is a step of at most :math:`q_j/2`.
"""

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.margins import closed_loop, response, sampled_controller, sampled_plant
from cabledrive.rig.setting import Motion
from cabledrive.rig.tracking import summarize
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.sampled_plants import joined_loop, make_law, rig_options, with_values

UNSTABLE = 1e3


def sensor_bound(loop: Loop) -> float | None:
    """Largest error of the load by counts and phases of the encoders [rad]; None if the loop is unstable."""
    transition, readings, _ = closed_loop(sampled_controller(loop), sampled_plant(loop))
    if np.abs(np.linalg.eigvals(transition)).max() > 1.0 + 1e-6:
        return None
    load = np.eye(len(transition))[loop.chain.size - 1]
    impulse = response(transition, readings, load, len(loop.target))
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
class Candidate:
    """One bandwidth and what it costs."""

    model: int  # {1, 3, 4}: of the law
    bandwidth: float  # lambda/(2 pi) [Hz]
    theorem: float | None = None  # largest value of the theorem's tube, friction included [rad]
    # what the springs, dampers and the load within their bounds add, the filter in the loop: each by itself,
    # summed, or all at once, whichever is more [rad]
    unmatched: float | None = None
    # what counting and unknown encoder phases add, at the best values or at the ends that push one way [rad]
    sensors: float | None = None
    bound: float | None = None  # all of it [rad]
    torque: float | None = None  # largest of a run with encoders, their counts included [N m]
    refused: str = ""  # why it cannot be used; empty where it can


def evaluate(
    drive: Drive,
    motion: Motion,
    quantities: Mapping[str, Quantity],
    model: int,
    hertz: float,
    torque: float | None,
) -> tuple[Candidate, dict[str, float]]:
    """The parts of the bound at one bandwidth [Hz], among them what each quantity adds [rad]."""
    law = make_law(drive, motion, quantities, model, hertz)
    ideal = joined_loop(drive, drive, law, motion, torque, options=rig_options(drive, ideal=True))
    real = joined_loop(drive, drive, law, motion, torque)
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
        moved = with_values(smooth, drive, values, None)
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
        joint, cost = error(values), sensor_bound(with_values(real, drive, values, None))
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
