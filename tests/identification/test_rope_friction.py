"""Ropes that creep, slide or rub on pulleys, in logs of machines that share no code with the package."""

from math import pi, tanh

import numpy as np
import pytest

from cabledrive.identification.logs.log import log_of
from cabledrive.identification.rope_friction import split_friction, without_slip
from cabledrive.identification.two_sides import TwoSides
from cabledrive.parameters import InputRefused, load_drive
from oracles.wrapped_arm import arm_log
from study_drives import drive_of
from true_plants import shaken_log, truth_of

DRIVES = {"geared": load_drive("dissertation-3").listed, "rigid": drive_of("turntable")}
SHAKES, MOST = {"geared": 0.8, "rigid": 0.6}, {"geared": 0.92, "rigid": 0.53}
"""Torque of the multisine, and the largest pull of the rope that it makes [N m]."""


def slip_in(name, seed, **slips):
    """What is found in the log of a machine with other inertias, springs and frictions than its sheet."""
    g, truth = np.random.default_rng(seed), truth_of(DRIVES[name])
    parts = {"j1": 0.1, "j3": 0.1, "kc": 0.2, "km": 0.2, "bc": 0.4, "c1": 0.5}
    truth = truth.but(**{key: truth[key] * g.uniform(1.0 - part, 1.0 + part) for key, part in parts.items()})
    truth = truth.but(c3=truth["c1"] * g.uniform(0.0, 0.2)).but(**slips)
    torque, angles = shaken_log(truth, 12.0, SHAKES[name], seed)
    motor, *pulley, load = (angles[k] for k, count in enumerate(truth.counts) if count > 0.0)
    share = truth["j1"] / (truth["j1"] + truth["j2"]) if pulley else 1.0
    joint = {"pulley": pulley[0], "share": share} if pulley else {}
    one = TwoSides(source="log", interval=1e-3, torque=torque, motor=motor, load=load, **joint)
    return without_slip([one])[1], truth["j3"]


@pytest.mark.parametrize("name", DRIVES)
def test_a_creep_is_found_with_its_size(name, measured):
    """From 0.2 to 1.5 % of the way per N m: within a tenth, in seven of eight logs at least."""
    found = []
    for seed in range(8):
        creep = float(np.random.default_rng([seed, 1]).uniform(0.002, 0.015))
        slip, inertia = slip_in(name, seed, creep=creep)
        found.append(np.nan if slip is None or not slip.creep else slip.creep / inertia / creep)
    measured(
        f"over the true one {np.nanmin(found):.3f} to {np.nanmax(found):.3f}, missed {np.isnan(found).sum()}"
    )
    assert np.isnan(found).sum() <= 1
    assert np.nanmax(np.abs(np.array(found) - 1.0)) < 0.1


def test_the_torque_at_which_a_rope_slides_is_found(measured):
    found = []
    for seed in range(8):
        holds = float(np.random.default_rng([seed, 2]).uniform(0.4, 0.85)) * MOST["rigid"]
        slip, inertia = slip_in("rigid", seed, holds=holds)
        assert slip is not None
        found.append(slip.limit * inertia / holds)
    measured(f"over the true one {min(found):.3f} to {max(found):.3f}")
    assert max(abs(one - 1.0) for one in found) < 0.1


FAULTS = {
    "none": {},
    "backlash": {"gap": 0.017},
    "load friction": {"b3": 0.006, "c3": 0.02},
    "eccentric encoder": {"eccentric": 2e-3},
    "stiffening": {"hardening": 30.0},
    "Stribeck": {"stribeck": 0.02},
    "cogging": {"cogging": 0.015, "cogging_lines": 12.0},
}


@pytest.mark.parametrize("what", FAULTS)
def test_a_rope_that_holds_is_not_blamed(what):
    assert all(slip_in(name, 20 + k, **FAULTS[what])[0] is None for k in range(2) for name in DRIVES)


# --- Friction at wraps told from friction at bearings, on a joint whose rope sticks and slides on its wraps
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
