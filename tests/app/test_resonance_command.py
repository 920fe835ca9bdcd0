"""`cabledrive resonance`: what the contract promises, reasons beside nulls, the page."""

import pytest

from command import answer, call, refusal


def test_answer_has_what_the_contract_promises():
    found = answer("resonance", "dissertation-2")
    assert found["tuned_pretension"] == pytest.approx(3.28377, abs=5e-6)
    assert found["frequency_ratio"] == pytest.approx(0.6165, abs=1e-4)
    assert found["detuning"] == pytest.approx(found["frequency_ratio"] - 0.5)
    assert found["threshold_torque"] == 0
    assert found["verdict"] == "safe"
    assert found["provenance"]["drive_hash"]


def test_at_the_tuned_pretension_the_drive_is_resonant():
    settings = ("--set", "cable.pretension=3.28377 N", "--torque", "10 mN m")
    assert answer("resonance", "dissertation-2", *settings)["verdict"] == "resonant"


def test_no_pulley_mode_is_no_error():
    settings = ("--set", "pulley.0.fixed=true", "--set", "pulley.1.fixed=true")
    found = answer("resonance", "dissertation-2", *settings)
    for key in ("frequency_ratio", "tuned_pretension", "threshold_torque", "detuning"):
        assert found[key] is None
        assert found[f"{key}_reason"]
    assert found["verdict"] == "safe"


def test_map_is_one_page(tmp_path):
    page = tmp_path / "map.html"
    result = call("resonance", "dissertation-2", "--torque", "5 mN m", "--map", str(page))
    assert result.exit_code == 0
    assert "verdict: safe" in result.stdout
    assert page.read_text().startswith("<!doctype html>")
    assert "exists" in refusal("resonance", "dissertation-2", "--map", str(page))


def test_negative_torque_is_refused_in_one_line():
    assert "negative" in refusal("resonance", "dissertation-2", "--torque=-1")


def test_text_for_people_names_pairs_and_remedies():
    settings = ("--set", "cable.transverse_damping=2", "--set", "pulley.1.viscous_friction=2e-5")
    settings += ("--set", "cable.pretension=3.3", "--torque=0.01")
    text = call("resonance", "dissertation-2", *settings).stdout
    assert "raise the pretension" in text
    assert "tuned at 3.28" in text
