"""An identified axis against logs: its modelling error over time, another log in open loop and followed."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cabledrive.identification.axis.axis import AxisOptions, axis_of, channels_of
from cabledrive.identification.axis.equation import direction_of
from cabledrive.identification.axis.observer import observed
from cabledrive.identification.axis.simulated import case_of
from cabledrive.identification.estimates import Identification
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import causal_filter, difference, ideal_low_pass
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array

MODEL = "rigid-axis-coulomb"
FILTER = 20.0
"""Natural frequency of the causal filter [Hz], as section 4.2.1 has it; damping 1."""
IDEAL = 50.0
"""Cutoff of the ideal low-pass for speed and acceleration [Hz], as section 4.2.1 has it."""
RESTING = 0.02
"""Share of the speed's size below which an axis counts as at rest."""


def against(found: Identification, alone: Identification, other: Log, options: AxisOptions) -> dict[str, Any]:
    """An identified axis on another log, as JSON gives it; ``alone``: what that log gives by itself.

    "open_loop": error of the speed simulated under the other log's torque alone; "closed_loop": with an
    observer that follows the angle, what it has to add to the measured torque, "torque_error", and the error
    of its prediction of the angle one sample ahead; "cross_test": by name of a parameter, whether intervals
    overlap. Raises `InputRefused` for another model than an axis with constant friction.
    """
    if found.model != MODEL or len(found.parameters) != 4:
        raise InputRefused(f"--against needs the model {MODEL}, not {found.model}: leave --model out")
    if not np.all(np.isfinite(found.values)):
        raise InputRefused("--against needs every parameter of the axis, and the first log leaves one open")
    axis = axis_of([other], options)
    case = replace(case_of(axis, other), slope=0.0)
    way = other.units[axis.position]
    moved, _ = case.moved(found.values, case.torque, case.start)
    speed, off = case.speed[case.inner], (case.filtered(moved) - case.speed)[case.inner]
    open_loop: dict[str, Any] = {"reason": "its motion diverges"}
    if np.all(np.isfinite(off)):
        open_loop = {"error": _rms(off), "unit": f"{way}/s", "relative": _rms(off) / _rms(speed)}
    try:
        seen = observed(axis, found.values, 1.0)
        (run,) = seen.runs(found.values)
        added = run.added[len(other) // 20 :]
        closed_loop: dict[str, Any] = {
            "error": _rms(run.innovation[len(other) // 20 :]),
            "unit": way,
            "torque_error": _rms(added),
            "torque_unit": other.units[axis.torque],
            "relative": _rms(added) / _rms(seen.tracks[0].torque),
        }
    except NotComputed as failure:
        closed_loop = {"reason": str(failure)}
    pairs = ((name, one, alone.parameters.get(name)) for name, one in found.parameters.items())
    cross = {
        name: {
            "value": one.value,
            "other": its.value,
            "unit": one.unit,
            "agrees": bool(one.low <= its.high and its.low <= one.high),
        }
        for name, one, its in pairs
        if its is not None
    }
    return {
        "source": other.source,
        "open_loop": open_loop,
        "closed_loop": closed_loop,
        "cross_test": cross,
    }


def words_of(found: Mapping[str, Any]) -> list[str]:
    """The same for people."""
    lines = ["", f"against {found['source']}:"]
    for title, key, more in (
        ("open loop", "open_loop", "of the speed"),
        ("followed", "closed_loop", "of the torque is added"),
    ):
        part = found[key]
        if "reason" in part:
            lines.append(f"  {title:<10} {part['reason']}")
        else:
            error = f"{part['error']:.3g} {part['unit']}"
            lines.append(f"  {title:<10} {100 * part['relative']:.2g} % {more}; error {error}")
    for name, one in found["cross_test"].items():
        state = "agrees" if one["agrees"] else "intervals apart"
        words = f"{one['value']:.4g}, by itself {one['other']:.4g} {one['unit']}"
        lines.append(f"  {name.replace('_', ' '):<20} {words}: {state}")
    return lines


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def regressor_curves(log: Log, found: Identification, options: AxisOptions) -> tuple[Array, Array, Array]:
    r"""Acceleration, speed and friction regressor of an identified axis, and its modelling error (4.9).

    The regressors by differences and the ideal low-pass, and through the causal filter (4.1), each
    (3, samples); the error :math:`[\ddot\theta,\ \dot\theta,\ S(\dot\theta),\ -1]\,P - \tau`, (samples,).
    """
    kind = found.model.removeprefix("rigid-axis-")
    if kind not in ("coulomb", "tanh") or not found.identifiable:
        raise InputRefused(f"{found.model}: curves are drawn of identified axes with one Coulomb friction")
    torque, position = (log.channel(name) for name in channels_of(log, options))
    interval = log.interval
    cutoff, natural = min(IDEAL, 0.2 / interval), min(FILTER, 0.1 / interval)
    speed = ideal_low_pass(difference(position, interval), interval, cutoff)
    acceleration = ideal_low_pass(difference(difference(position, interval), interval), interval, cutoff)
    if kind == "tanh":
        friction = np.tanh(options.friction.slope * speed)
    else:
        friction = direction_of(speed, RESTING * float(np.sqrt(np.mean(speed**2))))
    unfiltered = np.array([acceleration, speed, friction])
    _, slow, slower = causal_filter(position, interval, natural)
    filtered = np.array([slower, slow, causal_filter(friction, interval, natural)[0]])
    return unfiltered, filtered, found.values[:3] @ unfiltered - found.values[3] - torque
