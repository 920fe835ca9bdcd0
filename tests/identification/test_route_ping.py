"""A ping tells the tension of a named span of a machine with routes, and two pings compare two belts."""

import numpy as np
import pytest
from scipy.io import wavfile

import cabledrive as cd
from cabledrive.identification.logs.log import log_of
from cabledrive.identification.tension.route_ping import compared, tension_of_route_span
from command import answer, refusal

BELT_A, BELT_B = "motor a to rear right a", "motor b to rear left b"
LENGTH = 0.42
"""Of both spans in the file: from the motor's to the idler's axis, rims aligned [m]."""


def ring(tension, seed, *, rate=4000.0, duration=2.0):
    """Three decaying tones of the string formula, with noise, and the time."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(duration * rate)) / rate
    strain = tension / 19.4e3
    first = np.sqrt(tension * (1.0 + strain) / 8.3e-3) / (2.0 * LENGTH)
    tones = [np.exp(-2.0 * time) * np.cos(2 * np.pi * k * first * time + k) / k**2 for k in (1, 2, 3)]
    clean = np.sum(tones, axis=0)
    return time, clean + 0.03 * np.abs(clean).max() * rng.normal(size=time.size)


def logged(tension, seed):
    time, sound = ring(tension, seed)
    return log_of(time, {"sound": sound}, {"sound": ""}, "ping")


def test_tension_is_that_of_the_string_formula_though_the_file_says_another():
    drive = cd.load_drive("corexy")
    for seed, tension in enumerate((22.0, 31.0, 48.0)):
        found = tension_of_route_span(logged(tension, seed), drive, BELT_A).spans[BELT_A]
        assert found.tension.low < tension < found.tension.high
        assert found.tension.value == pytest.approx(tension, rel=2e-3)
        assert not found.findings


def test_two_belts_are_compared_with_an_interval():
    drive = cd.load_drive("corexy")
    found = {
        span: tension_of_route_span(logged(tension, seed), drive, span).spans[span]
        for seed, (span, tension) in enumerate(((BELT_A, 30.0), (BELT_B, 26.0)))
    }
    both = compared(found)
    assert both.difference.low < 4.0 < both.difference.high
    assert both.relative == pytest.approx(4.0 / 28.0, rel=0.02)
    assert both.as_dict()["differ"]


def test_the_command_names_spans_and_refuses_in_one_line(tmp_path):
    files = []
    for name, tension in (("a.wav", 30.0), ("b.wav", 30.0)):
        _, sound = ring(tension, 7)
        path = tmp_path / name
        wavfile.write(path, 4000, np.round(2e4 * sound / np.abs(sound).max()).astype(np.int16))
        files.append(str(path))
    asked = ["--ping", "corexy", "--span", BELT_A, "--span", BELT_B]
    found = answer("identify", *files, *asked)
    assert found["comparison"]["relative"] == pytest.approx(0.0, abs=1e-4)  # spans of 0.42 m to 5e-5
    assert not found["comparison"]["differ"]
    assert "no span of" in refusal("identify", files[0], "--ping", "corexy", "--span", "motor a to nowhere")
    assert "name the span" in refusal("identify", files[0], "--ping", "corexy")
    assert "one --span for each" in refusal("identify", files[0], *asked)
    assert "not upper, lower or both" in refusal("identify", files[0], "--ping", "elevator", "--span", "uper")
