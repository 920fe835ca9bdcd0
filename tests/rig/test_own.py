"""Controllers and plants of the user's own run on the rig as the packaged ones."""

from dataclasses import replace

import numba
import numpy as np
import pytest

import cabledrive as cd
from cabledrive.control.linear_laws import pd_law, pid_law
from cabledrive.mechanics.compiled import numba_at_hand, why_plain
from cabledrive.reduction.lumped_chain import lumped_model, reflected
from cabledrive.rig import Disturbance, Motion, RigOptions, track
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest, run
from cabledrive.rig.closed_loop.own_plant import run_own
from cabledrive.rig.front_door import own_law
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.setting import DEGREE, sample_interval

DRIVE = cd.load_drive("dissertation-3").listed
CHAIN, INTERVAL = reflected(lumped_model(DRIVE, 4))[0], sample_interval(DRIVE)
SHORT = Motion(angle=5.0, rise=0.15, dwell=0.05, order=11)


def feedback(gains, state, measurement, reference):
    """State feedback on the reference's own torque: any of the packaged laws without memory."""
    return state, reference[-1] + gains @ (measurement - reference[:-1])


def with_memory(gains, state, measurement, reference):
    """A linear law with states, as its matrices say: command first, then the next state."""
    matrix, row = gains
    error = measurement - reference[:-1]
    command = reference[-1] + row @ np.concatenate((state, error))
    return matrix @ np.concatenate((state, error, np.array([0.0]))), command


def largest(one, other):
    return float(np.abs(one - other).max())


DISTURBED = RigOptions(
    disturbances=(Disturbance(torque=0.3, start=0.1, end=0.2, on="motor"),),
    jitter=2e-6,
    blind=("load", 0.1, 0.11),
)


@pytest.mark.parametrize(
    "options, settings",
    [
        (RigOptions(), ()),
        (RigOptions(ideal_sensors=True, smooth_friction=True), ()),
        (RigOptions(observer="difference"), ()),
        (DISTURBED, ("sensors.delay=0.3 ms", "motor.torque_limit=0.25 N m")),
    ],
    ids=["encoders", "ideal", "difference", "delay, limit, dropout, jitter, disturbance"],
)
def test_a_pd_in_plain_python_is_the_packaged_pd(options, settings, measured):
    """Sample by sample: the same filter, feedforward, torque limit, delay, encoders."""
    drive = cd.load_drive("dissertation-3", overrides=settings).listed
    row = pd_law(reflected(lumped_model(drive, 4))[0], 5.0, INTERVAL).rows[0]
    packaged = track(drive, controller="pd", bandwidth=5.0, motion=SHORT, options=options)
    own = track(drive, controller=cd.OwnController(step=feedback, gains=row), motion=SHORT, options=options)
    assert bool(settings) == (packaged.summary["saturated_fraction"] > 0.0)
    torque, load = largest(packaged.torque, own.torque), largest(packaged.load_angle, own.load_angle)
    measured(f"{torque:.1e} N m, {load:.1e} rad")
    assert max(torque, load) < 1e-10, f"observed {torque:.1e} N m, {load:.1e} rad"
    assert own.interpreted == "controller"
    assert own.summary["interpreted"] == "controller"
    assert packaged.interpreted == why_plain()
    for key in ("peak_error_deg", "saturated_fraction", "invalid_samples", "encoder_error_deg"):
        assert own.summary[key] == pytest.approx(packaged.summary[key], abs=1e-9), key


def test_readings_come_in_counts_and_the_wanted_motion_with_its_derivatives():
    seen = []

    def step(gains, state, measurement, reference):
        seen.append((measurement, reference))
        return state + 1.0, gains * (reference[0] - measurement[-1])

    own = cd.OwnController(
        step=step, gains=0.3, initial_state=[0.0], measures="readings", follows="motion", name="by counts"
    )
    found = track(DRIVE, controller=own, motion=SHORT)
    readings, reference = (np.array(part) for part in zip(*seen, strict=True))
    np.testing.assert_array_equal(readings, found.readings)
    np.testing.assert_allclose(
        reference[:, 0], found.reference * DRIVE.load_pulley.radius / DRIVE.drive_pulley.radius, atol=1e-15
    )
    rate = np.gradient(reference[:, 0], INTERVAL)
    np.testing.assert_allclose(reference[5:-5, 1], rate[5:-5], atol=1e-3 * np.abs(rate).max())
    assert found.summary["controller"] == "by counts"


@pytest.mark.kernel
def test_the_loop_around_a_compiled_controller_is_that_sample_by_sample():
    """`cabledrive.rig.closed_loop.loop_kernels` with the kernels of the controller, against the loop
    in Python, with a dropout and a memory.
    """
    spec = DesignSpec(DRIVE, SHORT)
    options = RigOptions(blind=("load", 0.1, 0.11))
    law = pid_law(CHAIN, 2.0, 28.0, INTERVAL)
    own = cd.OwnController(step=with_memory, gains=(law.matrix, law.rows[0]), initial_state=np.zeros(3))

    def closed(controller):
        made = own_law(controller, spec)
        loop = close_loop(DesignSpec(DRIVE, SHORT, options=options), made, np.random.default_rng(1))
        eccentric = {"eccentricity": 2e-3, "turning": 1.0, "phases": np.array([0.0, 0.0, 0.4])}
        return replace(loop, plant=loop.plant._replace(**eccentric))

    loop = closed(own)
    plain = run(loop)
    np.testing.assert_array_equal(plain.log, run(loop).log)
    compiled = cd.OwnController(step=COMPILED, gains=own.gains, initial_state=np.zeros(3))
    found = run(closed(compiled))
    assert found.interpreted == (None if numba_at_hand() else "controller")
    assert plain.interpreted == "controller"
    assert found.state.summary[6] == plain.state.summary[6] > 0
    np.testing.assert_allclose(found.log, plain.log, rtol=0.0, atol=1e-9)
    one = closed(compiled)
    state, log = loop_at_rest(one), np.zeros_like(plain.log)
    # what `run` takes where there is a compiler
    assert run_own(one, (0, len(log)), state, log) == len(log)
    np.testing.assert_allclose(log, plain.log, rtol=0.0, atol=1e-9)


