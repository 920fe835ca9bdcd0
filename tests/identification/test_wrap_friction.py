"""Friction at wraps told from friction at bearings, on a joint whose rope sticks and slides on its wraps."""

from math import pi, tanh

import numpy as np
import pytest

from cabledrive.identification.logs.log import log_of
from cabledrive.identification.rope_friction import split_friction
from cabledrive.parameters import InputRefused
from oracles.wrapped_arm import arm_log

RATE = 1000.0
ARM = {
    "samples": 12_000,
    "radius": 0.008,
    "joint_radius": 0.04,
    "stiffness": 350e3,
    "friction": 0.05,
    "wrap": 0.5,
    "inertia": 3.5e-5,
    "joint_inertia": 0.042,
    "motor_coulomb": 0.01,
    "joint_coulomb": 0.03,
    "viscous": 2e-4,
    "damping": 20.0,
    "counts": 16384,
    "joint_counts": 65536,
}


def strokes(t, angle, speed):
    """Two slow sines, followed by a drive with proportional and rate action."""
    first, second = 2.0 * pi * 0.4, 2.0 * pi * 0.9
    wanted = 3.0 * np.sin(first * t) + 1.5 * np.sin(second * t + 1.0)
    rate = 3.0 * first * np.cos(first * t) + 1.5 * second * np.cos(second * t + 1.0)
    return max(-1.0, min(1.0, 0.35 * (wanted - angle) + 0.012 * (rate - speed)))


def logged(tension, rng, **other):
    torque, angle, _ = arm_log(strokes, RATE, tension, ARM | other, 0.005, rng, fine=10)
    time = np.arange(torque.size) / RATE
    return log_of(time, {"torque": torque, "angle": angle}, {"torque": "N m", "angle": "rad"}, f"{tension} N")


def truth(arm):
    """Friction of motor and joint at the motor, and that of the wraps per tension."""
    bearings = arm["motor_coulomb"] + arm["joint_coulomb"] * arm["radius"] / arm["joint_radius"]
    return bearings, 4.0 * arm["radius"] * tanh(0.5 * arm["friction"] * arm["wrap"])


def test_logs_at_two_tensions_tell_wraps_from_bearings_and_one_tension_does_not(measured):
    tensions = (60.0, 150.0)
    logs = [logged(tension, np.random.default_rng(int(tension))) for tension in tensions]
    found, (bearings, wraps) = split_friction(logs, tensions), truth(ARM)
    constant, slope = found.constant, found.per_tension
    measured(
        f"bearings {constant.low:.5f} to {constant.high:.5f} N m, true {bearings:.5f}; "
        f"wraps {1e3 * slope.low:.4f} to {1e3 * slope.high:.4f} mm, true {1e3 * wraps:.4f}"
    )
    assert not found.reason
    assert constant.low <= bearings <= constant.high
    assert slope.low <= wraps <= slope.high
    assert slope.high - slope.low < 0.2 * wraps
    assert "assumed, not checked" in found.findings[0]

    alike = split_friction([logs[0], logs[0]], (60.0, 60.0))
    assert alike.reason
    assert np.isnan(alike.constant.value)
    assert "at another pretension" in alike.reason
    close = split_friction(logs, (150.0, 150.5))
    assert close.reason
    with pytest.raises(InputRefused, match="a positive one each"):
        split_friction(logs, (60.0,))
    with pytest.raises(InputRefused, match="strokes"):
        split_friction([logs[0].part(0.0, 2.0)], (60.0,))


def test_friction_that_is_not_in_proportion_is_found():
    """A bearing that a tighter rope loads twice over is no wrap's friction."""
    tensions = (40.0, 90.0, 140.0)
    logs = [
        logged(
            tension, np.random.default_rng(9), friction=0.02, motor_coulomb=0.01 + 0.05 * (tension == 90.0)
        )
        for tension in tensions
    ]
    found = split_friction(logs, tensions)
    assert any("not lie on a line" in line for line in found.findings)
