"""What `response` says of its coherence, against the textbook's value for a gain with noise added."""

import numpy as np
import pytest

from command import call, object_of


def written(path, coherence):
    """White input through a gain of two, with as much white noise as makes this coherence."""
    rng = np.random.default_rng(1)
    torque = rng.standard_normal(40_000)
    noise = 2.0 * np.sqrt(1.0 / coherence - 1.0) * rng.standard_normal(torque.size)
    rows = np.column_stack([1e-3 * np.arange(torque.size), torque, 2.0 * torque + noise])
    np.savetxt(path, rows, delimiter=",", header="time [s],torque [N m],speed [rad/s]", comments="")
    return path


@pytest.mark.parametrize("coherence", [0.23, 0.95])
def test_the_median_coherence_is_printed_and_a_low_one_warned_of(coherence, tmp_path, measured):
    log = written(tmp_path / "log.csv", coherence)
    arguments = (
        "response",
        log,
        "--input",
        "torque [N m]",
        "--response",
        "speed [rad/s]",
        "--segment",
        "0.25s",
    )
    said = call(*arguments).output
    printed = float(said.split("coherence ")[1].split()[0])
    measured(f"coherence {printed} for {coherence}")
    assert printed == pytest.approx(coherence, abs=0.03)
    warnings = object_of(call(*arguments, "--json").stdout)["warnings"]
    assert ("warning: coherence" in said) == (coherence < 0.8) == bool(warnings)
