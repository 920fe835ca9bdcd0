"""Margins along a planned motion, against formulas by hand and a chain that scipy integrates."""

from math import log, pi, radians

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cabledrive as cd
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.studies.motion_margins import EXCEEDED, motion_margins
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.sway import sway
from command import answer, refusal, refused
from network_samples import routed
from oracles.by_scipy import span_tensions
from rewritten import turned

ATWOOD = """
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


def test_two_masses_over_a_sheave_have_the_tensions_of_newton(measured):
    """T1 = m1 (g + a) + F, T2 = m2 (g - a); Eytelwein's ratio over half a turn; torque.

    Up by 2 m in 2 s, at constant acceleration and braking as hard.
    """
    drive, g, a, rub, time = routed(ATWOOD), 9.81, 2.0, 20.0, np.linspace(0.0, 2.0, 4001)
    rise = np.where(time < 1.0, 0.5 * time**2, 1.0 - 0.5 * (2.0 - time) ** 2) * a
    places = {"car.y": rise, "weight.y": -rise}
    found = motion_margins(drive, PlannedMotion(time=time, torque=0.0 * time, places=places))
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
    drive = routed(BELT)
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


def test_torques_of_a_loop_count_as_its_rope_runs(tmp_path, measured):
    """That of the drive pulley relieves the upper span as in a simulation, that of the load pulley not."""
    motion, settings, found = tmp_path / "motion.csv", "layout.gravity=0", []
    for head, row in (("torque [N m]", "{}"), ("torque [N m],load torque [N m]", "0,{}")):
        rows = [f"{t:.3f},{row.format(0.05 * t)}\n" for t in np.linspace(0.0, 0.2, 101)]
        motion.write_text(f"time [s],{head}\n" + "".join(rows))
        judged = answer("check", "dissertation-2", "--set", settings, "--motion", str(motion))["motion"]
        found.append([one["lowest_tension"] for one in judged["spans"]])
    run = cd.simulate(cd.load_drive("dissertation-2", overrides=[settings]), 0.2, torque=lambda t: 0.05 * t)
    known = [float(run.channel(f"mean tension, {span}").min()) for span in ("upper", "lower")]
    measured(f"lowest {found[0]} N, simulated {known} N; by the load {found[1]} N")
    np.testing.assert_allclose(found[0], known, atol=0.1 * abs(known[0] - known[1]))
    assert found[1][0] > found[1][1]


def test_places_that_the_ropes_do_not_allow_are_refused():
    time = np.linspace(0.0, 1.0, 101)
    for drive, starts, words in (
        (routed(ATWOOD), {"car.y": 0.0, "weight.y": 0.0}, "do not go together"),
        (cd.load_drive("corexy"), {"head.x": 0.17}, r"add beam\.y"),
        (cd.load_drive("tendon-finger"), {"proximal.turn": 0.0}, "give the torque alone"),
    ):
        places = {name: start + 0.1 * time for name, start in starts.items()}
        with pytest.raises(cd.InputRefused, match=words):
            motion_margins(drive, PlannedMotion(time=time, torque=0.0 * time, places=places))


# --- Sway of a building and the ropes in it
def integrated(length, tension, density, damping, omega, ends):
    """Largest motion across beside the chord of a string whose ends move, by integration along it."""

    def slopes(x, state):
        own = tension[0] + (tension[1] - tension[0]) * x / length
        return state[1] / own, -density * (omega**2 - 1j * omega * damping) * state[0]

    places = np.linspace(0.0, length, 401)
    one, other = (
        solve_ivp(
            slopes, (0, length), np.array(start, dtype=complex), t_eval=places, rtol=1e-9, atol=1e-12
        ).y[0]
        for start in ((1.0, 0.0), (0.0, 1.0))
    )
    motion = ends[0] * one + (ends[1] - ends[0] * one[-1]) / other[-1] * other
    return np.abs(motion - (ends[0] + (ends[1] - ends[0]) * places / length)).max()


@pytest.mark.parametrize("hertz", [0.21, 1.3])
def test_sway_is_that_of_the_integrated_equation(hertz):
    drive = cd.load_drive("lift-2-to-1", overrides=["car.y=31 m"])
    found = sway(drive, hertz, 0.05)
    statics = statics_of(drive)
    for number, span in enumerate(drive.free_spans):
        rope = drive.ropes[span.route]
        ends = [0.05 * (point[1] - found.bottom) / (found.top - found.bottom) for point in span.contacts]
        tension = (statics.start[number], statics.end[number])
        density = rope.mass_per_length / (1.0 + np.mean(tension) / rope.axial_rigidity)
        wanted = integrated(span.length, tension, density, rope.transverse_damping, 2 * np.pi * hertz, ends)
        own = next(one for one in found.ropes if one.name == span.name)
        assert own.amplitude == pytest.approx(wanted, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "places", "below", "off"),
    [("lift-2-to-1", ["car.y=8 m"], 10.0, 2e-3), ("serpentine", [], 200.0, 1e-8)],
)
def test_first_frequencies_are_those_of_the_certified_list(name, places, below, off):
    """Of stretched ropes; those of the lift are stiff in bending, which is left out."""
    drive = cd.load_drive(name, overrides=places)
    found = cd.modes(drive, below=below)
    for rope in sway(drive, 0.2, 0.05).ropes:
        out = (mode for mode in found.transverse if mode.plane == "v" and rope.name in (mode.span or ""))
        first = min(mode.frequency for mode in out)
        assert rope.frequency_hz == pytest.approx(first, rel=off)


def test_a_rope_is_looked_at_where_it_resonates_with_the_building():
    places = np.array([[10.0, 20.0, 30.0]])
    found = sway(cd.load_drive("lift-2-to-1"), 0.8, 0.05, {("car.y",): places})
    rope = next(own for own in found.ropes if own.name == "car bottom to pit sheave")
    resonant = rope.amplitude.argmax()
    assert rope.frequency_hz[resonant] == pytest.approx(0.8, rel=1e-6)
    assert rope.amplitude[resonant] > 10 * rope.amplitude[np.isin(found.places, places)].max()


def test_a_second_mode_between_two_places_is_looked_at_as_well():
    """Of a shaft of 300 m: 31 places say what ten times as many say."""
    tall = cd.load_drive("lift-2-to-1", overrides=["shaft=300 m"])
    few, many = (
        {rope.name: rope.amplitude.max() for rope in sway(tall, 0.25, 0.3, {("car.y",): places[None]}).ropes}
        for places in (np.linspace(150.0, 296.0, 16), np.linspace(150.0, 296.0, 151))
    )
    assert few == pytest.approx(many, rel=2e-3)


def test_a_level_machine_has_no_height_however_it_is_turned():
    """Its two pulleys stand 7e-15 m apart in height by round-off: ropes swayed by the whole amplitude."""
    level = cd.load_drive("camera-line").machine.plain
    askew = turned(turned(level, radians(17.0)), radians(24.0))
    for machine in (level, askew):
        refused(lambda machine=machine: sway(machine, 0.2, 0.05), "no height")


SWAY = ("sway", "lift-2-to-1", "--building")


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (["0 Hz", "--amplitude", "50 mm"], "building"),
        (["0.2 Hz", "--amplitude", "-1 mm"], "amplitude"),
        (["0.2 Hz", "--amplitude", "50 mm", "--set", "cable.transverse_damping=0"], "transverse_damping"),
        (["0.2 Hz", "--amplitude", "50 mm", "--vary", "car.y=2m:41m"], "travel"),
    ],
)
def test_what_is_no_sway_is_refused(options, name):
    assert name in refusal(*SWAY, *options)


def test_the_command_gives_every_rope_at_every_place():
    found = answer(*SWAY, "1 Hz", "--amplitude", "50 mm", "--vary", "car.y=2m:38m:4")
    assert len(found["ropes"]) == 6
    assert all(len(rope["amplitude"]) == len(found["places"]) for rope in found["ropes"])
    assert found["warnings"]  # 2 m of a rope of 20 m
