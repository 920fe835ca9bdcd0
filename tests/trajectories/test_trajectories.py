"""The pulse of Section 6.1 and its relatives."""

from fractions import Fraction
from math import pi

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.trajectories import move_limits, pulse, shortest_rise, waypoints
from cabledrive.trajectories.limits import (
    derivative_jump,
    peak_demand,
    peak_factor,
    rise_coefficients,
    smooth_rise,
)

PULSE = pulse(pi / 4, 0.5, 0.5)


def test_ninth_order_coefficients_solve_the_printed_end_conditions():
    """(6.3a)-(6.3e) in exact arithmetic, with theta_f = t_f = 1."""
    a = [Fraction(int(c)) for c in rise_coefficients(9)]
    assert a[:5] == [0] * 5
    for derivative in range(5):
        total = Fraction(0)
        for power, c in enumerate(a):
            factor = 1
            for k in range(derivative):
                factor *= power - k
            total += c * factor
        assert total == (1 if derivative == 0 else 0)


@pytest.mark.parametrize("order", [3, 5, 7, 9, 11, 13, 21])
def test_rise_rests_at_both_ends_up_to_its_order(order):
    n = (order - 1) // 2
    ends = smooth_rise(np.array([0.0, 1.0]), order, n)
    np.testing.assert_array_equal(ends[0], [0.0, 1.0])
    np.testing.assert_array_equal(ends[1:], 0.0)
    jump = smooth_rise(np.array([0.0]), order, n + 1)[-1, 0]
    assert jump == derivative_jump(order)


@pytest.mark.parametrize("derivative", range(1, 7))
def test_derivatives_are_those_of_the_position(derivative):
    """Against central differences of the next lower derivative, at their truncation error."""
    t, h = np.linspace(0.011, 0.489, 97), 1e-5
    lower = PULSE(np.concatenate((t - h, t + h)), derivative - 1)[-1].reshape(2, -1)
    difference = (lower[1] - lower[0]) / (2 * h)
    exact = PULSE(t, derivative)[-1]
    assert np.max(np.abs(difference - exact)) < 1e-6 * PULSE.peak(derivative)


@pytest.mark.parametrize("order", [5, 9, 11])
@pytest.mark.parametrize("derivative", [1, 2, 3, 4])
def test_peak_factors_are_the_largest_values(order, derivative):
    fine = np.max(np.abs(smooth_rise(np.linspace(0, 1, 200_001), order, derivative)[-1]))
    assert peak_factor(order, derivative) == pytest.approx(fine, rel=1e-8)


def test_figures_of_the_pulse_of_45_degrees():
    """Half a second of rise: 3.87 rad/s at most, a jump of 3.8e5 rad/s^5 in the fifth derivative."""
    assert PULSE.peak(1) == pytest.approx(630 / 256 * (pi / 4) / 0.5, rel=1e-12)
    assert PULSE.peak(1) == pytest.approx(3.87, abs=0.005)
    assert PULSE.jump == pytest.approx(3.8e5, rel=1e-2)
    assert PULSE.duration == 2.0


def test_pulse_goes_there_and_comes_back_exactly():
    """(6.8), with its dwell in between."""
    ten = pulse(pi / 4, 0.5, 0.5, pulses=10)
    np.testing.assert_allclose(
        ten(np.array([0.0, 0.75, 2.0, 18.75, 20.0]))[0], [0, pi / 4, 0, pi / 4, 0], atol=1e-15
    )


def test_shortest_rise_meets_the_binding_limit_and_no_other_is_broken():
    limits = move_limits(cd.load_drive("dissertation-3"))
    rise, binding = shortest_rise(limits, pi / 4)
    demand = peak_demand(limits, pi / 4, rise)
    assert demand[binding] == pytest.approx(getattr(limits, binding), rel=1e-12)
    assert all(demand[name] <= getattr(limits, name) * (1 + 1e-12) for name in demand)
    assert binding == "slack_torque", "a span goes slack at 0.56 N m, long before 2.1 N m"


def test_speed_limit_alone_gives_the_rise_time_in_closed_form():
    limits = move_limits(
        cd.load_drive("dissertation-3", overrides=["cable.pretension=1000", "motor.torque_limit=1000"])
    )
    rise, binding = shortest_rise(limits, pi)
    assert binding == "speed"
    assert rise == pytest.approx(630 / 256 * pi / limits.speed, rel=1e-12)


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda: pulse(1.0, 0.0, 0.5), "rise"),
        (lambda: pulse(1.0, 0.5, -1.0), "dwell"),
        (lambda: pulse(1.0, 0.5, 0.5, pulses=0), "pulses"),
        (lambda: pulse(1.0, 0.5, 0.5, order=8), "order"),
        (lambda: pulse(np.nan, 0.5, 0.5), "positions"),
        (lambda: waypoints([0.0, 1.0], rise=[1.0, 2.0], dwell=0.0), "rise"),
        (lambda: waypoints([0.0], rise=1.0, dwell=0.0), "positions"),
        (lambda: shortest_rise(move_limits(cd.load_drive("dissertation-3")), 0.0), "angle"),
    ],
)
def test_bad_motions_are_refused_in_one_line(call, word):
    with pytest.raises(cd.InputRefused, match=word) as refusal:
        call()
    assert "\n" not in str(refusal.value)
