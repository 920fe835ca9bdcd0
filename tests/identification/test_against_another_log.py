"""An identified axis on another log, both from the plant of `oracles.axis_plant`."""

import numpy as np
import pytest

from command import answer, refusal
from oracles.axis_plant import move, parameters

TRUTH = {"inertia": 2e-3, "viscous": 4e-3, "coulomb": 0.02, "offset": -0.005}


def logged(path, numbers, hertz, seed):
    """A log of 20 s at 1 kHz of torque and angle of an axis that is driven by sines."""
    rng, time, angle = np.random.default_rng(seed), 1e-3 * np.arange(20_000), np.empty(20_000)
    phases = rng.uniform(0, 2 * np.pi, len(hertz))
    torque = 0.12 * np.sin(2 * np.pi * np.outer(time, hertz) + phases).sum(axis=1)
    nothing = np.zeros((3, time.size)), np.zeros(6), np.zeros(4)  # no reference, servo and sensor
    move(parameters(**numbers), torque, 0 * time, *nothing, 1e-3, 4, 1, angle, np.empty(time.size))
    rows = [time, torque + 1e-4 * rng.standard_normal(time.size), np.round(angle / 1e-4) * 1e-4]
    head = "time [s],torque [N m],angle [rad]"
    np.savetxt(path, np.transpose(rows), delimiter=",", header=head, comments="", fmt="%.9g")
    return path


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    return logged(tmp_path_factory.mktemp("axis") / "first.csv", TRUTH, (0.7, 2.3, 6.1), 1)


def test_another_log_of_the_same_axis_is_reproduced(first, tmp_path):
    other = logged(tmp_path / "other.csv", TRUTH, (1.1, 3.7), 2)
    found = answer("identify", str(first), "--against", str(other))["against"]
    assert found["open_loop"]["relative"] < 0.03
    assert found["closed_loop"]["relative"] < 0.03
    assert all(one["agrees"] for one in found["cross_test"].values())


def test_another_log_of_a_heavier_axis_is_not(first, tmp_path):
    heavier = logged(tmp_path / "heavier.csv", TRUTH | {"inertia": 1.3 * TRUTH["inertia"]}, (1.1, 3.7), 2)
    found = answer("identify", str(first), "--against", str(heavier))["against"]
    assert found["open_loop"]["relative"] > 0.08
    assert found["closed_loop"]["relative"] > 0.08
    assert not found["cross_test"]["inertia"]["agrees"]
    assert found["cross_test"]["inertia"]["other"] == pytest.approx(1.3 * TRUTH["inertia"], rel=0.03)


def test_another_model_is_refused(first):
    assert "rigid-axis" in refusal(
        "identify", str(first), "--model", "rigid-axis-tanh", "--against", str(first)
    )
