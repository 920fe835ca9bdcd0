r"""What logs of the whole drive identify: motor, friction and load from the sum of torques, cable and joint.

The sum of torques and the load's own equation are those of `cabledrive.identification.two_sides`; the twist
of the joint is the torque that passes it over its stiffness.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.identifiability import (
    unidentifiable_parameters,
    unidentifiable_words,
    weak_words,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Fit
from cabledrive.identification.two_sides import (
    Solution,
    TwoSides,
    load_equation,
    sum_at,
    sum_equation,
)
from cabledrive.parameters import Drive, InputRefused
from cabledrive.studies.study.correlations import Correlation, Interval, of_intervals
from cabledrive.studies.study.machine import FRICTIONS, LOAD_FRICTIONS, SIGNED, has_flexible_joint, values_of
from cabledrive.studies.study.spring_regression import around, identify_cable, identify_joint

Array = NDArray[np.float64]

SPLITS = (-0.1, 0.1)
"""By how much the motor's share of the inertia before the cable may be off."""
MAY_BE_NONE = (*FRICTIONS, *LOAD_FRICTIONS, "backlash")
WEAK_SHARE = 0.1
"""Share of the torque that an uncertainty as large as its parameter must make to count as not determined."""

CHANNELS = ("torque", "angle", "load_angle")
NAMES = ("near_inertia", "load_inertia", "viscous_friction", "coulomb_friction", "offset_torque")


@dataclass(frozen=True, slots=True, kw_only=True)
class RegressionResult:
    """What logs say of some quantities.

    Attributes
    ----------
    intervals : dict of str to (float, float, float)
        Value, lower and upper bound of what could be identified.
    correlations : tuple of Correlation
    undetermined : tuple of str
        What could not, in words.
    negative : tuple of str
        What came out negative by more than its interval, so that signs or units are wrong.
    residual, residual_torque : float
        Of the sum of torques, relative to the torque and as it is [N m], below the filter's bandwidth.
    lag : float
        By how much the angles are later than the torque as logged [s]; half a sample where a controller holds
        its torque from the sample at which it is logged. It is taken out before anything else is solved.
    kept : float
        Share of the samples that could be used.
    """

    intervals: dict[str, tuple[float, float, float]]
    correlations: tuple[Correlation, ...]
    undetermined: tuple[str, ...]
    negative: tuple[str, ...]
    residual: float
    residual_torque: float
    lag: float
    kept: float


def whole_drive(log: Log) -> bool:
    """Whether a log shows torque, motor and load."""
    return all(name in log.channels for name in CHANNELS)


def identify_chain(logs: Sequence[Log], drive: Drive) -> RegressionResult:
    """Identify a whole drive from logs that show motor and load.

    ``logs``: for which `whole_drive` holds; ``drive``: for radii, and the split of the motor-side inertia
    between motor and drive pulley.
    Raises `InputRefused` if a channel stands still, or the logs are too short.
    """
    for log in logs:
        for name in CHANNELS:
            if np.ptp(log.channel(name)) == 0.0:
                raise InputRefused(f"{log.source}: {name} is constant: a log must move the drive")
    sides = [_sides(log, drive) for log in logs]
    load = load_equation(sides)
    solution, sides, lag = sum_equation(sides, load)
    scale = np.array([1.0, (drive.load_pulley.radius / drive.drive_pulley.radius) ** 2, 1.0, 1.0, 1.0])
    middle, halves = _of_the_drive(solution.fit, scale), solution.halves[: len(NAMES)] * scale
    halves += _by_the_split(sides, load, solution, drive) * scale
    sizes = solution.sizes[: len(NAMES)] / scale
    unidentifiable = unidentifiable_parameters(middle)
    found = {
        name: around(name, float(value), float(half))
        for name, value, half in zip(NAMES, middle.values, halves, strict=True)
        if name not in unidentifiable
    }
    weak = [name for name in found if _is_weak(name, found[name], sizes, middle)]
    words = unidentifiable_words(middle) + tuple(weak_words(name) for name in weak)
    found = {name: interval for name, interval in found.items() if name not in weak}
    sums = found
    found, negative = _possible(sums)
    words += negative
    result, negative = _possible(identify_cable(load, drive, found))
    found |= result
    words += negative
    if "cable_stiffness" not in found and "load_inertia" in found:
        words += ("the cable's stiffness is not determined: the load never turns against the drive pulley",)
    if has_flexible_joint(drive) and {"near_inertia", "load_inertia"} <= set(found):
        result, negative = _possible(identify_joint(logs, drive, found))
        found |= result
        words += negative
        if "joint_stiffness" not in found:
            words += (
                "the motor joint's stiffness is not determined: its twist is within the encoders' counts",
            )
    residual = middle.residual / middle.scale if middle.scale else 1.0
    return RegressionResult(
        intervals=found,
        correlations=of_intervals(middle, found),
        undetermined=words,
        negative=tuple(name for name in sums if name not in found),
        residual=float(residual),
        residual_torque=float(middle.residual),
        lag=lag,
        kept=solution.kept,
    )


