"""Gains and margins that are chosen, the bound over everything uncertain, causes taken away one at a time."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.bound import impulse_response
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig import track as best_track
from cabledrive.rig.closed_loop.loop import run
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.registry import CONTROLLERS
from cabledrive.rig.margins import (
    closed_loop,
    margins_of,
    rounding_part,
    sampled_controller,
    sampled_plant,
    settled_covariance,
    torque_parts,
)
from cabledrive.rig.tuning import LEAST_DISK, RIPPLE_SHARE, SETTINGS_HZ, design, law_at
from rig_runs import loop_of

DRIVE = cd.load_drive("dissertation-3").listed


@cache
def loop():
    return loop_of("darc-4-damped", DRIVE, Motion(), best=True)


def test_linear_loop_is_the_rig_without_friction():
    """No friction, no counts, the load encoder's zero 1e-3 rad off: the same load angle at each sample."""
    motor = replace(DRIVE.motor, coulomb_friction=0.0, offset_torque=0.0, viscous_friction=0.0)
    drive = replace(DRIVE, motor=motor)
    made = loop().controller
    law = made.law._replace(learning=made.law.learning * np.array([[1.0], [1.0], [1.0], [0.0], [1.0]]))
    law.learning[0, 2:] = 0.0
    still = replace(made, law=law, reference=np.zeros_like(made.reference), start=law.learning[0])
    free = loop_of(still, drive, Motion())
    scalars = free.observer.scalars.copy()
    scalars[[5, 7]] = 0.0
    off = 1e-3 / 1e-12
    rig = free.rig._replace(counts=np.full(3, 1e-12), phases=np.array([0.0, 0.0, off]))
    observer = free.observer._replace(gains=free.observer.gains[-1:], scalars=scalars)
    tested = replace(free, observer=observer, rig=rig)
    matrix, rounding, _ = closed_loop(sampled_controller(tested), sampled_plant(tested))
    impulse = impulse_response(matrix, rounding, np.eye(len(matrix))[2], 299)[:, 2]
    found = run(tested, last=300).log[1:300, 2]
    assert np.abs(found).max() > 1e-4
    expected = 1e-3 * np.cumsum(impulse)
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())


@pytest.mark.parametrize("name", ["lqg", "pd", "darc-4-damped"])
def test_track_takes_the_law_that_compare_lists(name, measured):
    """The same bandwidth and filter, and the next setting of the grid breaks a limit that margins state."""
    motion = Motion(order=11)
    listed = cd.compare(DRIVE, controllers=[name], draws=1, motion=motion).laws[0].tuning
    spec = DesignSpec(DRIVE, motion, best=True)
    made, told = design(name, spec), law_at(name, listed.bandwidth, listed.filter, spec)
    measured(f"{name} {listed.bandwidth:g} Hz, filter {listed.filter}")
    assert made.gains["bandwidth_hz"] == listed.bandwidth
    assert made.tuning == told.tuning
    higher = SETTINGS_HZ[SETTINGS_HZ.index(listed.bandwidth) + 1]
    most = RIPPLE_SHARE * DRIVE.motor.torque_limit
    margins = margins_of(loop_of(law_at(name, higher, listed.filter, spec), DRIVE, motion))
    assert listed.margins["disk"] >= LEAST_DISK
    assert margins.ripple > most or margins.disk < LEAST_DISK


@pytest.mark.parametrize(
    "overrides, options",
    [
        (["sensors.delay=1 ms"], {}),
        (["sensors.delay=0.3 ms", "motor.current_bandwidth=200 Hz"], {}),
        (["sensors.sample_rate=1 kHz"], {}),
        ([], {"ideal_sensors": True}),
        ([], {"encoder_phase": "centred"}),
        ([], {"smooth_friction": True}),
        ([], {"jitter": 2e-5}),
        (["motor.torque_limit=0.6 N m"], {}),
        (["sensors.motor_encoder=500", "sensors.load_encoder=2000"], {}),
    ],
)
def test_best_gains_leave_the_torque_below_its_limit_whatever_changes_the_loop(overrides, options, measured):
    """A third of the samples saturated at a delay of 1 ms where the gains knew nothing of it."""
    drive = cd.load_drive("dissertation-3", overrides=overrides).listed
    said = best_track(drive, controller="darc-4-damped", options=RigOptions(**options), seed=5).summary
    measured(f"{said['gains']['bandwidth_hz']:.0f} Hz, {said['peak_torque']:.2f} N m")
    assert said["saturated_fraction"] == 0.0
    late = "sensors.delay=1 ms" in overrides  # the disk margin then leaves 12 Hz
    assert said["peak_error_deg"] < (0.25 if late else 0.15), f"observed {said['peak_error_deg']:.3f} deg"


MOTION = Motion(angle=5.0, rise=0.2, dwell=0.05, order=11)


def loop_at(name, hertz, *overrides):
    drive = cd.load_drive("dissertation-3", overrides=list(overrides)).listed
    return loop_of(CONTROLLERS[name](DesignSpec(drive, MOTION, bandwidth=hertz)), drive, MOTION)


