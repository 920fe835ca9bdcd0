r"""What logs of the whole drive identify: motor, friction and load from the sum of torques, cable and joint.

With the angles of all shafts measured, the sum of the equations of motion holds no spring,

.. math:: \tau = J_1\ddot\theta_1 + J_2 g\,\ddot\theta_2 + b\dot\theta_1 + c\,\mathrm{sgn}\,\dot\theta_1 - d ,

the load's own equation no torque, and the twist of the joint is the torque that passes it over its stiffness.
Each is solved with filters of several bandwidths; an interval covers what that choice moves.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.identifiability import (
    unidentifiable_parameters,
    unidentifiable_words,
    weak_words,
)
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, Fit, factor, joined, solve, suited_segments
from cabledrive.parameters import Drive, InputRefused
from cabledrive.studies.study.correlations import Correlation, Interval, of_intervals
from cabledrive.studies.study.machine import FRICTIONS, LOAD_FRICTIONS, SIGNED, has_flexible_joint, values_of
from cabledrive.studies.study.spring_regression import (
    LoadFits,
    around,
    identify_cable,
    identify_joint,
    load_fits,
    moving,
    quick_speed,
)

Array = NDArray[np.float64]

BANDWIDTHS = (10.0, 15.0, 22.0)
SPLITS = (-0.1, 0.0, 0.1)
MAY_BE_NONE = (*FRICTIONS, *LOAD_FRICTIONS, "backlash")
SEGMENTS = 120
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
    load = load_fits(logs, drive)
    lag = torque_lag(logs, drive, load)
    logs = [with_torque_at(log, lag) for log in logs]
    fits = list(_fits(logs, drive, load))
    middle, sizes, kept = fits[0]
    unidentifiable = unidentifiable_parameters(middle)
    found = {name: _interval(name, fits) for name in NAMES if name not in unidentifiable}
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
        kept=kept,
    )


def torque_lag(logs: Sequence[Log], drive: Drive, load: LoadFits | None) -> float:
    """By how much the angles are later than the torque, from the sum of torques with the torque's rate.

    Returns [s].
    """
    rubs = (load.of("viscous")[0], load.of("coulomb")[0]) if load is not None else (0.0, 0.0)
    share = values_of(drive).get("motor_share", 1.0)
    parts = [_sum_rows(log, drive, BANDWIDTHS[1], share, rubs, lag=True)[0] for log in logs]
    return float(solve(suited_segments(joined(parts))).values[-1])


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


def _fits(logs: Sequence[Log], drive: Drive, load: LoadFits | None) -> Iterator[tuple[Fit, Array, float]]:
    """The sum of torques and the size of each regressor; middle band and the drive's own split first."""
    share = values_of(drive).get("motor_share", 1.0)
    rubs = (load.of("viscous")[0], load.of("coulomb")[0]) if load is not None else (0.0, 0.0)
    order = (1, 0, 2)
    for band in order:
        for split in order:
            if split != 1 and not has_flexible_joint(drive):
                continue
            parts = [_sum_rows(log, drive, BANDWIDTHS[band], share + SPLITS[split], rubs) for log in logs]
            kept = sum(part.rows for part, _ in parts) / sum(total for _, total in parts)
            factors = joined([part for part, _ in parts])
            squares = (factors.triangles**2).sum(axis=(0, 1))[:-1]
            yield solve(suited_segments(factors)), np.sqrt(squares / factors.rows), float(kept)


def _sum_rows(
    log: Log, drive: Drive, band: float, share: float, rubs: tuple[float, float], *, lag: bool = False
) -> tuple[Factors, int]:
    """Rows of the sum of torques; ``rubs`` is the load's friction over its inertia, of its own speed."""
    h = log.interval
    band = min(band, 0.1 / h)
    near = zero_phase(log.channel("angle"), h, band)
    speed = difference(near, h)
    acceleration = difference(speed, h)
    if "drive_angle" in log.channels and has_flexible_joint(drive):
        pulley = zero_phase(log.channel("drive_angle"), h, band)
        acceleration = share * acceleration + (1.0 - share) * difference(difference(pulley, h), h)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    turned = difference(zero_phase(log.channel("load_angle"), h, band), h)
    quick = quick_speed(log.channel("angle"), h, band)
    sign = zero_phase(np.sign(quick), h, band)
    own = zero_phase(np.sign(quick_speed(log.channel("load_angle"), h, band)), h, band)
    load = difference(turned, h) + rubs[0] * (turned - speed / gear) + rubs[1] * (own - sign) / gear
    columns = np.column_stack([acceleration, load / gear, speed, sign, -np.ones(len(log))])
    keep, step = _usable(log, quick, band)
    if keep.sum() < 200:
        why = "little rotation, or saturated torque"
        raise InputRefused(
            f"{log.source}: {keep.sum()} samples can be used ({why}): record again, move it more"
        )
    segments = max(12, min(SEGMENTS, int(keep.sum()) // 20))
    left = zero_phase(log.channel("torque"), h, band)
    names: tuple[str, ...] = NAMES
    if lag:
        columns, names = np.column_stack([columns, difference(left, h)]), (*NAMES, "lag")
    return factor(columns[keep], left[keep], names, segments), len(log) // step


def _usable(log: Log, quick: Array, band: float) -> tuple[NDArray[np.bool_], int]:
    """Rows away from the ends, from standstill and from saturation, thinned to what the filter leaves."""
    h = log.interval
    sure = moving(quick, h, band)
    if "torque" in log.saturated:
        reach = max(3, int(0.5 / (band * h)))
        sure &= np.convolve(log.saturated["torque"], np.ones(reach), "same") <= 0.5
    step = max(1, int(0.02 / (band * h)))
    keep = sure & (np.arange(len(log)) % step == 0)
    edge = int(2.0 / (band * h))
    keep[:edge] = keep[max(len(log) - edge, 0) :] = False
    return keep, step


def _interval(name: str, fits: Sequence[tuple[Fit, Array, float]]) -> tuple[float, float, float]:
    """Value at the middle bandwidth; bounds that hold the others' and a residual that hides in it alone."""
    place = NAMES.index(name)
    values = np.array([fit.values[place] for fit, _, _ in fits])
    first, sizes, _ = fits[0]
    hidden = first.residual / sizes[place] if sizes[place] > 0.0 else 0.0
    moved = float(first.half_width()[place] + np.max(np.abs(values - values[0])))
    return around(name, float(values[0]), moved + float(hidden))


def _is_weak(name: str, interval: tuple[float, float, float], sizes: Array, fit: Fit) -> bool:
    value, low, high = interval
    half = 0.5 * (high - low)
    return bool(half > abs(value) and half * sizes[NAMES.index(name)] > WEAK_SHARE * fit.scale)
