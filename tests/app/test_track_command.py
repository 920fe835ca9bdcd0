"""`cabledrive track`: the contract's object, its refusals, and its log."""

import pytest

from command import answer, call, refusal

KEYS = {
    *("controller", "gains", "plant", "observer", "peak_error_deg", "rms_error_deg", "peak_torque"),
    *("saturated_fraction", "theory_bound_deg", "within_bound", "broken_assumptions"),
    *("estimates_within_bounds", "first_pulse_error_deg", "later_pulses_error_deg"),
}
FAST = ("--angle", "10", "--rise", "0.2", "--dwell", "0.05")


def test_json_has_what_the_contract_promises():
    found = answer("track", "dissertation-3", "--controller", "darc-4", *FAST)
    assert set(found) >= KEYS
    assert found["plant"] == "model-4"
    assert found["estimates_within_bounds"] is True
    assert found["later_pulses_error_deg"] is None
    assert found["provenance"]["seed"] == 0


def test_ideal_states_and_a_damped_law_keep_the_bound():
    found = answer("track", "dissertation-3", "--controller", "darc-4-damped", "--ideal-sensors")
    assert found["broken_assumptions"] == []
    assert found["within_bound"] is True
    assert found["peak_error_deg"] < found["theory_bound_deg"]


def test_settings_of_the_plant_leave_the_law_alone():
    wrong = ("--plant-set", "pulley.1.inertia=0.0025")
    found = answer(
        "track", "dissertation-3", "--controller", "darc-4-damped", "--ideal-sensors", *FAST, *wrong
    )
    assert any("unmatched" in words for words in found["broken_assumptions"])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--controller", "darc4"], 'did you mean "darc-4"'),
        (["--controller", "darc-2", "--bandwidth", "4"], "below 12 Hz"),
        (["--angle", "3000"], "take longer, turn less"),
        (["--rise", "0"], "rise = 0 s must be finite and above 0"),
        (["--pulses", "0"], "pulses = 0 must be at least 1"),
        (["--set", "sensors.sample_rate=200 Hz"], "sample faster"),
    ],
)
def test_wishes_that_cannot_be_are_refused_in_one_line(arguments, words):
    assert words in refusal("track", "dissertation-3", *arguments)


def test_log_has_units_in_its_header(tmp_path):
    path = tmp_path / "run.csv"
    call("track", "dissertation-3", *FAST, "--log", str(path))
    lines = path.read_text().splitlines()
    assert lines[0].startswith("time [s],torque [N m],motor angle [rad]")
    assert len(lines) == 2502