def stable_with(loop, factor):
    """Whether the loop is stable where the plant's torque is the command times a complex factor."""
    plant = sampled_plant(loop)
    scaled = plant._replace(b=plant.b * factor, a=plant.a.astype(complex))
    controller = sampled_controller(loop)
    m, p = plant.c.shape[0], len(plant.a)
    matrix, _, _ = closed_loop(controller, plant)
    command = np.concatenate((controller.d[:, :m] @ plant.c, controller.c), axis=1)[0]
    matrix = matrix.astype(complex)
    matrix[:p] += np.outer((scaled.b - plant.b)[:, 0], command)
    return bool(np.abs(np.linalg.eigvals(matrix)).max() < 1.0)


@pytest.mark.parametrize(
    "name, hertz", [("pd", 11.0), ("lqi", 30.0), ("lqg-dob", 20.0), ("darc-4-damped", 25.0)]
)
def test_the_gain_margin_is_the_factor_at_which_the_loop_becomes_unstable(name, hertz):
    loop = loop_at(name, hertz)
    margin = margins_of(loop).gain
    assert stable_with(loop, 0.98 * margin)
    assert not stable_with(loop, 1.02 * margin)


def test_a_loop_that_does_not_settle_has_no_margin():
    found = margins_of(loop_at("pd", 300.0))
    assert (found.disk, found.gain, found.phase, found.ripple) == (0.0, 1.0, 0.0, np.inf)


def test_what_a_system_of_unlike_states_gathers_is_that_of_its_modes():
    """Modes within 1e-6 of instability, states of 1 and of 1e7: a sum over powers of each mode."""
    rng = np.random.default_rng(4)
    rates = np.array([0.5, 0.9, 1.0 - 1e-3, 1.0 - 1e-6])
    shapes = np.diag([1.0, 1e3, 1e5, 1e7]) @ np.linalg.qr(rng.normal(size=(4, 4)))[0]
    matrix, noise = shapes @ np.diag(rates) @ np.linalg.inv(shapes), shapes @ np.diag([1.0, 2.0, 3.0, 4.0])
    truth = shapes @ np.diag([1.0, 4.0, 9.0, 16.0] / (1.0 - rates**2)) @ shapes.T
    found = settled_covariance(matrix, noise @ noise.T)
    assert found == pytest.approx(truth, rel=1e-6)
    assert np.linalg.eigvalsh(found).min() > 0.0


def test_what_a_system_gathers_that_grows_a_millionfold_before_it_decays_is_finite():
    """Three states in series, each slow: squares of a whole matrix grow by round-off alone."""
    slow = 0.9995 * np.eye(3) + np.diag([1.0, 1.0], 1)
    turn = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]
    truth, found = (settled_covariance(own, np.eye(3)) for own in (slow, turn @ slow @ turn.T))
    assert np.trace(found) == pytest.approx(np.trace(truth), rel=0.01)
    step = 1.0 - 0.9995**2  # of the last state, which no other moves
    assert truth[2, 2] == pytest.approx(1.0 / step, rel=1e-6)


@pytest.mark.parametrize(
    "overrides", [(), ("sensors.delay=1 ms",), ("sensors.delay=0.3 ms", "motor.current_bandwidth=100 Hz")]
)
def test_every_gain_and_phase_in_the_disk_leaves_the_loop_stable(overrides):
    loop = loop_at("lqi", 12.0, *overrides)
    found = margins_of(loop)
    half = 0.99 * found.disk / 2.0
    for turn in np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)):
        assert stable_with(loop, (1.0 + half * turn) / (1.0 - half * turn))
    phase = 2.0 * np.arctan(half)
    assert phase <= found.phase
    assert stable_with(loop, np.exp(-1j * phase))


def test_rounding_of_a_shaft_that_passes_ten_counts_a_period_is_noise_and_smaller():
    closed = loop()
    limit = 10.0 * closed.rig.counts.max() * closed.controller.bandwidth / (2.0 * np.pi)

    def at(speed):
        reference = closed.controller.reference.copy()
        reference[:, -2] = speed
        moved = replace(closed, controller=replace(closed.controller, reference=reference))
        return rounding_part(moved, *closed_loop(sampled_controller(moved), sampled_plant(moved))[:2])[-1]

    assert at(1.01 * limit) < 0.8 * at(0.0)
    assert at(1.01 * limit) == at(100.0 * limit)


def test_friction_of_unknown_sign_costs_more_by_all_of_it_where_the_law_counts_on_it():
    """Speeds below the noise, a unit impulse: at rest the law cancels none, in motion all of it."""
    one = np.array([1.0])
    _, found = torque_parts(loop(), one, 0.0 * one, np.inf)
    speed = np.abs(loop().controller.reference[:, -2])
    moving, still = found[speed.argmax()], found[speed.argmin()]
    assert moving - still == pytest.approx(DRIVE.motor.coulomb_friction, rel=1e-3)
