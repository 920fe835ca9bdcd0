"""Both spans sound in one recording: two families of partials, two tensions, or one line why not.

Recordings are made by the exact loop.
"""

import json

import numpy as np
import pytest
from scipy.io import wavfile

from cabledrive.app.main import main
from cabledrive.identification.filters import zero_phase
from cabledrive.identification.logs.log import log_of
from cabledrive.identification.tension import tension_of_both
from cabledrive.identification.tension.decaying_tones import Tones, fit_tones
from cabledrive.parameters import NotComputed
from played_spans import SPANS, carrying, errors, played


def called(capsys, *arguments):
    """Status, standard output and standard error of one call."""
    try:
        status = main([str(a) for a in arguments])
    except SystemExit as end:
        status = end.code
    printed = capsys.readouterr()
    return status or 0, printed.out, printed.err


@pytest.mark.parametrize("seed", [10_000, 10_001])
def test_both_tensions_of_the_exact_loop_come_out_within_one_per_cent(seed):
    """Noise 5 %: both values, without labels since the spans have the same modes, and the torque between."""
    one = played(seed)
    found = tension_of_both(one.log, one.drive)
    assert set(found.families) == {"tauter", "looser"}, found.unidentifiable
    assert max(map(abs, errors(found, one).values())) < 0.002, errors(found, one)
    torque = one.drive.drive_pulley.radius * abs(one.lower - one.upper)
    assert found.standing_torque.value == pytest.approx(torque, rel=0.02)
    assert found.pretension.value == pytest.approx(0.5 * (one.upper + one.lower), rel=0.002)
    assert "same modes" in found.unidentifiable[0]
    assert found.as_dict()["parameters"]["tension_tauter"]["unit"] == "N"


@pytest.mark.parametrize("plucked", SPANS)
def test_the_louder_family_is_that_of_the_span_that_was_plucked_harder(plucked):
    """A positive standing torque makes the upper span looser, whichever was plucked."""
    heights = (2e-3, 0.7e-3) if plucked == "upper" else (0.7e-3, 2e-3)
    one = played(10_010, heights=heights, share=0.1, loudness=(1.0, 1.0))
    found = tension_of_both(one.log, one.drive, plucked=plucked)
    assert found.labelled
    assert max(map(abs, errors(found, one).values())) < 0.002, errors(found, one)
    assert found.standing_torque.value > 0.0, "upper looser: the torque is positive"


def test_equal_tensions_are_one_family_and_the_line_says_so():
    one = played(10_020, share=0.0, rate=1000.0)
    found = tension_of_both(one.log, one.drive)
    assert not found.identifiable
    assert "one family" in found.unidentifiable[0]
    assert "\n" not in found.unidentifiable[0]
    low, high = found.families["heard"].tension.low, found.families["heard"].tension.high
    assert low < one.upper < high, (low, one.upper, high)
    assert np.isnan(found.standing_torque.value)


def test_tensions_within_a_line_width_are_not_separated_and_both_lie_in_the_interval():
    """0.3 % between them, 0.15 Hz of 101 Hz, where a line is 1.3 Hz wide."""
    one = played(10_021, pretension=7.0, share=0.0015, damping=4.0, rate=1000.0)
    found = tension_of_both(one.log, one.drive)
    assert not found.identifiable, errors(found, one)
    prepared = found.families["heard"].tension
    assert prepared.low < min(one.upper, one.lower) < max(one.upper, one.lower) < prepared.high, prepared


def test_a_span_that_sounds_alone_is_one_family():
    """With the plucked span named, the tension has its name and its narrow interval."""
    one = played(10_022, heights=(2e-3, 0.0), share=0.15, rate=1000.0)
    found = tension_of_both(one.log, one.drive)
    assert list(found.families) == ["heard"]
    assert "one family" in found.unidentifiable[0]
    named = tension_of_both(one.log, one.drive, plucked="upper")
    assert named["upper"] == pytest.approx(one.upper, rel=0.002)
    width = [f.high - f.low for f in (named.families["upper"].tension, found.families["heard"].tension)]
    assert width[0] < 0.2 * width[1], width


@pytest.mark.parametrize("share", [0.15, 0.0])
def test_a_hanging_carriage_gives_the_labels_by_its_modes(share):
    """No word on what was plucked, at equal tensions too: the ratios of the partials say which span it is."""
    one = played(10_050, drive=carrying(), share=share, probe=0.19)
    found = tension_of_both(one.log, one.drive)
    assert found.labelled
    assert max(map(abs, errors(found, one).values())) < 0.002, errors(found, one)