def with_torque_at(log: Log, lag: float) -> Log:
    """A log whose torque is that of the instants at which its angles were read.

    ``lag`` [s].
    """
    torque = np.interp(log.time - lag, log.time, log.channel("torque"))
    return replace(log, channels={**log.channels, "torque": torque})


def _possible(found: dict[str, Interval]) -> tuple[dict[str, Interval], tuple[str, ...]]:
    """What a machine can have of what was identified, and words about the negative numbers among it."""
    kept: dict[str, Interval] = {}
    words: tuple[str, ...] = ()
    for name, (value, low, high) in found.items():
        rubs, said = name in MAY_BE_NONE, name.replace("_", " ")
        if value > 0.0 or name in SIGNED or (rubs and value == 0.0):
            kept[name] = value, low, high
        elif rubs and high > 0.0:
            kept[name] = 0.0, low, high
            if name in FRICTIONS:
                words += (f"{said} is identified as negative, by less than its interval: taken as 0",)
        else:
            words += (f"{said} is identified as negative: check signs and units",)
    return kept, words


def _sides(log: Log, drive: Drive) -> TwoSides:
    """A log at the first shaft."""
    joint = has_flexible_joint(drive)
    return TwoSides(
        source=log.source,
        interval=log.interval,
        torque=log.channel("torque"),
        motor=log.channel("angle"),
        load=log.channel("load_angle") * (drive.load_pulley.radius / drive.drive_pulley.radius),
        pulley=log.channels.get("drive_angle") if joint else None,
        share=values_of(drive).get("motor_share", 1.0),
        twisted=not joint or "drive_angle" in log.channels,
        saturated=log.saturated.get("torque"),
    )


def _of_the_drive(fit: Fit, scale: Array) -> Fit:
    """The sum of torques in the quantities of a drive, without the lag."""
    count = len(NAMES)
    return replace(
        fit,
        names=NAMES,
        values=fit.values[:count] * scale,
        covariance=fit.covariance[:count, :count] * np.outer(scale, scale),
        unidentifiable=fit.unidentifiable[:, :count] * scale,
    )


def _by_the_split(
    sides: Sequence[TwoSides], load: Solution | None, solution: Solution, drive: Drive
) -> Array:
    """What another share of the motor in the inertia before the cable moves, shape (5,)."""
    if not has_flexible_joint(drive):
        return np.zeros(len(NAMES))
    others = [
        sum_at([replace(one, share=one.share + split) for one in sides], load, solution.band)
        for split in SPLITS
    ]
    return np.asarray(np.nanmax(np.abs(np.array(others) - solution.fit.values), axis=0)[: len(NAMES)])


def _is_weak(name: str, interval: tuple[float, float, float], sizes: Array, fit: Fit) -> bool:
    value, low, high = interval
    half = 0.5 * (high - low)
    return bool(half > abs(value) and half * sizes[NAMES.index(name)] > WEAK_SHARE * fit.scale)
