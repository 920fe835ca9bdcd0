r"""What a bandwidth costs: parts of the bound, torque and error that encoder counts make.

In the linear closed loop (filter at its last gains, estimates at rest, no Coulomb friction) an error of the
readings :math:`|\nu_j| \le q_j/2` moves the load by at most :math:`\tfrac{q_j}{2}\sum_k|g_j(k)|` with the
impulse response :math:`g_j`; the unknown phase of an encoder is a step of at most :math:`q_j/2`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

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
    "load_inertia",
    "cable_stiffness",
    "cable_damping",
    "joint_stiffness",
    "joint_damping",
    "motor_share",
    "load_viscous_friction",
    "load_coulomb_friction",
    "backlash",
    "delay",
    "ripple_torque",
)


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
    nominal = summarize(ideal, run(ideal), drive, drive, motion, rig_options(drive, ideal=True), 0)
    seen = summarize(real, run(real), drive, drive, motion, rig_options(drive), 0)
    empty = Candidate(model=model, bandwidth=hertz)
    incomplete = nominal.incomplete or seen.incomplete
    sensors = sensor_bound(real)
    if incomplete or nominal.bound is None or sensors is None:
        why = incomplete or "the loop with encoders and filter is unstable"
        return replace(empty, refused=why), {}
    nominal_error = _error(smooth, drive, {})
    found = None if nominal_error is None else unmatched_part(smooth, drive, quantities, nominal_error)
    if nominal_error is None or found is None:
        return replace(
            empty, refused="for some parameters within their bounds the drive diverges, or a span goes slack"
        ), {}
    deviation, shares, ends = found
    for values in ends:
        cost = sensor_bound(with_values(real, drive, values, None))
        if cost is None:
            why = "for some parameters within their bounds the loop with encoders and filter is unstable"
            return replace(empty, refused=why), {}
        sensors = max(sensors, cost)
    unmatched = deviation + np.maximum(np.abs(nominal_error) - nominal.bound, 0.0)
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
    ), shares


def unmatched_part(
    loop: Loop, drive: Drive, quantities: Mapping[str, Quantity], nominal: Array
) -> tuple[Array, dict[str, float], tuple[dict[str, float], ...]] | None:
    """How far springs, dampers and the load can move the error within their bounds; None if a run ended.

    Returns the sum of the largest deviations from the ``nominal`` error, or the deviation with all quantities
    at the ends that push one way, whichever is larger, shape (samples,) [rad]; the largest by each quantity
    alone [rad]; these ends, and the opposite ones.
    """
    open_names = [n for n in UNMATCHED if n in quantities and quantities[n].low != quantities[n].high]
    moved: dict[str, tuple[Array, Array]] = {}
    for name in open_names:
        outer, best = quantities[name].outer, quantities[name].value
        low, high = (nominal if value == best else _error(loop, drive, {name: value}) for value in outer)
        if low is None or high is None:
            return None
        moved[name] = low - nominal, high - nominal
    largest = {name: np.abs(both).max(axis=0) for name, both in moved.items()}
    deviation = np.sum([np.zeros(len(nominal)), *largest.values()], axis=0)
    sample = int(np.argmax(deviation))
    up = {name: int(high[sample] > low[sample]) for name, (low, high) in moved.items()}
    ends = tuple(
        {name: quantities[name].outer[abs(end - side)] for name, end in up.items()} for side in (0, 1) if up
    )
    for values in ends:
        joint = _error(loop, drive, values)
        if joint is None:
            return None
        deviation = np.maximum(deviation, np.abs(joint - nominal))
    shares = {name: float(each.max()) for name, each in largest.items()}
    return deviation, shares, ends


def _error(loop: Loop, drive: Drive, values: Mapping[str, float]) -> Array | None:
    """Error of the load over time with other values [rad]; None where the run failed."""
    moved = with_values(loop, drive, values, None)
    done = run(moved)
    return None if done.failed else moved.load_error(done.log)
