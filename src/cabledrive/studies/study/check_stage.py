"""The drive, its data and the motion before any controller: what is odd, assumed, asked."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, isfinite, log10
from pathlib import Path

import numpy as np

from cabledrive.identification.logs.log import Log
from cabledrive.mechanics import drive_warnings
from cabledrive.mechanics.holding import left_out_under_torque
from cabledrive.modal.lowest import derived_with_lowest
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.reduction.quality import exact_frequencies
from cabledrive.rig.carriage import ORDER
from cabledrive.rig.laws.controllers import SHAFTS
from cabledrive.rig.setting import DEGREE, Motion
from cabledrive.rig.trial import check_way
from cabledrive.studies.study.carriage import MARGIN, missing_for_carriage
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import Demand, DemandResult, values_of
from cabledrive.studies.study.modes_stage import motion_torque
from cabledrive.trajectories import move_limits, shortest_rise


@dataclass(frozen=True, slots=True, kw_only=True)
class LogWords:
    """One log in short."""

    name: str
    sha256: str
    rows: int
    duration: float  # [s]
    sample_rate: float  # [Hz]
    channels: dict[str, str]  # SI unit by channel
    repaired: tuple[str, ...]
    findings: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckResult:
    """What the check found."""

    derived: dict[str, float | None]  # closed formulas of the datasheet, SI
    warnings: tuple[str, ...]  # warnings about the drive
    missing: tuple[str, ...]  # what a controller needs and the file does not give, with the remedy
    logs: tuple[LogWords, ...]


def check(drive: Drive, logs: Sequence[Log], hashes: Sequence[str]) -> CheckResult:
    """Check a drive and its logs; ``hashes``: SHA-256 of each log's file."""
    machine, slack = drive.axis.machine, len(drive.spans) * drive.drive_pulley.radius * drive.cable.pretension
    derived = derived_with_lowest(machine) | {"slack_torque": slack}
    more = drive.axis.words.get("sag"), left_out_under_torque(drive)
    return CheckResult(
        derived={k: v for k, v in derived.items() if v is None or isinstance(v, float)},
        warnings=(*drive_warnings(machine), *filter(None, more)),
        missing=missing_for_control(drive),
        logs=tuple(
            LogWords(
                name=Path(log.source).name,
                sha256=digest,
                duration=float(log.report.duration),
                sample_rate=float(log.sample_rate),
                channels=dict(log.units),
                **{name: getattr(log.report, name) for name in ("rows", "repaired", "findings")},
            )
            for log, digest in zip(logs, hashes, strict=True)
        ),
    )


def missing_for_control(drive: Drive) -> tuple[str, ...]:
    """What stands between a drive file and a controller; empty where a controller can be designed."""
    if drive.carriage:
        return missing_for_carriage(drive)
    found, sensors = [], drive.sensors
    if sensors is None or sensors.sample_rate is None:
        found.append('sensors.sample_rate is missing: give it, such as "5 kHz"')
    if sensors is not None and all(getattr(sensors, f"{shaft}_encoder") is None for shaft in SHAFTS[:2]):
        found.append("neither sensors.motor_encoder nor sensors.drive_encoder is given: fit one")
    if any(pulley.fixed for pulley in drive.pulley):
        found.append("a pulley is fixed: the controller stages need two rotating pulleys")
    return tuple(found)


ANGLE = 45.0 * DEGREE
"""Of a load pulley whose turn is not given [rad]."""
SLOWER = 2.0
"""Over the shortest move within the limits: feedback and uncertainty need the rest."""
PERIODS = 4.0
"""Of the lowest longitudinal mode, at least."""
STEPS = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
"""Durations are rounded up to one of these times a power of ten."""


