"""An identified axis against a log that it was not identified from: in open loop, followed, and crosswise."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.identification.axis_case import case_of
from cabledrive.identification.estimates import Identification
from cabledrive.identification.innovations import follow
from cabledrive.identification.logs.log import Log
from cabledrive.identification.loop_check import tracks_of
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, equation_for
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.reduction.friction_integration import integrate_rigid_axis

MODEL = "rigid-axis-coulomb"


@dataclass(frozen=True, slots=True, kw_only=True)
class Against:
    """What an identified axis does on another log."""

    source: str  # the other log
    # speed simulated under the other log's torque alone: root mean square of its error, "error", in "unit",
    # "relative" to that of the measured speed; or why there is none, "reason"
    open_loop: dict[str, Any]
    # with an observer that follows the angle: "torque_error", what it has to add to the measured torque
    # ("torque_unit"), "relative" to that; "error" of its prediction of the angle one sample ahead
    closed_loop: dict[str, Any]
    # by name of a parameter: "value", "other", from the other log alone, and whether the intervals of 95 %
    # overlap, "agrees"
    cross_test: dict[str, Any]

    def as_dict(self) -> dict[str, Any]:
        """As JSON gives it."""
        return {
            "source": self.source,
            "open_loop": self.open_loop,
            "closed_loop": self.closed_loop,
            "cross_test": self.cross_test,
        }


def against(found: Identification, alone: Identification, other: Log, options: AxisOptions) -> Against:
    """An identified axis on another log; ``alone``: what that log gives by itself.

    Raises `InputRefused` for another model than an axis with constant friction.
    """
    if found.model != MODEL or len(found.parameters) != 4:
        raise InputRefused(f"--against needs the model {MODEL}, not {found.model}: leave --model out")
    values = np.array([estimate.value for estimate in found.parameters.values()])
    if not np.all(np.isfinite(values)):
        raise InputRefused("--against needs every parameter of the axis, and the first log leaves one open")
    torque, position = channels_of(other, options)
    case = case_of(other, torque, position, equation_for([other], torque, position, options))
    way = other.units[position]
    moved, _ = integrate_rigid_axis(values, case.torque, case.interval, start=case.start, slope=0.0)
    speed, off = case.speed[case.inner], (case.filtered(moved) - case.speed)[case.inner]
    open_loop: dict[str, Any] = {"reason": "its motion diverges"}
    if np.all(np.isfinite(off)):
        open_loop = {"error": _rms(off), "unit": f"{way}/s", "relative": _rms(off) / _rms(speed)}
    try:
        run = follow(tracks_of([other], options)[0], values)
        edge = run.track.position.size // 20
        closed_loop: dict[str, Any] = {
            "error": _rms(run.run.innovation[edge:]),
            "unit": way,
            "torque_error": _rms(run.added[edge:]),
            "torque_unit": other.units[torque],
            "relative": _rms(run.added[edge:]) / _rms(run.track.torque),
        }
    except NotComputed as failure:
        closed_loop = {"reason": str(failure)}
    cross = {
        name: {
            "value": estimate.value,
            "other": alone.parameters[name].value,
            "unit": estimate.unit,
            "agrees": bool(
                estimate.low <= alone.parameters[name].high and alone.parameters[name].low <= estimate.high
            ),
        }
        for name, estimate in found.parameters.items()
        if name in alone.parameters
    }
    return Against(source=other.source, open_loop=open_loop, closed_loop=closed_loop, cross_test=cross)


def words_of(found: Against) -> Sequence[str]:
    """The same for people."""
    lines = ["", f"against {found.source}:"]
    for title, part, more in (
        ("open loop", found.open_loop, "of the speed"),
        ("followed", found.closed_loop, "of the torque is added"),
    ):
        if "reason" in part:
            lines.append(f"  {title:<10} {part['reason']}")
        else:
            error = f"{part['error']:.3g} {part['unit']}"
            lines.append(f"  {title:<10} {100 * part['relative']:.2g} % {more}; error {error}")
    for name, one in found.cross_test.items():
        state = "agrees" if one["agrees"] else "intervals apart"
        words = f"{one['value']:.4g}, by itself {one['other']:.4g} {one['unit']}"
        lines.append(f"  {name.replace('_', ' '):<20} {words}: {state}")
    return lines


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
