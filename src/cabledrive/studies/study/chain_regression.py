"""What logs of the whole drive identify: motor, friction, load, and the springs between them.

The sum of torques and the load's own equation are those of `cabledrive.identification.two_sides`; the twist
of the joint is the torque that passes it over its stiffness.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.identification import estimates, two_sides
from cabledrive.identification.estimates import Factors
from cabledrive.identification.logs.log import Log
from cabledrive.identification.rope_friction import Slip, without_slip
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.studies.study.machine import FRICTIONS, LOAD_FRICTIONS, SIGNED, has_flexible_joint, values_of
from cabledrive.studies.study.sampled_plants import Correlation, Interval, of_intervals

LEAST = {
    "near_inertia": 0.002,
    "load_inertia": 0.002,
    "cable_stiffness": 0.002,
    "cable_damping": 0.02,
    "joint_stiffness": 0.03,
    "joint_damping": 0.2,
    "backlash": 0.25,
}
"""Narrowest relative half widths: what the equations leave out, such as the mass of the cable."""

JOINT_BAND = 40.0
CERTAIN = 0.05
"""Largest relative half width with which a stiffness counts as identified."""


def around(name: str, value: float, half: float) -> Interval:
    """A value with its bounds, never narrower than `LEAST`."""
    half = max(half, LEAST.get(name, 0.0) * abs(value))
    return value, value - half, value + half


def identify_cable(
    load: two_sides.Solution | None, drive: Drive, found: dict[str, Interval]
) -> dict[str, Interval]:
    """Value and bounds of a span's stiffness, damping and the load's friction, from the load's equation."""
    if load is None or "load_inertia" not in found:
        return {}
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    radius, spans = drive.drive_pulley.radius, len(drive.spans)
    inertia, low, high = found["load_inertia"]
    spread = 0.5 * (high - low) / inertia
    result = {}
    for name, unit in (("viscous", inertia), ("coulomb", inertia / gear)):
        value, half = load.of(name)
        whole = abs(value) * spread + half
        result[f"load_{name}_friction"] = (unit * value, unit * (value - whole), unit * (value + whole))
    beta, half = load.of("beta")
    if beta <= 0.0 or half > CERTAIN * beta:
        return result
    stiffness = beta * inertia / gear**2 / (spans * radius**2)
    result["cable_stiffness"] = around("cable_stiffness", stiffness, stiffness * (spread + half / beta))
    gamma, half = load.of("gamma")
    if gamma > 0.0 and half < 0.5 * gamma:
        damping = gamma * inertia / gear**2 / (spans * radius)
        result["cable_damping"] = around("cable_damping", damping, damping * (spread + half / gamma))
    return result


def identify_joint(logs: Sequence[Log], drive: Drive, found: dict[str, Interval]) -> dict[str, Interval]:
    """Value and bounds of the joint's stiffness and damping: its twist against the torque that passes it."""
    if any("drive_angle" not in log.channels for log in logs):
        return {}
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    behind = found["near_inertia"][0] * (1.0 - values_of(drive)["motor_share"])
    rubbed = {name: found.get(name, (0.0,))[0] for name in LOAD_FRICTIONS}
    fits = []
    for band in (JOINT_BAND, 0.6 * JOINT_BAND, 1.5 * JOINT_BAND):
        parts = [_twist_rows(log, behind, found["load_inertia"][0], rubbed, gear, band) for log in logs]
        fits.append(estimates.solve(estimates.suited_segments(estimates.joined(parts))))
    values, own = np.array([fit.values for fit in fits]), fits[0].half_width()
    compliance, *_, side = values[0].tolist()
    halves = (own + np.abs(values - values[0]).max(axis=0)).tolist()  # with what the filter moves
    if compliance <= 0.0 or halves[0] > 0.3 * compliance:
        return {}
    stiffness = 1.0 / compliance
    result = {"joint_stiffness": around("joint_stiffness", stiffness, stiffness * (halves[0] / compliance))}
    play = around("backlash", 2.0 * side, 2.0 * halves[3])
    sensors = drive.sensors
    numbers = [] if sensors is None else [sensors.motor_encoder, sensors.drive_encoder]
    # A tenth of the coarser count beside the joint is as good as none.
    fine = max((0.2 * np.pi / number for number in numbers if number), default=0.0)
    result["backlash"] = (0.0, 0.0, 0.0) if play[2] < fine else play
    dampings = -values[:, 1] * stiffness**2
    rub = float(own[1] * stiffness**2 + np.max(np.abs(dampings - dampings[0])))
    if dampings[0] > 0.0 and rub < 0.5 * dampings[0]:
        result["joint_damping"] = around("joint_damping", float(dampings[0]), rub)
    return result


def _twist_rows(
    log: Log, behind: float, load: float, rubbed: Mapping[str, float], gear: float, band: float
) -> Factors:
    """Twist = torque / k - (b / k^2) torque's rate + zeros of the encoders + half the play, by the side."""
    h = log.interval
    band = min(band, 0.1 / h)

    def smooth(name: str) -> Array:
        return zero_phase(log.channel(name), h, band)

    def twice(values: Array) -> Array:
        return difference(difference(values, h), h)

    motor, pulley, end = smooth("angle"), smooth("drive_angle"), smooth("load_angle")
    speed = difference(end, h)
    quick = difference(zero_phase(log.channel("load_angle"), h, min(two_sides.SIGN_BANDS * band, 0.4 / h)), h)
    sides = zero_phase(np.sign(quick), h, band)
    friction = rubbed["load_viscous_friction"] * speed + rubbed["load_coulomb_friction"] * sides
    torque = behind * twice(pulley) + (load * twice(end) + friction) / gear
    side = zero_phase(np.sign(torque), h, band)
    columns = np.column_stack([torque, difference(torque, h), np.ones(len(log)), side])
    step, edge = max(1, int(0.02 / (band * h))), int(2.0 / (band * h))
    part = slice(edge, len(log) - edge, step)
    return estimates.factor(columns[part], (motor - pulley)[part], ("compliance", "rate", "zero", "side"), 60)


