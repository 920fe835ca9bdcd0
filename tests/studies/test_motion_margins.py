"""Margins along a planned motion, against formulas by hand and a chain that scipy integrates."""

from math import log, pi

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.studies.motion_margins import EXCEEDED, motion_margins
from cabledrive.studies.planned_motion import PlannedMotion
from oracles.hoists import span_tensions

ATWOOD = """
schema = 1
kind = "route"
name = "two masses over a sheave"
cable = { axial_rigidity = "1 GN", mass_per_length = "1e-6 kg/m", strength = "4 kN" }
body = [
    { name = "car", mass = "100 kg", at = ["-0.2 m", "0 m"], moves = "y", coulomb_friction = "20 N" },
    { name = "weight", mass = "80 kg", at = ["0.2 m", "0 m"], moves = "y" },
]
anchor = [
    { name = "car top", on = "car", at = ["-0.2 m", "0 m"] },
    { name = "weight top", on = "weight", at = ["0.2 m", "0 m"] },
]
route = [{ name = "rope", path = ["car top", "-sheave", "weight top"] }]
motor = { pulley = "sheave", inertia = "0.5 kg m^2", torque_limit = "120 N m" }
[[pulley]]
name = "sheave"
at = ["0 m", "10 m"]
radius = "0.2 m"
inertia = "0.5 kg m^2"
capstan_friction = 0.2
"""
BELT = """
schema = 1
kind = "route"
name = "belt"
layout = { gravity = "0 m/s^2" }
pulley = [
    { name = "motor", at = ["0 m", "0 m"], radius = "20 mm" },
    { name = "load", at = ["1 m", "0 m"], radius = "20 mm", inertia = "2e-3 kg m^2" },
]
route = [{ name = "belt", closed = true, path = ["-motor", "-load"] }]
motor = { pulley = "motor", inertia = "1e-3 kg m^2", torque_limit = "10 N m" }
[cable]
axial_rigidity = "20 kN"
mass_per_length = "1e-6 kg/m"
pretension = "200 N"
tooth_pitch = "5 mm"
strength = "600 N"
"""


def lifted(height, seconds, acceleration):
    """Up by constant acceleration and braking as hard, with the places of both masses."""
    time = np.linspace(0.0, seconds, 4001)
    half = 0.5 * seconds
    up = np.where(time < half, 0.5 * time**2, half**2 - 0.5 * (seconds - time) ** 2) * acceleration
    assert up[-1] == pytest.approx(height)
    return PlannedMotion(time=time, torque=0.0 * time, places={"car.y": up, "weight.y": -up})


def test_two_masses_over_a_sheave_have_the_tensions_of_newton(measured):
    """T1 = m1 (g + a) + F, T2 = m2 (g - a); Eytelwein's ratio over half a turn; torque."""
    drive, g, a, rub = drive_from_text(ATWOOD), 9.81, 2.0, 20.0
    found = motion_margins(drive, lifted(2.0, 2.0, a))
    up, down = 100.0 * (g + a) + rub, 80.0 * (g - a)
    torque = 0.2 * (up - down) + 1.0 * a / 0.2
    car, weight = (next(own for own in found.spans if name in own.name) for name in ("car", "weight"))
    assert car.even[1] == pytest.approx(up, rel=2e-4)
    assert weight.even[0] == pytest.approx(down, rel=2e-4)
    (sheave,), (motor,) = found.pulleys, found.motors
    # The vibration that the jump of the acceleration excites doubles the change of the tension at most.
    assert car.tension[1] <= car.rest[1] + 2.0 * (up - car.rest[1]) * 1.01
    assert motor.peak_torque == pytest.approx(torque, rel=1e-3)
    assert motor.holding_torque == pytest.approx(-0.2 * 20.0 * g, rel=1e-4)  # clockwise
    needed = log(up / down) / pi
    assert sheave.needed_friction >= needed * 0.999
    measured(
        f"Atwood: torque {motor.peak_torque:.4f} for {torque:.4f} N m, friction needed {needed:.4f} slowly"
    )
    assert found.verdict == EXCEEDED  # 120 N m of the file are less
    assert any("motor at sheave" in reason for reason in found.reasons)


@pytest.mark.parametrize("ramp", [0.0, 0.004, 0.03])
def test_the_vibration_is_that_of_a_chain_that_scipy_integrates(ramp, measured):
    """A torque that jumps, or rises within 4 or 30 ms, brakes and ends."""
    time = np.linspace(0.0, 0.2, 8001)
    edges = (0.0, ramp + 1e-9, 0.08, 0.08 + ramp + 1e-9, 0.16, 0.16 + ramp + 1e-9)
    torque = np.interp(time, edges, (0.0, 2.0, 2.0, -1.5, -1.5, 0.0))
    drive = drive_from_text(BELT)
    found = motion_margins(drive, PlannedMotion(time=time, torque=torque))
    both = span_tensions(time, torque, 0.02, 1e-3, 2e-3, 20e3 / (1.0 / 1.01), 200.0)
    for span, tension in zip(found.spans, both, strict=True):
        ends = sorted((np.min(tension), np.max(tension)))
        measured(f"{span.name}, ramp {1e3 * ramp} ms: {span.tension} against {ends} N")
    largest = sorted(own.tension[1] for own in found.spans)
    lowest = sorted(own.tension[0] for own in found.spans)
    change = np.abs(both - 200.0).max()
    assert largest == pytest.approx(sorted(both.max(axis=1)), abs=0.01 * change)
    assert lowest == pytest.approx(sorted(both.min(axis=1)), abs=0.01 * change)


def test_places_that_the_ropes_do_not_allow_are_refused():
    time = np.linspace(0.0, 1.0, 101)
    places = {"car.y": 0.1 * time, "weight.y": 0.1 * time}
    with pytest.raises(cd.InputRefused, match="do not go together"):
        motion_margins(drive_from_text(ATWOOD), PlannedMotion(time=time, torque=0.0 * time, places=places))
    with pytest.raises(cd.InputRefused, match=r"add beam\.y"):
        motion_margins(
            cd.load_drive("corexy"),
            PlannedMotion(time=time, torque=0.0 * time, places={"head.x": 0.17 + 0.1 * time}),
        )
    with pytest.raises(cd.InputRefused, match="give the torque alone"):
        motion_margins(
            cd.load_drive("tendon-finger"),
            PlannedMotion(time=time, torque=0.0 * time, places={"proximal.turn": 0.1 * time}),
        )
