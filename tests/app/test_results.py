"""JSON holds finite numbers only; where there is none, null and the reason beside it."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cabledrive as cd
from cabledrive.app.results import Absent, Answer, json_text, plain, provenance
from command import object_of


def test_number_that_does_not_exist_is_null_with_its_reason():
    assert plain({"bound": Absent(reason="broken assumption")}) == {
        "bound": None,
        "bound_reason": "broken assumption",
    }


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -np.inf, np.float64("nan")])
def test_number_that_is_not_finite_is_null_with_a_reason(value):
    assert plain({"x": value}) == {"x": None, "x_reason": "not a finite number"}
    assert plain({"x": [1.0, value]}) == {"x": [1.0, None], "x_reason": "not a finite number"}


def test_arrays_and_dataclasses_become_plain():
    @dataclass(frozen=True)
    class Range:
        low: float
        high: np.ndarray

    found = plain(
        {"range": Range(low=np.float64(1.5), high=np.array([[1, 2]])), "n": np.int64(3), "ok": np.True_}
    )
    assert found == {"range": {"low": 1.5, "high": [[1, 2]]}, "n": 3, "ok": True}
    assert json.loads(json.dumps(found)) == found


def test_reason_that_is_there_is_left_alone():
    assert plain({"chi1": None, "reasons": {"chi1": "fixed"}}) == {"chi1": None, "reasons": {"chi1": "fixed"}}


values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=10,
)


@given(data=st.dictionaries(st.text(), values, max_size=4))
@settings(max_examples=50)
def test_whatever_is_found_becomes_one_json_object_in_ascii(data):
    text = json_text(Answer(data=data, text="", provenance=provenance()))
    assert text.isascii()
    assert object_of(text)["provenance"] == {"cabledrive": cd.__version__}


def test_provenance_names_step_tolerances_and_seed_where_there_are_any():
    drive = cd.load_drive("elevator")
    message = provenance(drive, method="splitting", step=1e-5, tolerances={"energy": 1e-9}, seed=0)
    assert message == {
        "cabledrive": cd.__version__,
        "drive": drive.name,
        "drive_hash": cd.content_hash(drive),
        "method": "splitting",
        "step": 1e-5,
        "tolerances": {"energy": 1e-9},
        "seed": 0,
    }
