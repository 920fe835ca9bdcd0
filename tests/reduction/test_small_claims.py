"""Limits and sizes that models of the loop state: slack, a span outside a mode, the length of the cable."""

import re

import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.sagging_model import _fixed_length
from cabledrive.reduction.transverse_sections import largest_slope, span_tensions

DRIVE = load_drive("dissertation-2")


def test_the_stated_limit_of_the_load_torque_is_where_a_span_goes_slack():
    with pytest.raises(InputRefused) as refused:
        span_tensions(DRIVE, 1e3)
    limit = float(re.search(r"stay below (\S+) N m", str(refused.value))[1])
    assert 0.0 < min(span_tensions(DRIVE, 0.999 * limit).values()) < 2e-3 * DRIVE.cable.pretension
    with pytest.raises(InputRefused):
        span_tensions(DRIVE, 1.001 * limit)


def test_a_span_outside_a_mode_is_not_strained():
    assert largest_slope((), "upper") == 0.0


def test_the_cable_of_a_loop_is_as_long_as_its_stretched_spans():
    stretched = 1.0 + DRIVE.cable.pretension / DRIVE.cable.axial_rigidity
    assert _fixed_length(DRIVE) == pytest.approx(2.0 * DRIVE.span_length * stretched, rel=1e-12)
