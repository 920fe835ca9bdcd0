"""`cabledrive resonance`: what the contract promises, reasons beside nulls, the page."""

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.studies.resonance import resonance
from command import answer, call


@pytest.mark.parametrize("drive", ["dissertation-2", pytest.param("linear-axis", marks=pytest.mark.verify)])
def test_people_and_programs_get_frequencies_in_hz(drive):
    """Detuning and half-width of the instability region: the averaged equations have them in rad/s."""
    instability = resonance(load_drive(drive)).instability
    found = answer("resonance", drive)
    region = found["instability_region"]
    for key, value in (("detuning_hz", instability.distance), ("half_width_hz", instability.half_width)):
        assert region[key] == pytest.approx(value / (2 * np.pi), rel=1e-12)
    text = call("resonance", drive).stdout
    assert f"is detuned from 1:2 by {region['detuning_hz']:.4g} Hz" in text
    assert "rad/s" not in text


TUNED = ("--set", "cable.pretension=3.28377 N", "--set", "cable.transverse_damping=2")
DAMPED = (*TUNED, "--set", "pulley.1.viscous_friction=6e-5")


def test_a_motion_that_excites_the_cable_is_dangerous(tmp_path):
    """Two seconds of a sine at the pulley mode's frequency."""
    rows = [f"{t / 4},{50 * np.sin(2 * np.pi * 0.0817421 * t / 4)}" for t in range(8000)]
    path = tmp_path / "motion.csv"
    path.write_text("\n".join(["time [ms],torque [mN m]", *rows]) + "\n")
    found = answer("resonance", "dissertation-2", *DAMPED, "--motion", path)["motion"]
    assert found["verdict"] == "dangerous"
    assert found["limit"] == 5e-4
    assert found["largest_transverse"] > 5e-4
    assert found["modes"][0]["number"] == 1
    assert found["modes"][0]["excitation"] == "parametric"
    assert "damp the cable" in found["remedy"]


def test_a_steady_load_splits_the_tuning_of_the_spans():
    """dT = 2 tau / (2 r) apart: the mean tensions that tune the spans lie as far apart as their tensions."""
    found = answer("resonance", "dissertation-2", *TUNED, "--load-torque", "1 mN m")
    split = found["tuned_pretension_under_load"]
    assert split["lower"] - split["upper"] == pytest.approx(1e-3 / 0.03, rel=0.02), split
    assert found["tuned_pretension"] == pytest.approx(3.28377, rel=1e-5)


def test_branches_without_damping_end_with_status_3_and_keep_the_rest():
    result = call("resonance", "dissertation-2", "--torque", "40 mN m", "--branches", "--json")
    assert result.exit_code == 3
    assert "undamped" in result.stderr
    assert '"threshold_torque": 0' in result.stdout


def test_a_trial_that_would_slacken_a_span_is_no_remedy():
    """The lift at half its pretension hangs slack beside the car: that change is left out."""
    assert answer("resonance", "elevator")["verdict"] == "no excitation given"
    found = answer("resonance", "elevator", "--set", "excitation.torque_ripple=1")
    assert found["verdict"] == "resonant"
    assert found["threshold_torque"] > 0.0
    assert any("keep the torque" in one["text"] for one in found["remedies"]), found["remedies"]
