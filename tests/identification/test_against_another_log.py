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


@pytest.mark.parametrize("factor", [1.0, 1.3])
def test_another_log_tells_whether_the_axis_is_the_same(first, tmp_path, factor):
    truth = TRUTH | {"inertia": factor * TRUTH["inertia"]}
    other = logged(tmp_path / "other.csv", truth, (1.1, 3.7), 2)
    found = answer("identify", str(first), "--against", str(other))["against"]
    for way in ("open_loop", "closed_loop"):
        assert (found[way]["relative"] > 0.08) if factor > 1.0 else (found[way]["relative"] < 0.03)
    agrees = {name: one["agrees"] for name, one in found["cross_test"].items()}
    assert all(agrees.values()) if factor == 1.0 else not agrees["inertia"]
    assert found["cross_test"]["inertia"]["other"] == pytest.approx(truth["inertia"], rel=0.03)


def test_another_model_is_refused(first):
    assert "rigid-axis" in refusal(
        "identify", str(first), "--model", "rigid-axis-tanh", "--against", str(first)
    )
