"""What logs tell of the springs: the cable by the load's own equation, the motor joint by its twist."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.logs.log import Log
from cabledrive.identification.regression import Factors, factor, joined, solve, suited_segments
from cabledrive.parameters import Drive
from cabledrive.studies.study.machine import has_flexible_joint, values_of

Array = NDArray[np.float64]

LEAST = {
    "near_inertia": 0.002,
    "load_inertia": 0.002,
    "cable_stiffness": 0.002,
    "cable_damping": 0.02,
    "joint_stiffness": 0.03,
    "joint_damping": 0.2,
}
"""Narrowest relative half widths: what the equations leave out, such as the mass of the cable."""

JOINT_BAND = 40.0
LOAD_BANDS = (15.0, 10.0, 22.0)
CERTAIN = 0.05
"""Largest relative half width with which a stiffness counts as told."""


def around(name: str, value: float, half: float) -> tuple[float, float, float]:
    """A value with its bounds, never narrower than `LEAST`.

    Parameters
    ----------
    name : str
    value, half : float

    Returns
    -------
    value, low, high : float
    """
    half = max(half, LEAST.get(name, 0.0) * abs(value))
    return value, value - half, value + half


def tell_cable(
    logs: Sequence[Log], drive: Drive, found: dict[str, tuple[float, float, float]]
) -> dict[str, tuple[float, float, float]]:
    """Stiffness and damping of a span, from the load's own equation and the load's inertia.

    Parameters
    ----------
    logs : sequence of Log
    drive : Drive
    found : dict of str to (float, float, float)
        What the sum of torques told.

    Returns
    -------
    dict of str to (float, float, float)
        Value and bounds of what could be told.
    """
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    radius, spans = drive.drive_pulley.radius, len(drive.spans)
    near = "drive_angle" if all("drive_angle" in log.channels for log in logs) else "angle"
    if "load_inertia" not in found or (near == "angle" and has_flexible_joint(drive)):
        return {}
    fits = [
        solve(suited_segments(joined([_load_rows(log, near, gear, band) for log in logs])))
        for band in LOAD_BANDS
    ]
    values = np.array([fit.values for fit in fits])
    if values[0, 0] <= 0.0 or fits[0].half_width()[0] > CERTAIN * values[0, 0]:
        return {}
    moved = (fits[0].half_width() + np.abs(values - values[0]).max(axis=0)) / np.maximum(
        np.abs(values[0]), 1e-300
    )
    inertia, low, high = found["load_inertia"]
    spread, beta, gamma = 0.5 * (high - low) / inertia, *values[0, :2]
    stiffness = float(beta * inertia / gear**2 / (spans * radius**2))
    told = {"cable_stiffness": around("cable_stiffness", stiffness, stiffness * float(spread + moved[0]))}
    if gamma > 0.0 and moved[1] < 0.5:
        damping = float(gamma * inertia / gear**2 / (spans * radius))
        told["cable_damping"] = around("cable_damping", damping, damping * float(spread + moved[1]))
    return told


def _load_rows(log: Log, near: str, gear: float, band: float) -> Factors:
    """The load's acceleration by twist and its rate; the constant takes the encoders' zeros."""
    h = log.interval
    band = min(band, 0.1 / h)
    first, load = (
        zero_phase(log.channel(near), h, band),
        gear * zero_phase(log.channel("load_angle"), h, band),
    )
    speed = difference(load, h)
    columns = np.column_stack([first - load, difference(first, h) - speed, np.ones(len(log))])
    step, edge = max(1, int(0.02 / (band * h))), int(2.0 / (band * h))
    part = slice(edge, len(log) - edge, step)
    return factor(columns[part], difference(speed, h)[part], ("beta", "gamma", "zero"), 60)


def tell_joint(
    logs: Sequence[Log], drive: Drive, found: dict[str, tuple[float, float, float]]
) -> dict[str, tuple[float, float, float]]:
    """Stiffness and damping of the joint: its twist against the torque that passes it.

    Parameters
    ----------
    logs : sequence of Log
    drive : Drive
    found : dict of str to (float, float, float)
        What the sum of torques told.

    Returns
    -------
    dict of str to (float, float, float)
        Value and bounds of what could be told.
    """
    if any("drive_angle" not in log.channels for log in logs):
        return {}
    gear = drive.load_pulley.radius / drive.drive_pulley.radius
    behind = found["near_inertia"][0] * (1.0 - values_of(drive)["motor_share"])
    values = []
    for band in (JOINT_BAND, 0.6 * JOINT_BAND, 1.5 * JOINT_BAND):
        parts = [_twist_rows(log, behind, found["load_inertia"][0] / gear, band) for log in logs]
        fit = solve(suited_segments(joined(parts)))
        values.append((fit.values, fit.half_width()))
    compliance = np.array([v[0] for v, _ in values])
    half = values[0][1][0] + np.max(np.abs(compliance - compliance[0]))
    if compliance[0] <= 0.0 or half > 0.3 * compliance[0]:
        return {}
    stiffness = 1.0 / float(compliance[0])
    relative = float(half / compliance[0])
    told = {"joint_stiffness": around("joint_stiffness", stiffness, stiffness * relative)}
    dampings = np.array([-v[1] for v, _ in values]) * stiffness**2
    rub = float(values[0][1][1] * stiffness**2 + np.max(np.abs(dampings - dampings[0])))
    if dampings[0] > 0.0 and rub < 0.5 * dampings[0]:
        told["joint_damping"] = around("joint_damping", float(dampings[0]), rub)
    return told


def _twist_rows(log: Log, behind: float, load: float, band: float) -> Factors:
    """Twist = torque / k - (b / k^2) torque's rate + what the encoders' zeros add."""
    h = log.interval
    band = min(band, 0.1 / h)

    def smooth(name: str) -> Array:
        return zero_phase(log.channel(name), h, band)

    def twice(values: Array) -> Array:
        return difference(difference(values, h), h)

    motor, pulley, end = smooth("angle"), smooth("drive_angle"), smooth("load_angle")
    torque = behind * twice(pulley) + load * twice(end)
    columns = np.column_stack([torque, difference(torque, h), np.ones(len(log))])
    step, edge = max(1, int(0.02 / (band * h))), int(2.0 / (band * h))
    part = slice(edge, len(log) - edge, step)
    return factor(columns[part], (motor - pulley)[part], ("compliance", "rate", "zero"), 60)