SPLITS = (-0.1, 0.1)
"""By how much the motor's share of the inertia before the cable may be off."""
MAY_BE_NONE = (*FRICTIONS, *LOAD_FRICTIONS, "backlash")
CHANNELS = ("torque", "angle", "load_angle")
NAMES = ("near_inertia", "load_inertia", "viscous_friction", "coulomb_friction", "offset_torque")


@dataclass(frozen=True, slots=True, kw_only=True)
class RegressionResult:
    """What logs say of some quantities."""

    # Value, lower and upper bound of what could be identified
    intervals: dict[str, Interval]
    correlations: tuple[Correlation, ...]
    undetermined: tuple[str, ...]  # what could not, in words
    # what came out negative by more than its interval, so that signs or units are wrong
    negative: tuple[str, ...]
    # residual, residual_torque: of the sum of torques, relative to the torque and as it is [N m], below the
    # filter's bandwidth
    residual: float
    residual_torque: float
    # by how much the angles are later than the torque as logged [s]; half a sample where a controller holds
    # its torque from the sample at which it is logged. It is taken out before anything else is solved
    lag: float
    kept: float  # share of the samples that could be used
    cogging: two_sides.Cogging | None  # what of the torque repeats with the motor's angle, taken out as well
    slip: Slip | None  # of the rope on its pulley, taken out of the twist


def whole_drive(log: Log) -> bool:
    """Whether a log shows torque, motor and load."""
    return all(name in log.channels for name in CHANNELS)


def identify_chain(logs: Sequence[Log], drive: Drive) -> RegressionResult:
    """Identify a whole drive from logs that show motor and load."""
    for log in logs:
        for name in CHANNELS:
            if np.ptp(log.channel(name)) == 0.0:
                raise InputRefused(f"{log.source}: {name} is constant: a log must move the drive")
    joint, ratio = has_flexible_joint(drive), drive.load_pulley.radius / drive.drive_pulley.radius
    sides, slip = without_slip(
        [
            two_sides.TwoSides(  # a log at the first shaft
                source=log.source,
                interval=log.interval,
                torque=log.channel("torque"),
                motor=log.channel("angle"),
                load=log.channel("load_angle") * ratio,
                pulley=log.channels.get("drive_angle") if joint else None,
                share=values_of(drive).get("motor_share", 1.0),
                twisted=not joint or "drive_angle" in log.channels,
                saturated=log.saturated.get("torque"),
            )
            for log in logs
        ]
    )
    load = two_sides.load_equation(sides)
    solution, sides, lag = two_sides.sum_equation(sides, load)
    scale = np.array([1.0, ratio**2, 1.0, 1.0, 1.0])
    fit, n = solution.fit, len(NAMES)  # in the quantities of a drive, without the lag
    middle = replace(
        fit,
        names=NAMES,
        values=fit.values[:n] * scale,
        covariance=fit.covariance[:n, :n] * np.outer(scale, scale),
        unidentifiable=fit.unidentifiable[:, :n] * scale,
    )
    halves = solution.halves[:n] * scale
    if joint:  # what another share of the motor in the inertia before the cable moves
        others = [
            two_sides.sum_at([replace(one, share=one.share + split) for one in sides], load, solution.band)
            for split in SPLITS
        ]
        halves += np.nanmax(np.abs(np.array(others) - solution.fit.values), axis=0)[:n] * scale
    sizes = solution.sizes[: len(NAMES)] / scale
    unidentifiable = estimates.unidentifiable_parameters(middle)
    found = {
        name: around(name, float(value), float(half))
        for name, value, half in zip(NAMES, middle.values, halves, strict=True)
        if name not in unidentifiable
    }
    weak = estimates.weak_parameters(middle, halves, sizes) & found.keys()
    words = estimates.unidentifiable_words(middle)
    words += tuple(estimates.weak_words(name) for name in found if name in weak)
    found = {name: interval for name, interval in found.items() if name not in weak}
    sums = found
    found, negative = _possible(sums)
    words += negative
    result, negative = _possible(identify_cable(load, drive, found))
    found |= result
    words += negative
    if "cable_stiffness" not in found and "load_inertia" in found:
        words += ("the cable's stiffness is not determined: the load never turns against the drive pulley",)
    if joint and {"near_inertia", "load_inertia"} <= set(found):
        result, negative = _possible(identify_joint(logs, drive, found))
        found |= result
        words += negative
        if "joint_stiffness" not in found:
            why = "its twist is within the encoders' counts"
            words += (f"the motor joint's stiffness is not determined: {why}",)
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
        cogging=sides[0].cogging,
        slip=slip,
    )


def explained(log: Log, result: RegressionResult, drive: Drive, number: int) -> Log:
    """The log of a ``number`` at the instants at which angles were read, without cogging and creep."""
    torque = np.interp(log.time - result.lag, log.time, log.channel("torque"))
    if result.cogging is not None:
        torque -= result.cogging.at(log.channel("angle"))
    load = log.channel("load_angle")
    if result.slip is not None:
        load = load + result.slip.paths[number] * drive.drive_pulley.radius / drive.load_pulley.radius
    return replace(log, channels={**log.channels, "torque": torque, "load_angle": load})


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
