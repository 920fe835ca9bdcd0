"""What logs identify of the springs: the cable by the load's own equation, the motor joint by its twist."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, factor, joined, solve, suited_segments
from cabledrive.identification.two_sides import SIGN_BANDS, Solution
from cabledrive.parameters import Drive
from cabledrive.studies.study.machine import LOAD_FRICTIONS, values_of

Array = NDArray[np.float64]
Interval = tuple[float, float, float]

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


def around(name: str, value: float, half: float) -> tuple[float, float, float]:
    """A value with its bounds, never narrower than `LEAST`."""
    half = max(half, LEAST.get(name, 0.0) * abs(value))
    return value, value - half, value + half


def identify_cable(load: Solution | None, drive: Drive, found: dict[str, Interval]) -> dict[str, Interval]:
    """Stiffness and damping of a span and friction of the load, from the load's equation and inertia.

    ``found``: what the sum of torques gave.
    Returns value and bounds of what could be identified.
    """
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


def identify_joint(
    logs: Sequence[Log], drive: Drive, found: dict[str, tuple[float, float, float]]
) -> dict[str, tuple[float, float, float]]:
    """Stiffness and damping of the joint: its twist against the torque that passes it.

    ``found``: what the sum of torques gave.
    Returns value and bounds of what could be identified.
    """
    if any("drive_angle" not in log.channels for log in logs):
        return {}
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    behind = found["near_inertia"][0] * (1.0 - values_of(drive)["motor_share"])
    rubbed = {name: found.get(name, (0.0,))[0] for name in LOAD_FRICTIONS}
    values = []
    for band in (JOINT_BAND, 0.6 * JOINT_BAND, 1.5 * JOINT_BAND):
        parts = [_twist_rows(log, behind, found["load_inertia"][0], rubbed, gear, band) for log in logs]
        fit = solve(suited_segments(joined(parts)))
        values.append((fit.values, fit.half_width()))
    compliance = np.array([v[0] for v, _ in values])
    half = values[0][1][0] + np.max(np.abs(compliance - compliance[0]))
    if compliance[0] <= 0.0 or half > 0.3 * compliance[0]:
        return {}
    free = np.array([2.0 * v[3] for v, _ in values])
    half_free = 2.0 * float(values[0][1][3]) + float(np.max(np.abs(free - free[0])))
    stiffness = 1.0 / float(compliance[0])
    relative = float(half / compliance[0])
    result = {"joint_stiffness": around("joint_stiffness", stiffness, stiffness * relative)}
    play = around("backlash", float(free[0]), half_free)
    result["backlash"] = (0.0, 0.0, 0.0) if play[2] < _fine(drive) else play
    dampings = np.array([-v[1] for v, _ in values]) * stiffness**2
    rub = float(values[0][1][1] * stiffness**2 + np.max(np.abs(dampings - dampings[0])))
    if dampings[0] > 0.0 and rub < 0.5 * dampings[0]:
        result["joint_damping"] = around("joint_damping", float(dampings[0]), rub)
    return result


def _fine(drive: Drive) -> float:
    """Backlash that is as good as none: a tenth of the coarser count beside the joint [rad]."""
    sensors = drive.sensors
    numbers = [] if sensors is None else [sensors.motor_encoder, sensors.drive_encoder]
    return max((0.2 * np.pi / number for number in numbers if number), default=0.0)


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
    quick = difference(zero_phase(log.channel("load_angle"), h, min(SIGN_BANDS * band, 0.4 / h)), h)
    sides = zero_phase(np.sign(quick), h, band)
    friction = rubbed["load_viscous_friction"] * speed + rubbed["load_coulomb_friction"] * sides
    torque = behind * twice(pulley) + (load * twice(end) + friction) / gear
    side = zero_phase(np.sign(torque), h, band)
    columns = np.column_stack([torque, difference(torque, h), np.ones(len(log)), side])
    step, edge = max(1, int(0.02 / (band * h))), int(2.0 / (band * h))
    part = slice(edge, len(log) - edge, step)
    return factor(columns[part], (motor - pulley)[part], ("compliance", "rate", "zero", "side"), 60)
