"""The alarm for a motion of a machine with routes, against the loop's alarm and an integrator of its own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cabledrive as cd
from cabledrive.parameters import InputRefused
from cabledrive.studies.alarm import alarm
from cabledrive.studies.motion_file import read_motion
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_alarm import route_alarm
from cabledrive.studies.route_growth import Runs, growth_along
from cabledrive.studies.route_pairs import route_resonance
from cabledrive.studies.route_path import RoutePath
from cabledrive.studies.route_snapshot import Snapshot
from command import answer, refusal
from network_samples import as_route
from resonance_samples import damped_loop

PRINTER = Path(__file__).parent.parent / "parameters" / "routes" / "printer.toml"


def damped_route(loop):
    route = as_route(loop)
    return replace(
        route,
        cable=replace(route.cable, transverse_damping=2.0, axial_damping=0.02),
        pulley=tuple(replace(pulley, viscous_friction=2e-5) for pulley in route.pulley),
    )


@pytest.mark.parametrize("share", [0.5, 2.0, 4.0])
def test_a_loop_as_a_route_has_the_alarm_of_the_loop(share, measured):
    """The loop's alarm shares neither modes nor integrator; its back-action is small at these amplitudes."""
    loop = damped_loop()
    route = damped_route(loop)
    pairs = route_resonance(route)
    time = np.linspace(0.0, 1.5, 15_001)
    torque = share * pairs.threshold_torque * np.sin(2.0 * np.pi * pairs.longitudinal_hz * time)
    motion = PlannedMotion(time=time, torque=torque)
    expected, found = alarm(loop, motion), route_alarm(route, motion)
    assert found.verdict == expected.verdict
    first = [max(one.largest for one in who.modes if one.number == 1) for who in (expected, found)]
    measured(f"{share} of the threshold: {1e3 * first[0]:.4g} mm, as a route {1e3 * first[1]:.4g} mm")
    if share > 1.0:
        assert first[1] == pytest.approx(first[0], rel=0.05)
    nearest = found.passages[0]
    assert nearest.kind == "1:2"
    assert nearest.amplitude == pytest.approx(share, rel=0.02)
    assert not nearest.passes


def swept_path(steps, rate):
    """One longitudinal mode that swings freely and two coupled transverse ones whose frequencies change."""

    def snapshot(scale):
        return Snapshot(
            along=np.array([60.0]),
            along_loss=np.array([0.0]),
            along_turn=np.array([[0.0]]),
            along_shape=np.ones((1, 1)),
            strain=np.zeros((1, 1)),
            tension=np.array([1.0]),
            keys=(("belt", "w", 1), ("belt", "w", 2)),
            across=scale * np.array([30.0, 33.0]),
            across_loss=np.array([0.3, 0.5]),
            across_turn=np.array([[1.0], [0.5]]),
            coupling=np.array([[[240.0, 80.0], [80.0, 160.0]]]),
            shape=np.array([[1.0, 0.7], [0.6, -0.8]]),
            certified=True,
            reach=40.0,
        )

    time = np.linspace(0.0, 4.0, steps + 1)
    along = np.cos(60.0 * time)[:, None]
    return RoutePath(
        poses=({}, {}),
        snapshots=(snapshot(0.97), snapshot(1.02)),
        time=time,
        here=rate * time / 4.0,
        torque=np.full((steps + 1, 1), 1e-3),
        pushed=np.full((steps, 1), 1e-3),
        along=along,
        along_rate=-60.0 * np.sin(60.0 * time)[:, None],
    )


def test_a_sweep_through_resonance_grows_as_a_general_integrator_has_it(measured):
    """1:2 and sum type at once, frequencies changing, damping: DOP853 to 1e-10."""
    path = swept_path(6000, 1.0)
    runs = Runs(
        floor=np.zeros(1), phase=np.zeros(1), detuned=np.zeros(1), torque=np.ones(1), parametric=np.ones(1)
    )
    found = growth_along(path, runs, 1e3)
    matrix, loss, push = np.array([[240.0, 80.0], [80.0, 160.0]]), np.array([0.3, 0.5]), np.array([1.0, 0.5])

    def rate(t, y):
        omega = (0.97 + 0.05 * t / 4.0) * np.array([30.0, 33.0])
        pull = np.cos(60.0 * t) * matrix
        return np.append(y[2:], 1e-3 * push - loss * y[2:] - omega**2 * y[:2] - pull @ y[:2])

    fine = solve_ivp(
        rate,
        (0.0, 4.0),
        np.zeros(4),
        t_eval=path.time,
        method="DOP853",
        rtol=1e-10,
        atol=1e-14,
        max_step=0.01,
    )
    expected = np.abs(np.array([[1.0, 0.7], [0.6, -0.8]]) @ fine.y[:2])
    growth = expected.max() / expected[:, fine.t < 0.2].max()
    measured(f"grown {growth:.1f} times; ratio {found.displacement[0] / expected.max():.5f}")
    assert growth > 10.0
    assert found.displacement[0] == pytest.approx(expected.max(), rel=0.01)


def test_a_move_of_the_head_passes_a_resonance_that_the_machine_at_rest_has_not():
    """The first string mode of one strand falls from above to below half the longitudinal mode."""
    machine = cd.load_drive(str(PRINTER))
    time = np.linspace(0.0, 0.4, 2001)
    head = 0.06 + 0.30 * time / 0.4
    motion = PlannedMotion(time=time, torque=np.zeros(time.size), places={"head.x": head})
    found = route_alarm(machine, motion)
    passing = [one for one in found.passages if one.passes and one.kind == "1:2"]
    assert any(one.span in ("left clamp to motor", "upper idler to right clamp") for one in passing)
    still = route_alarm(machine, replace(motion, places={"head.x": np.full(time.size, 0.2)}))
    assert not any(one.passes for one in still.passages)
    assert found.poses == 13
    assert still.poses == 1


def test_the_command_reads_places_and_torques_of_other_motors(tmp_path):
    file = tmp_path / "motion.csv"
    file.write_text("time [s],torque [N m],head.x [mm]\n0,0.01,150\n0.05,-0.01,180\n0.1,0,180\n")
    found = answer("resonance", str(PRINTER), "--motion", str(file))["motion"]
    assert found["verdict"] in ("safe", "dangerous", "unknown")
    assert found["limit"] == 5e-4
    assert any("not checked" in line for line in found["assumptions"])
    assert read_motion(file, cd.load_drive(str(PRINTER))).places["head.x"][1] == pytest.approx(0.18)
    wrong = tmp_path / "wrong.csv"
    wrong.write_text("time [s],torque [N m],tail.x [m]\n0,0,0\n1,0,0\n")
    assert "tail.x" in refusal("resonance", str(PRINTER), "--motion", str(wrong))
    assert "--motion" in refusal("resonance", str(PRINTER), "--limit", "1 mm")
    two = tmp_path / "two.csv"
    two.write_text("time [s],torque [N m],torque motor b [N m]\n0,0,0\n1,0,1\n")
    corexy = cd.load_drive(str(PRINTER.parent / "corexy.toml"))
    assert read_motion(two, corexy).torques["motor b"][1] == 1.0


def test_a_place_that_the_machine_cannot_take_is_refused_in_one_line():
    machine = cd.load_drive(str(PRINTER))
    time = np.linspace(0.0, 0.1, 11)
    with pytest.raises(InputRefused, match="give places as columns"):
        route_alarm(machine, PlannedMotion(time=time, torque=np.full(11, 50.0)))