def goals_for(drive: Drive, goals: Goals) -> Goals:
    """Goals whose motion is complete, what was assumed in `Goals.assumed`; carriage and pulley agree."""
    if drive.axis.slides:  # its lengths as the angles that they are over its gain
        gain, angle, error = abs(drive.axis.gain), goals.angle, goals.error
        if goals.travel is not None and angle is not None:
            raise InputRefused(f"travel and angle both give the way of {drive.axis.load}: leave one out")
        angle = angle if goals.travel is None else goals.travel / gain
        error = error if goals.carriage_error is None else goals.carriage_error / gain
        goals = replace(goals, gain=gain, angle=angle, error=error, travel=None, carriage_error=None)
    check_way(drive, goals.angle or 0.0)
    if drive.carriage and goals.error is not None:
        what = f"error = {goals.error / DEGREE:.4g} deg is an angle, and the drive has a carriage"
        raise InputRefused(f'{what}: state a length, such as error = "0.5 mm"')
    words = {"carriage_error": "error, a length,"}
    for name in ("travel", "carriage_error", "hanging_mass", "rail_friction"):
        if not drive.carriage and getattr(goals, name) is not None:
            what = f"{words.get(name, name)} refers to a carriage, but the drive has none"
            raise InputRefused(f"{what}: give the goal of the load")
    radius, assumed = drive.load_pulley.radius, []
    angle, travel = goals.angle, goals.travel
    if drive.carriage:
        start, length = drive.carriage[0].position, drive.span_length
        least, most = MARGIN * length, (1.0 - MARGIN) * length
        if travel is None and angle is not None:
            travel = angle * radius
        elif travel is None:  # rounded down to two digits
            left = 0.5 * (most - start if most > start else start - least)
            unit = 10.0 ** (floor(log10(left)) - 1)
            travel = float(f"{floor(left / unit) * unit:.2g}")
            assumed += [f"{travel:.4g} m, half of the remaining travel"]
        if not missing_for_carriage(drive) and not least < start < start + travel < most:
            raise InputRefused(
                f"travel = {travel:.4g} m takes the carriage from {start:.4g} m to {start + travel:.4g} m, "
                f"and {least:.4g} m to {most:.4g} m of its span are free: shorten the travel, or move the "
                "carriage"
            )
        angle = travel / radius
        goals = replace(goals, travel=travel, order=max(goals.order, ORDER))
    elif angle is None:
        way = "" if goals.gain is None else f", {1e3 * ANGLE * goals.gain:.4g} mm"
        angle, assumed = ANGLE, [f"{ANGLE / DEGREE:g} deg{way}"]
    duration = goals.duration
    if duration is None:
        duration, why = _duration(drive, angle, goals.order)
        assumed.append(f"{duration:g} s, {why}")
    said = f"motion assumed: {'; '.join(assumed)}" if assumed else ""
    return replace(goals, angle=angle, duration=duration, assumed=said)


def _duration(drive: Drive, angle: float, order: int) -> tuple[float, str]:
    """Duration of a move by limits and lowest mode [s], and which of them decides."""
    lowest = float(exact_frequencies(drive, 1)[0])
    by_mode = PERIODS / lowest
    mode_words = f"{PERIODS:g} periods of the lowest longitudinal mode, {lowest:.4g} Hz"
    try:
        shortest, binding = shortest_rise(move_limits(drive), angle, order)
    except (InputRefused, NotComputed):
        return _rounded_up(by_mode), f"{mode_words}; the file gives no limit that bounds the move"
    if SLOWER * shortest > by_mode:
        name = binding.replace("_", " ")
        return _rounded_up(SLOWER * shortest), f"{SLOWER:g} times the shortest move, {name} decides"
    return _rounded_up(by_mode), mode_words


def _rounded_up(duration: float) -> float:
    power = 10.0 ** floor(log10(duration))
    step = next(one for one in STEPS if one >= ceil(duration / power * 1e9 - 1.0) / 1e9)
    return float(f"{step * power:.3g}")


def demand_of(drive: Drive, motion: Motion, most: tuple[float | None, float | None]) -> DemandResult:
    """What a motion asks of a drive; ``most``: torque of the goals, and at which the rope slides [N m]."""
    limits, (torque, slides) = move_limits(drive), most
    limits = limits if torque is None else replace(limits, torque=min(limits.torque, torque))
    _, along = motion_torque(drive, motion)
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    through = values_of(drive)["load_inertia"] / gear * motion.trajectory.peak(2)
    asked = {"torque": (np.abs(along).max(), "N m"), "speed": (motion.trajectory.peak(1), "rad/s")}
    asked |= {"slack_torque": (through, "N m")} if drive.closed else {}
    ends = {name: float(getattr(limits, name)) for name in asked}
    if slides is not None:
        asked["slip_torque"], ends["slip_torque"] = (through, "N m"), slides
    found = tuple(
        Demand(name=name, asked=float(most), limit=ends[name] if isfinite(ends[name]) else None, unit=unit)
        for name, (most, unit) in asked.items()
    )
    try:
        shortest, binding = shortest_rise(limits, motion.angle * DEGREE, motion.rise_order)
    except (InputRefused, NotComputed) as failure:
        return DemandResult(demands=found, shortest=None, binding=str(failure))
    if slides is not None and (longer := motion.rise * (through / slides) ** 0.5) > shortest:
        shortest, binding = longer, "slip_torque"
    return DemandResult(demands=found, shortest=shortest, binding=binding)
