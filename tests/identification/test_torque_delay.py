"""A torque channel that is late is reported with its delay, not only to first order."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.identification.one_log import identify
from cabledrive.identification.torque_delay import moved_back
from cabledrive.rig.bench.chapter_4 import BENCH_TESTS, bench_command, bench_rig
from cabledrive.rig.bench.virtual_rig import run_rig


@pytest.fixture(scope="module")
def log():
    test, rng = BENCH_TESTS[1], np.random.default_rng(3)
    return run_rig(bench_rig(test), bench_command(test, rng), rng)


def late(log, samples):
    """The torque of a periodic log turned round by whole samples."""
    torque = np.roll(log.channel("torque"), samples)
    return replace(log, channels={**log.channels, "torque": torque})


@pytest.mark.parametrize("samples", [-5, 2])
def test_a_delay_of_a_torque_of_lines_is_estimated_to_a_hundredth_of_a_sample(log, samples, measured):
    """A finding that no habit of logging explains, and no fault of the axis beside it."""
    found = identify(late(log, samples))
    delay = found.method["torque_delay"]
    measured(f"{samples} ms: {1e3 * delay:.4f} ms")
    assert found.codes == ("torque-timing",), found.findings
    assert abs(delay - samples * log.interval) < 0.01 * log.interval, delay


def test_a_torque_of_one_sample_before_is_a_note(log):
    found = identify(late(log, 1))
    assert found.findings == ()
    assert "the torque acts 1 ms earlier than its time stamp" in found.notes[0]


@pytest.mark.parametrize("samples", [-2, 5])
def test_a_delay_of_any_other_torque_is_estimated_to_a_tenth_of_a_sample(log, samples, measured):
    """Cut off in the middle of a period the torque has no lines."""
    found = identify(late(log, samples).part(start=0.1, end=float(log.time[-1]) - 0.1))
    delay = found.method["torque_delay"]
    measured(f"{samples} ms: {1e3 * delay:.3f} ms")
    assert "torque-timing" in found.codes, found.findings
    assert abs(delay - samples * log.interval) < 0.1 * log.interval, delay


def test_a_log_that_is_moved_back_keeps_its_time_and_loses_its_ends(log):
    moved = moved_back(late(log, 3), "torque", 3)
    assert len(moved) == len(log) - 3
    np.testing.assert_array_equal(moved.channel("torque"), log.channel("torque")[:-3])
    np.testing.assert_array_equal(moved.channel("angle"), log.channel("angle")[:-3])
    later = moved_back(late(log, -3), "torque", -3)
    np.testing.assert_array_equal(later.time, log.time[3:])
    np.testing.assert_array_equal(later.channel("torque"), log.channel("torque")[3:])
