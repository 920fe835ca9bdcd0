"""What the reduced models refuse, and runs that they end: each row a call, and what is named."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.fast_members import fast_ensemble
from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast
from cabledrive.reduction.friction_integration import direction, integrate_chain
from cabledrive.reduction.lumped_chain import lumped_model, to_control
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.threshold import growth_torque
from cabledrive.reduction.uniform_tension import uniform_tension_model
from cabledrive.simulation import Pluck, Sine, Start
from network_samples import route
from resonance_samples import TUNED

SENSORS = ("sensors.sample_rate=5000", "sensors.motor_encoder=4000", "sensors.load_encoder=4000")
DRIVE = cd.load_drive("dissertation-2", overrides=["cable.pretension=3.26", "cable.transverse_damping=2"])
RIG = cd.load_drive("dissertation-3")
HELD = replace(RIG, motor=replace(RIG.motor, holding_stiffness=25.0))


def over(axes):
    return lambda: fast_ensemble(DRIVE, 0.05, axes, common={"torque_amplitude": 0.01})


def without_fit(*overrides):
    return lambda: uniform_tension_model(cd.load_drive("dissertation-2", overrides=overrides))


ROWS = [
    (lambda: autoparametric_model(TUNED, load_torque=1.0), ["lower span"]),
    (over({"pretention": [1.0]}), ["pretention", "pretension"]),
    (over({"torque_frequency": [80.0, 900.0]}), ["torque", "676.6 Hz"]),
    (over({"pretension": [np.nan]}), ["pretension", "finite", "N"]),
    (lambda: simulate_fast(DRIVE, 5000.0), ["GB", "4 GB", "rate"]),
    (lambda: simulate_fast(DRIVE, 0.1, torque=Sine(amplitude=0.01, frequency=900.0)), ["torque", "676.6 Hz"]),
    (lambda: growth_torque(autoparametric_model(TUNED), 1.0, 1.0), ["factor"]),
    (lambda: growth_torque(autoparametric_model(TUNED), 10.0, 0.0), ["duration"]),
    (without_fit("pulley.0.coulomb_friction=0.01"), ["coulomb_friction"]),
    (without_fit("pulley.1.fixed=true"), ["fixed"]),
    (without_fit("kind=line"), ["loop"]),
    (lambda: integrate_chain(lumped_model(HELD), np.zeros(5), 1e-3), ["holding stiffness = 25 N m/rad"]),
    (lambda: direction(2, "mass"), ["mass", "inertia"]),
    (lambda: lumped_model(cd.load_drive("dissertation-2"), 4), ["model", "4"]),
    (lambda: lumped_model(cd.load_drive("dissertation-transporter"), 3), ["model", "carriages", "1"]),
    (lambda: lumped_model(RIG, 5), ["model", "5"]),
    (lambda: as_axis(route("finger")), ["springs or ropes hold"]),
    (lambda: as_axis(route("serpentine")), ["0 given"]),
    (lambda: cd.simulate(as_axis(route("printer", *SENSORS)), 0.1), ["spans"]),
    (lambda: cd.resonance(as_axis(route("printer", *SENSORS))), ["spans"]),
]


@pytest.mark.parametrize("call, named", ROWS)
def test_what_cannot_be_reduced_is_refused_in_one_line_that_names_it(call, named):
    with pytest.raises(cd.InputRefused) as refused:
        call()
    words = str(refused.value)
    assert "\n" not in words
    assert all(part in words for part in named), words


def test_without_python_control_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(cd.InputRefused, match=r"\[control\]"):
        to_control(lumped_model(RIG, 4))


STEEP = Start(plucks=tuple(Pluck(height=0.02, span=span) for span in ("upper", "lower")))


@pytest.mark.parametrize(
    "choices, cause",
    [
        ({"torque": Sine(amplitude=2.0, frequency=81.7)}, "slack at t ="),
        ({"start": STEEP, "scheme": FastScheme(sines=1)}, "slope"),
        ({"start": Start(plucks=(Pluck(height=0.1),))}, "at t ="),  # it diverges
    ],
)
def test_a_motion_beyond_the_model_ends_with_its_cause_and_keeps_what_came_before(choices, cause):
    result = simulate_fast(DRIVE, 0.2, **choices)
    assert cause in result.stopped
    assert bool(result.slack_events) == ("slack" in result.stopped)
    assert 0 < result.time.size < 0.2 * 5000
    assert np.all(np.isfinite(result.rows))
    assert result.steps * result.step == pytest.approx(result.time[-1])
