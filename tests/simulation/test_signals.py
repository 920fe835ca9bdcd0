"""Torques and forces: their values, and which are refused."""

import numpy as np
import pytest

from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation import Constant, FromFunction, Multisine, Sampled, Sine, Sweep
from cabledrive.simulation.signals import check_lasts, signal_of

TIME = np.linspace(0.0, 2.0, 4001)


def rate_of_turning(signal, time):
    """Frequency of a unit sine from its phase, by its value and derivative."""
    step = 1e-6
    value, slope = signal.at(time), (signal.at(time + step) - signal.at(time - step)) / (2 * step)
    upright = np.abs(value) < 0.5
    return time[upright], np.abs(slope[upright]) / np.sqrt(1.0 - value[upright] ** 2) / (2.0 * np.pi)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_sweep_runs_through_its_frequencies_and_stays_at_the_last(logarithmic):
    sweep = Sweep(amplitude=1.0, start=20.0, end=80.0, duration=1.5, logarithmic=logarithmic)
    time, frequency = rate_of_turning(sweep, TIME[1:])
    share = np.minimum(time / 1.5, 1.0)
    expected = 20.0 * 4.0**share if logarithmic else 20.0 + 60.0 * share
    np.testing.assert_allclose(frequency, expected, rtol=1e-4)


def test_a_multisine_is_the_sum_of_its_sines():
    sines = [Sine(amplitude=a, frequency=f, phase=p) for a, f, p in ((1.0, 3.0, 0.1), (0.5, 7.0, 0.0))]
    both = Multisine(amplitudes=(1.0, 0.5), frequencies=(3.0, 7.0), phases=(0.1, 0.0))
    np.testing.assert_allclose(both.at(TIME), sum(s.at(TIME) for s in sines), atol=1e-15)


def test_samples_are_met_exactly_and_joined_by_lines_or_held():
    values = np.random.default_rng(0).standard_normal(11)
    at_samples = np.arange(11) / 5.0
    np.testing.assert_array_equal(Sampled(values=values, rate=5.0).at(at_samples), values)
    between = Sampled(values=values, rate=5.0).at(at_samples[:-1] + 0.05)
    np.testing.assert_allclose(between, 0.75 * values[:-1] + 0.25 * values[1:])
    held = Sampled(values=values, rate=5.0, hold=True)
    np.testing.assert_array_equal(held.at(at_samples[:-1] + 0.199), values[:-1])
    assert (held.lasts, Sampled(values=values, rate=5.0).lasts) == (2.2, 2.0)


def test_a_held_sample_begins_at_its_time_whatever_the_rounding():
    """Times computed as step * j meet the samples of a controller, never the one before."""
    held = Sampled(values=np.arange(5001.0), rate=5000.0, hold=True)
    for steps in (3, 7, 17, 34):
        time = np.arange(0, 1000) * steps * (1.0 / 5000.0 / steps)
        np.testing.assert_array_equal(held.at(time), np.arange(1000.0))


def test_numbers_and_functions_are_signals_too():
    np.testing.assert_array_equal(signal_of(0.3, "torque").at(TIME), 0.3)
    np.testing.assert_allclose(signal_of(np.sin, "torque").at(TIME), np.sin(TIME))
    scalar_only = FromFunction(lambda t: 1.0 if t > 1.0 else 0.0)
    np.testing.assert_array_equal(scalar_only.at(TIME), TIME > 1.0)
    assert signal_of(Constant(1.0), "torque") == Constant(1.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Constant(np.nan), "value = nan must be finite"),
        (lambda: Sine(amplitude=1.0, frequency=np.inf), "frequency = inf must be finite"),
        (lambda: Sampled(values=[0.0, np.nan], rate=1.0), "sample 1 is nan"),
        (lambda: Sampled(values=[], rate=1.0), "not a row of samples"),
        (lambda: Sampled(values=[0.0, 1.0], rate=0.0), "rate = 0.0 Hz must be above 0"),
        (lambda: Sweep(amplitude=1.0, start=0.0, end=1.0, duration=1.0, logarithmic=True), "above 0 Hz"),
        (lambda: Sweep(amplitude=1.0, start=0.0, end=1.0, duration=0.0), "duration = 0 s"),
        (lambda: Multisine(amplitudes=(1.0,), frequencies=(1.0, 2.0)), "1 amplitudes, 2 frequencies"),
        (lambda: Multisine(amplitudes=(1.0,), frequencies=(np.nan,)), "not finite"),
        (lambda: signal_of("much", "torque"), "torque is a str"),
        (lambda: check_lasts(Sampled(values=np.zeros(10), rate=10.0), 1.0, "torque"), "torque ends at 0.9 s"),
    ],
)
def test_a_signal_that_makes_no_sense_is_refused(make, words):
    with pytest.raises(InputRefused, match=words):
        make()
