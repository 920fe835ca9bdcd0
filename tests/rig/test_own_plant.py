"""Plants of the user's own: any lumped chain, and an object that moves by its own equations."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.models import lumped_model
from cabledrive.reduction.reflected import reflected
from cabledrive.rig import Disturbance, Motion, RigOptions, track
from cabledrive.rig.setting import DEGREE

# Without friction of the motor two linear inertias are left, whose motion any integrator finds.
SMOOTH = (
    "motor.coulomb_friction=0 N m",
    "pulley.0.coulomb_friction=0 N m",
    "pulley.1.coulomb_friction=0 N m",
)
LINEAR = cd.load_drive("dissertation-3", overrides=[*SMOOTH, "motor.backlash=0"])
MODEL_2 = reflected(lumped_model(LINEAR, 2))[0]
SHORT = Motion(angle=5.0, rise=0.15, dwell=0.05, order=11)


def gearbox() -> cd.LumpedChain:
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


def own_model_2(**parts) -> cd.OwnPlant:
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


def gap(drive: cd.Drive, substeps: int) -> float:
    """Largest difference of the load's angle between the packaged Model 2 and the user's [deg]."""
    options = replace(PUSHED, substeps=substeps, ideal_sensors=True)
    both = [
        track(drive, controller="darc-2", plant=plant, motion=SHORT, options=options).load_angle
        for plant in ("model-2", own_model_2())
    ]
    return float(np.abs(both[0] - both[1]).max() / DEGREE)


@pytest.mark.parametrize("settings", [(), ("sensors.delay=0.3 ms",)], ids=["prompt", "delayed"])
def test_two_masses_in_plain_python_are_model_2(settings, measured):
    """To the error of their integration; behind a torque loop to that of the mean torque of each step."""
    drive = cd.load_drive("dissertation-3", overrides=[*SMOOTH, "motor.backlash=0", *settings])
    prompt = replace(drive, motor=replace(drive.motor, current_bandwidth=None))
    exact, finer, coarse, fine = gap(prompt, 1), gap(prompt, 3), gap(drive, 1), gap(drive, 12)
    measured(f"{exact:.1e} and {finer:.1e} deg without torque loop; with it {coarse:.1e} and {fine:.1e} deg")
    assert exact < 1e-6, f"observed {exact:.1e} deg"
    assert finer < exact / 50.0 + 1e-11, f"observed {exact:.1e} and {finer:.1e} deg"
    assert coarse < 1e-4, f"observed {coarse:.1e} deg"
    assert fine < 0.4 * coarse, f"observed {coarse:.1e} and {fine:.1e} deg"


def test_nothing_is_claimed_of_a_plant_whose_parameters_are_unknown():
    own = track(LINEAR, controller="darc-2", plant=own_model_2(), motion=SHORT)
    assert own.summary["plant"] == "two masses"
    assert own.summary["within_bound"] is None
    assert any("two masses" in words for words in own.summary["broken_assumptions"])
    assert own.summary["closed_loop_poles"] is None
    assert own.summary["backlash"] is None
    assert own.tensions is None
    assert own.interpreted == "plant"


def test_an_own_controller_on_an_own_plant():
    def step(gains, state, measurement, reference):
        return state, reference[-1] - 5.0 * (measurement[0] - reference[0]) - 0.05 * (
            measurement[2] - reference[2]
        )

    own = cd.OwnController(step=step, shafts=("motor", "load"))
    options = RigOptions(ideal_sensors=True)
    found = track(LINEAR, controller=own, plant=own_model_2(), motion=SHORT, options=options)
    named = track(LINEAR, controller=own, plant="model-2", motion=SHORT, options=options)
    assert found.interpreted == "controller, plant"
    np.testing.assert_allclose(found.load_angle, named.load_angle, rtol=0.0, atol=1e-6 * DEGREE)


def test_more_states_than_the_shafts_are_the_plants_own():
    def step(parameters, state, torques, time):
        return np.append(two_masses(parameters, state[:4], torques, time), state[4] + time)

    parts = {"step": step, "initial_state": np.zeros(5)}
    plain = track(LINEAR, controller="darc-2", plant=own_model_2(), motion=SHORT)
    more = track(LINEAR, controller="darc-2", plant=own_model_2(**parts), motion=SHORT)
    np.testing.assert_array_equal(plain.load_angle, more.load_angle)


@pytest.mark.parametrize("model", [1, 2, 3, 4])
def test_the_drives_own_lumped_chain_is_its_model(model):
    """With the same figures, the same words and the same verdict on the bound."""
    named = track(LINEAR, controller="darc-4-damped", plant=f"model-{model}", motion=SHORT)
    chain = replace(lumped_model(LINEAR, model), holding=0.0)
    given = track(LINEAR, controller="darc-4-damped", plant=chain, motion=SHORT)
    np.testing.assert_array_equal(named.load_angle, given.load_angle)
    for key in ("broken_assumptions", "within_bound", "theory_bound_deg", "closed_loop_poles"):
        assert named.summary[key] == given.summary[key], key
    assert given.summary["plant"].startswith(f"lumped chain of {chain.size} inertias")


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


def test_a_longer_chain_is_reported_by_the_names_of_its_inertias():
    found = track(LINEAR, controller="darc-4-damped", plant=gearbox(), motion=SHORT, draws=2)
    assert found.summary["plant"] == "lumped chain of 4 inertias: motor, gear, drive, load"
    assert found.summary["within_bound"] is None
    assert any("4 inertias" in words for words in found.summary["broken_assumptions"])
    assert found.angles.shape[1] == 4
    assert found.summary["over_draws"]["failed"] == 0


def bent(parameters, state, torques, time):
    return state[:2]


def broken(parameters, state, torques, time):
    return state * np.nan


@pytest.mark.parametrize(
    "plant, named",
    [
        (own_model_2(step=bent), ["two masses", "shape (2,)", "sample 0"]),
        (own_model_2(step=broken), ["two masses", "not finite", "sample 0"]),
        (own_model_2(step=lambda p, s, u, t: "no"), ["two masses", "sample 0"]),
        (own_model_2(initial_state=np.zeros(3)), ["initial_state", "2 angles"]),
        (own_model_2(shafts=("motor", "gear")), ["shafts", "gear", "('motor', 'load')"]),
        (5, ["plant = 5", "OwnPlant"]),
        (two_masses, ["plant", "OwnPlant"]),
        (cd.OwnPlant, ["plant", "OwnPlant"]),
        ("model-7", ["model-7", "model-1"]),
        (replace(gearbox(), holding=3.0), ["holding", "3"]),
        (replace(gearbox(), names=("motor", "gear", "pulley", "load")), ["drive"]),
        (replace(gearbox(), names=("a", "b", "drive", "d")), ["motor", "load"]),
        (replace(gearbox(), ratios=((1.0, 1.0), (1.0, 1.0), (1.0, 3.0))), ["3", "r2 / r1"]),
        (replace(gearbox(), coulomb=(0.0, 0.01, 0.0, 0.0)), ["0.01", "gear"]),
    ],
)
def test_a_plant_that_does_not_fit_is_one_line(plant, named):
    with pytest.raises(cd.InputRefused) as refusal:
        track(LINEAR, controller="pd", plant=plant, motion=SHORT)
    words = str(refusal.value)
    assert "\n" not in words
    assert all(part in words for part in named), words


def test_draws_of_an_own_plant_and_smoothed_friction_are_refused():
    smooth = RigOptions(smooth_friction=True)
    with pytest.raises(cd.InputRefused, match="draws take"):
        track(LINEAR, controller="pd", plant=own_model_2(), motion=SHORT, draws=3)
    with pytest.raises(cd.InputRefused, match="smooth_friction"):
        track(LINEAR, controller="pd", plant=own_model_2(), motion=SHORT, options=smooth)