def test_beside_a_carrying_span_the_silent_one_is_named():
    one = played(10_051, drive=carrying(), heights=(0.0, 1e-3), probe=0.19)
    found = tension_of_both(one.log, one.drive)
    assert list(found.families) == ["lower"]
    assert "upper span is not detected" in found.unidentifiable[0]


def test_one_partial_of_each_span_may_be_taken_either_way():
    """Without what lies above 115 Hz one tone is left of each: neither is known to be whose."""
    one = played(10_052, drive=carrying(), pretension=7.0, share=0.1, probe=0.19, noise=0.0)
    low = zero_phase(one.log.channel("sound"), one.log.interval, 115.0, order=8)
    low = low + 0.02 * np.abs(low).max() * np.random.default_rng(1).normal(size=low.size)
    with pytest.raises(NotComputed, match="two assignments") as refusal:
        tension_of_both(log_of(one.log.time, {"sound": low}, {}), one.drive)
    assert "\n" not in str(refusal.value)


def test_the_command_reads_both_spans_of_a_sound_file(tmp_path, capsys):
    """Two tensions with labels and status 0; one family and status 3 with one line on standard error."""
    for name, heights in (("both", (1.5e-3, 0.6e-3)), ("one", (1.5e-3, 0.0))):
        one = played(10_060, heights=heights, share=0.1, loudness=(1.0, 1.0), rate=1000.0)
        sound = one.log.channel("sound")
        stored = (20_000 * sound / np.abs(sound).max()).astype("int16")
        wavfile.write(tmp_path / f"{name}.wav", 1000, stored)
    options = ["--ping", "dissertation-3", "--span", "both", "--json"]
    status, out, err = called(capsys, "identify", tmp_path / "both.wav", *options, "--plucked", "upper")
    answer = json.loads(out)
    assert (status, err) == (0, "")
    assert answer["parameters"]["tension_upper"]["value"] == pytest.approx(one.upper, rel=0.002)
    assert answer["parameters"]["tension_lower"]["value"] == pytest.approx(one.lower, rel=0.002)
    status, out, err = called(capsys, "identify", tmp_path / "one.wav", *options)
    answer = json.loads(out)
    assert status == 3
    assert len(err.splitlines()) == 1
    assert "one family" in err
    assert answer["identifiable"] is False
    assert answer["parameters"]["standing_torque"]["value"] is None
    refused = called(
        capsys, "identify", tmp_path / "one.wav", "--ping", "dissertation-3", "--plucked", "upper"
    )
    assert refused[0] == 2
    assert "--span both" in refused[2]


def test_overlapping_decaying_tones_are_fitted_without_bias():
    """Two families a third of a line width apart, without noise: factors to 1e-7, decays to 1e-5."""
    time = np.arange(4000) / 2000.0
    tooth = np.array([100.0, 200.0, 300.0])
    scale, decay = (1.0, 1.004), (2.0, 3.0)
    values = sum(
        np.exp(-a * time) * np.cos(2 * np.pi * x * f * time + 1.3 * f * x) / (1 + k)
        for x, a in zip(scale, decay, strict=True)
        for k, f in enumerate(tooth)
    )
    start = Tones(
        family=np.repeat([0, 1], 3),
        tooth=np.tile(tooth, 2),
        number=np.tile([1, 2, 3], 2),
        scale=np.array([0.9995, 1.0045]),
        decay=np.full(6, 2.5),
        rise=np.zeros(6),
    )
    fit = fit_tones(values, 5e-4, start, 2)
    assert fit.tones.scale == pytest.approx(scale, rel=1e-7), fit.tones.scale
    assert fit.tones.decay == pytest.approx(np.repeat(decay, 3), rel=1e-5), fit.tones.decay


def test_split_partials_over_a_first_that_is_not_split_are_no_tauter_span():
    """The loudest tone at half their frequency decides: tensions 1.8 % apart, not four times as large."""
    one = played(22_005, duration=3.0, segments=240, share=0.00905)
    found = tension_of_both(one.log, one.drive)
    assert found.identifiable
    assert max(map(abs, errors(found, one).values())) < 0.01, errors(found, one)
