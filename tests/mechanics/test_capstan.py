"""What a pulley transmits by friction."""

from math import exp, pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cabledrive.mechanics.datasheet import no_slip_torque

frictions = st.floats(0.01, 1.0)
angles = st.floats(0.1, 8.0)


def test_no_slip_torque_of_half_a_turn():
    """2 r T0 (e - 1)/(e + 1) with e = 2.566: 0.4391 of the slack torque."""
    assert no_slip_torque(0.03, 5.0, 0.3, pi) == pytest.approx(0.3 * 1.566 / 3.566, rel=2e-4)


@given(friction=frictions, angle=angles)
def test_at_the_no_slip_torque_the_tensions_stand_in_the_capstan_ratio(friction, angle):
    """T0 + d and T0 - d with r 2d = torque."""
    half = no_slip_torque(0.04, 7.0, friction, angle) / (2.0 * 0.04)
    assert (7.0 + half) == pytest.approx(exp(friction * angle) * (7.0 - half), rel=1e-9, abs=1e-12)


@given(friction=st.floats(0.0, 1e3), angle=st.floats(0.0, 1e3))
def test_loop_slips_before_it_goes_slack(friction, angle):
    assert 0.0 <= no_slip_torque(0.04, 7.0, friction, angle) <= 2.0 * 0.04 * 7.0


def test_without_friction_nothing_is_transmitted():
    assert no_slip_torque(0.04, 7.0, 0.0, pi) == 0.0
