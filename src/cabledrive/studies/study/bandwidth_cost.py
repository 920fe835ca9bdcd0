"""What a bandwidth costs: the parts of the bound, and the torque that encoder counts add."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.setting import Motion
from cabledrive.rig.tracking import told
from cabledrive.studies.study.closed_loop import joined_loop, make_law, rig_options, with_values
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.sensor_gain import sensor_bound

UNMATCHED = (
    "load_inertia",
    "cable_stiffness",
    "cable_damping",
    "joint_stiffness",
    "joint_damping",
    "motor_share",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One bandwidth and what it costs.

    Attributes
    ----------
    model : {1, 3, 4}
        Of the law.
    bandwidth : float
        lambda/(2 pi) [Hz].
    theorem : float or None
        Largest value of the theorem's tube, matched uncertainty and friction [rad].
    unmatched : float or None
        What the springs, dampers and the load within their bounds add, each by itself, summed [rad].
    sensors : float or None
        What counting and unknown encoder phases add [rad].
    bound : float or None
        All of it [rad].
    torque : float or None
        Largest torque of a run with encoders, and what their counts add to it [N m].
    refused : str
        Why it cannot be used; empty where it can.
    """

    model: int
    bandwidth: float
    theorem: float | None
    unmatched: float | None
    sensors: float | None
    bound: float | None
    torque: float | None
    refused: str


def evaluate(
    drive: Drive,
    motion: Motion,
    quantities: Mapping[str, Quantity],
    model: int,
    hertz: float,
    torque: float | None,
) -> tuple[Candidate, dict[str, float]]:
    """The parts of the bound at one bandwidth.

    Parameters
    ----------
    drive : Drive
        With the best values.
    motion : Motion
    quantities : mapping of str to Quantity
    model : {1, 3, 4}
    hertz : float
        lambda/(2 pi) [Hz].
    torque : float or None
        Largest torque of the goals [N m].

    Returns
    -------
    candidate : Candidate
    shares : dict of str to float
        What each quantity adds [rad].
    """
    law = make_law(drive, motion, quantities, model, hertz)
    ideal = joined_loop(drive, drive, law, motion, torque, options=rig_options(drive, ideal=True))
    real = joined_loop(drive, drive, law, motion, torque)
    nominal = told(ideal, run(ideal), drive, drive, motion, rig_options(drive, ideal=True), 0)
    seen = told(real, run(real), drive, drive, motion, rig_options(drive), 0)
    none = dict.fromkeys(("theorem", "unmatched", "sensors", "bound", "torque"))
    empty = Candidate(model=model, bandwidth=hertz, refused="", **none)
    incomplete = nominal.incomplete or seen.incomplete
    sensors = sensor_bound(real)
    if incomplete or nominal.bound is None or sensors is None:
        why = incomplete or "the loop with encoders and filter is unstable"
        return replace(empty, refused=why), {}
    shares, deviation = unmatched_part(ideal, drive, quantities, nominal.error)
    if deviation is None:
        return replace(empty, refused="within its bounds the drive diverges, or a span goes slack"), {}
    excess = np.maximum(np.abs(nominal.error) - nominal.bound, 0.0)
    unmatched = deviation + excess
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
) -> tuple[dict[str, float], Array | None]:
    """How far each spring, damper and the load can move the error, true states, at either of its bounds.

    Parameters
    ----------
    loop : Loop
        With ideal sensors.
    drive : Drive
        With the best values.
    quantities : mapping of str to Quantity
    nominal : ndarray, shape (samples,)
        Error at the best values [rad].

    Returns
    -------
    shares : dict of str to float
        Largest deviation by quantity [rad].
    total : ndarray, shape (samples,), or None
        Sum of the deviations at every sample [rad]; None if a run ended early.
    """
    shares, total = {}, np.zeros(len(nominal))
    for name in UNMATCHED:
        if name not in quantities or quantities[name].low == quantities[name].high:
            continue
        largest = np.zeros(len(nominal))
        for value in quantities[name].outer:
            moved = with_values(loop, drive, {name: value}, None)
            done = run(moved)
            if done.failed:
                return {}, None
            error = (done.log[:, moved.chain.size - 1] - moved.target) / moved.gear
            largest = np.maximum(largest, np.abs(error - nominal))
        shares[name] = float(largest.max())
        total += largest
    return shares, total
