"""Input shapers against textbooks and against a simulated oscillator that knows nothing of them."""

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from cabledrive.parameters import InputRefused
from cabledrive.trajectories import input_shaper, residual_vibration, smoothing
from cabledrive.trajectories.input_shaping import LARGEST_DAMPING, insensitive_band

TYPES = tuple(LARGEST_DAMPING)


def simulated_residual(shaper, frequency, damping):
    """Amplitude of a damped oscillator after a shaped step of its input, over that after the step alone.

    Exact between samples, as the input is constant there; the amplitude is that of the decaying oscillation
    at the time of the last impulse.
    """
    omega = 2 * pi * frequency
    oscillator = signal.StateSpace(
        [[0, 1], [-(omega**2), -2 * damping * omega]], [[0], [omega**2]], np.eye(2), np.zeros((2, 1))
    )

    def amplitude(times, sizes):
        state, level = np.zeros(2), 0.0
        for k, size in enumerate(sizes):
            level += size
            if k + 1 < len(times) and times[k + 1] > times[k]:
                t = np.linspace(0.0, times[k + 1] - times[k], 3)
                state = signal.lsim(oscillator, np.full(3, level), t, X0=state)[2][-1]
        damped = omega * np.sqrt(1.0 - damping**2)
        offset = state[0] - level
        return np.hypot(offset, (state[1] + damping * omega * offset) / damped)

    return amplitude(shaper.times, shaper.amplitudes) / amplitude([0.0], [1.0])


@settings(max_examples=25)
@given(
    type=st.sampled_from(TYPES),
    design=st.floats(0.0, 0.2),
    damping=st.floats(0.0, 0.4),
    ratio=st.floats(0.3, 2.5),
)
def test_residual_vibration_is_that_of_a_simulated_oscillator(type, design, damping, ratio):
    shaper = input_shaper(type, 37.0, design)
    formula = residual_vibration(shaper, np.array([37.0 * ratio]), damping)[0]
    observed = simulated_residual(shaper, 37.0 * ratio, damping)
    assert formula == pytest.approx(observed, abs=1e-8), f"{formula} against {observed}"


@pytest.mark.parametrize("type", ["zv", "mzv", "zvd"])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.3, 0.9])
def test_zero_vibration_shapers_leave_nothing_at_the_design(type, damping):
    left = residual_vibration(input_shaper(type, 60.0, damping), np.array([60.0]), damping)[0]
    assert left < 1e-14, left


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.1, 0.2])
def test_ei_leaves_five_per_cent_at_the_design_and_nothing_at_two_frequencies_beside_it(damping):
    shaper = input_shaper("ei", 50.0, damping)
    assert residual_vibration(shaper, np.array([50.0]), damping)[0] == pytest.approx(0.05, abs=0.0015)
    for side in (np.linspace(40.0, 50.0, 2001), np.linspace(50.0, 60.0, 2001)):
        least = residual_vibration(shaper, side, damping).min()
        assert least < 0.005, f"observed {least:.4f}"


@pytest.mark.parametrize(
    ("type", "width"),
    [("zv", 0.065), ("zvd", 0.286), ("ei", 0.399), ("2hump_ei", 0.726), ("3hump_ei", 0.954)],
)
def test_widths_of_insensitivity_are_those_of_the_textbooks(type, width):
    """Widths at 5 % over the frequency, without damping, after Singhose and others.

    The fit of the three humps, held by the firmware, passes 5 % by a little and is wider by 0.012.
    """
    ratio = np.linspace(0.4, 1.6, 120_001)
    shaper = input_shaper(type, 1.0, 0.0)
    left = residual_vibration(shaper, ratio, 0.0)
    within = ratio[left <= 0.05]
    observed = within[-1] - within[0]
    assert observed == pytest.approx(width, abs=0.013 if type == "3hump_ei" else 0.004), (
        f"observed {observed:.4f}"
    )
    # Between them the humps of the fits pass 5 % by little.
    assert left[(ratio >= within[0]) & (ratio <= within[-1])].max() < 0.054
    low, high = insensitive_band(shaper)
    assert high - low == pytest.approx(width, abs=0.02), f"observed {high - low:.4f}"


@given(
    type=st.sampled_from(TYPES),
    frequency=st.floats(20.0, 150.0),
    acceleration=st.floats(0.1, 50.0),
    speed=st.floats(0.0, 0.02),
)
def test_smoothing_is_the_deviation_of_the_shaped_path(type, frequency, acceleration, speed):
    """Of the shaped motion at its mean delay: at a reversal, and at a right angle passed at a speed."""
    shaper = input_shaper(type, frequency)
    time = shaper.amplitudes @ shaper.times - shaper.times
    reversal = shaper.amplitudes @ (acceleration * time**2 / 2)
    braking = np.where(time < 0.0, speed * time - acceleration * time**2 / 2, 0.0)  # to the corner at time 0
    expected = max(abs(reversal), np.sqrt(2.0) * abs(shaper.amplitudes @ braking))
    observed = smoothing(shaper, acceleration, speed)
    assert observed == pytest.approx(expected, rel=1e-12), f"{observed} against {expected}"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("zvdd", 50.0), 'shaper "zvdd" is unknown'),
        (("zv", 0.0), "frequency = 0 Hz"),
        (("zv", float("nan")), "frequency = nan Hz"),
        (("3hump_ei", 50.0, 0.3), "must lie from 0 to 0.2"),
        (("zv", 50.0, -0.1), "must lie from 0 to 0.99"),
    ],
)
def test_a_shaper_that_does_not_exist_is_refused(arguments, words):
    with pytest.raises(InputRefused, match=words):
        input_shaper(*arguments)
