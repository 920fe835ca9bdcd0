"""An identified axis on another log: equations integrated here, step by step."""

import numpy as np
import pytest

from command import answer, refusal

RATE, FINE = 1000, 20
TRUTH = (2e-3, 4e-3, 0.02, 0.005)


def logged(path, numbers, hertz, seed):
    """A log of torque and angle of an axis that is driven by sines."""
    inertia, viscous, coulomb, offset = numbers
    rng = np.random.default_rng(seed)
    time = np.arange(20 * RATE * FINE) / (RATE * FINE)
    phases = rng.uniform(0, 2 * np.pi, len(hertz))
    torque = 0.12 * sum(np.sin(2 * np.pi * f * time + p) for f, p in zip(hertz, phases, strict=True))
    angle, speed, angles = 0.0, 0.0, np.empty(time.size)
    for k, tau in enumerate(torque.tolist()):
        angles[k] = angle
        free = speed + (tau - offset - viscous * speed) / (inertia * RATE * FINE)
        rub = coulomb / (inertia * RATE * FINE)
        speed = np.sign(free) * max(abs(free) - rub, 0.0)
        angle += speed / (RATE * FINE)
    counts = np.round(angles[::FINE] / 1e-4) * 1e-4
    rows = np.column_stack([time[::FINE], torque[::FINE] + 1e-4 * rng.standard_normal(counts.size), counts])
    np.savetxt(path, rows, delimiter=",", header="time [s],torque [N m],angle [rad]", comments="", fmt="%.9g")
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
    heavier = logged(tmp_path / "heavier.csv", (1.3 * TRUTH[0], *TRUTH[1:]), (1.1, 3.7), 2)
    found = answer("identify", str(first), "--against", str(heavier))["against"]
    assert found["open_loop"]["relative"] > 0.08
    assert found["closed_loop"]["relative"] > 0.08
    assert not found["cross_test"]["inertia"]["agrees"]
    assert found["cross_test"]["inertia"]["other"] == pytest.approx(1.3 * TRUTH[0], rel=0.03)


def test_another_model_is_refused(first):
    assert "rigid-axis" in refusal(
        "identify", str(first), "--model", "rigid-axis-tanh", "--against", str(first)
    )
