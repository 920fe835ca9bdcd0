"""Pretension that tunes a pair of modes to 1:2, exactly."""

from dataclasses import replace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal import tuning

CONFIGURATION_2 = cd.load_drive("dissertation-2")


def test_tuned_pretension_of_configuration_2(measured):
    """3.28377 N; the modes 2 and 3 at 0.819 N and 0.364 N."""
    found = tuning.tuned_pretension(CONFIGURATION_2)
    measured(f"{found:.6f} N")
    assert found == pytest.approx(3.28377, abs=5e-6)
    weightless = replace(CONFIGURATION_2, layout=replace(CONFIGURATION_2.layout, gravity=0.0))
    tuned = [pair.tuned_pretension for pair in tuning.resonant_pairs(weightless)[:3]]
    np.testing.assert_allclose(tuned, [3.28377, 0.8191, 0.3639], atol=6e-5)


@pytest.mark.parametrize("name", [*cd.packaged_drives("loop", "line")])
def test_every_pair_is_tuned_by_its_pretension(name):
    """Set to its tuned pretension, every pair has the ratio one half; carriages and joints included."""
    drive = cd.load_drive(name)
    for place, pair in enumerate(tuning.resonant_pairs(drive, 2)):
        if pair.tuned_pretension is None:
            assert any(word in pair.reason for word in ("EA", "weights", "slack", "does not settle"))
            continue
        tuned = replace(drive, cable=replace(drive.cable, pretension=pair.tuned_pretension))
        ratio = tuning.resonant_pairs(tuned, 2)[place].ratio
        assert ratio == pytest.approx(0.5, rel=1e-10), f"{pair}"


def test_tuned_pretension_of_a_drive_given_by_its_pulley_distance():
    """There the unstretched length follows the tension; the formula is repeated until it stands."""
    layout = cd.Layout(pulley_distance=1.0)
    drive = replace(CONFIGURATION_2, layout=layout)
    tuned = replace(drive, cable=replace(drive.cable, pretension=tuning.tuned_pretension(drive)))
    ratio = tuning.span_frequency(tuned) / cd.natural_frequencies(tuned, count=1)[0]
    assert ratio == pytest.approx(0.5, rel=1e-12)


def test_no_pretension_tunes_a_pair_that_would_need_the_tension_EA():
    """A heavy mass hanging on the cable swings too slowly for half the pulley mode at any tension."""
    drive = cd.load_drive("camera-line", overrides=["carriage.0.mass=400"])
    first = tuning.resonant_pairs(drive)[0]
    assert first.tuned_pretension is None
    assert "EA" in first.reason
    assert "\n" not in first.reason


@pytest.mark.parametrize("name", ["dissertation-2", "dissertation-3", "ropeway", "camera-line"])
def test_waves_add_up_to_the_mode(name):
    """Slope of each piece, Eq. (A.3), against differences of the shape; its largest displacement."""
    drive = cd.load_drive(name)
    pulley = tuning.pulley_mode(drive)
    for mode in (pulley.mode, *(tuning.section_modes(chain, 3)[2] for chain in transverse_chains(drive))):
        for wave in mode.slope_waves():
            s = wave.start + wave.length * np.array([0.3, 0.30001])
            slope = np.diff(mode.shape(wave.span, s)[0])[0] / np.diff(s)[0]
            exact = wave.slope_at(wave.start + 0.300005 * wave.length).real
            assert abs(slope - exact) < 1e-5 * abs(wave.slope)
            u = mode.shape(wave.span, wave.start + wave.length * np.linspace(0, 1, 4001)[1:-1])[0]
            assert np.max(np.abs(u)) == pytest.approx(wave.largest_displacement, rel=2e-3)
