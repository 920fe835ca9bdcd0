"""Gains, bounds and models that no law takes: each row a call, and what its refusal names."""

import numpy as np
import pytest

from cabledrive.control.backstepping import backstepping_numbers
from cabledrive.control.darc import Bounds, darc_gains
from cabledrive.parameters import InputRefused
from control_chains import INTERVAL, model

ROWS = [
    (lambda: darc_gains(2, 5.0), ["5", "12 Hz"]),
    (lambda: darc_gains(4, -3.0), ["-3", "above 0"]),
    (lambda: darc_gains(4, float("nan")), ["nan", "above 0"]),
    (
        lambda: Bounds(nominal=np.ones(4), low=np.array([2.0, 0, 0, 0]), high=np.full(4, 3.0)),
        ["outside 2 to 3"],
    ),
    (lambda: backstepping_numbers(model(4), -1.0, 0.0, INTERVAL), ["bandwidth", "-1"]),
    (lambda: backstepping_numbers(model(4), float("nan"), 0.0, INTERVAL), ["bandwidth", "nan"]),
]


@pytest.mark.parametrize("call, named", ROWS)
def test_what_no_law_takes_is_refused_by_name_and_number(call, named):
    with pytest.raises(InputRefused) as refused:
        call()
    words = str(refused.value)
    assert "\n" not in words
    assert all(part in words for part in named), words