COMPILED = numba.njit(with_memory)


# Without friction of the motor two linear inertias are left, whose motion any integrator finds.
SMOOTH = (
    "motor.coulomb_friction=0 N m",
    "pulley.0.coulomb_friction=0 N m",
    "pulley.1.coulomb_friction=0 N m",
)
LINEAR = cd.load_drive("dissertation-3", overrides=[*SMOOTH, "motor.backlash=0"]).listed
MODEL_2 = reflected(lumped_model(LINEAR, 2))[0]


def gearbox():
    """Motor, a gear's shaft, drive pulley and load: one link more than Model 4."""
    four = reflected(lumped_model(LINEAR, 4))[0]
    return cd.LumpedChain(
        names=("motor", "gear", "drive", "load"),
        inertias=(0.6 * four.inertias[0], 0.4 * four.inertias[0], *four.inertias[1:]),
        viscous=(four.viscous[0], 0.0, *four.viscous[1:]),
        coulomb=(0.0,) * 4,
        offsets=(four.offsets[0], 0.0, 0.0, 0.0),
        stiffness=(20.0 * four.stiffness[0], *four.stiffness),
        damping=(four.damping[0], *four.damping),
        ratios=((1.0, 1.0),) * 3,
    )


def two_masses(parameters, state, torques, time):
    """Model 2 by Runge and Kutta, in plain Python: motor, and drive pulley with the load."""
    (j1, j2), (b1, b2), offset, k, b = parameters

    def rates(x):
        link = k * (x[0] - x[1]) + b * (x[2] - x[3])
        motor = (torques[0] + offset - link - b1 * x[2]) / j1
        return np.array([x[2], x[3], motor, (torques[1] + link - b2 * x[3]) / j2])

    r1 = rates(state)
    r2 = rates(state + 0.5 * time * r1)
    r3 = rates(state + 0.5 * time * r2)
    return state + time / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + rates(state + time * r3))


def own_model_2(**parts):
    numbers = (
        MODEL_2.inertias,
        MODEL_2.viscous,
        MODEL_2.offsets[0],
        MODEL_2.stiffness[0],
        MODEL_2.damping[0],
    )
    given = {
        "step": two_masses,
        "initial_state": np.zeros(4),
        "shafts": ("motor", "drive"),
        "name": "two masses",
    }
    return cd.OwnPlant(**(given | {"parameters": numbers} | parts))


PUSHED = RigOptions(disturbances=(Disturbance(torque=0.05, start=0.05, end=0.2),), jitter=1e-6)


def gap(drive, substeps):
    """Largest difference of the load's angle between the packaged Model 2 and the user's [deg]."""
    options = replace(PUSHED, substeps=substeps, ideal_sensors=True)
    both = [
        track(drive, controller="darc-2", plant=plant, motion=SHORT, options=options).load_angle
        for plant in ("model-2", own_model_2())
    ]
    return float(np.abs(both[0] - both[1]).max() / DEGREE)


@pytest.mark.parametrize("settings", [(), ("sensors.delay=0.3 ms",)], ids=["prompt", "delayed"])
def test_two_masses_in_plain_python_are_model_2(settings, measured):
    """To the error of the rig's own internal steps, of second order; behind a torque loop to its mean."""
    drive = cd.load_drive("dissertation-3", overrides=[*SMOOTH, "motor.backlash=0", *settings]).listed
    prompt = replace(drive, motor=replace(drive.motor, current_bandwidth=None))
    exact, finer, coarse, fine = gap(prompt, 1), gap(prompt, 12), gap(drive, 1), gap(drive, 12)
    measured(f"{exact:.1e} and {finer:.1e} deg without torque loop; with it {coarse:.1e} and {fine:.1e} deg")
    assert exact < 1e-5, f"observed {exact:.1e} deg"
    assert finer < exact / 8.0, f"observed {exact:.1e} and {finer:.1e} deg"
    assert coarse < 1e-4, f"observed {coarse:.1e} deg"
    assert fine < 0.4 * coarse, f"observed {coarse:.1e} and {fine:.1e} deg"


def test_four_inertias_run_as_model_4_when_the_gear_is_stiff(measured):
    """The gear's link is twenty times the joint's; a hundred times that, and nothing is left of it."""
    chain, options = gearbox(), RigOptions(ideal_sensors=True)
    stiff = replace(chain, stiffness=(100.0 * chain.stiffness[0], *chain.stiffness[1:]))
    model = track(LINEAR, controller="pd", motion=SHORT, options=options).load_angle
    gaps = [
        float(
            np.abs(
                track(LINEAR, controller="pd", plant=one, motion=SHORT, options=options).load_angle - model
            ).max()
        )
        for one in (chain, stiff)
    ]
    measured(f"{gaps[0] / DEGREE:.1e} and {gaps[1] / DEGREE:.1e} deg")
    assert gaps[1] < 0.2 * gaps[0], f"observed {gaps} rad"
    assert gaps[0] < 0.1 * DEGREE, f"observed {gaps} rad"
