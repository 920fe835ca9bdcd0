"""Inputs are regular files: a pipe that nobody writes and a device that never ends are refused at once."""

import os
import time

import pytest

from command import call, run

WRITERS = {
    "drive": "check {}",
    "goals": "study dissertation-2 --quick --goals {} -o {}.study",
    "motion": "resonance dissertation-2 --motion {}",
    "log": "identify {}",
    "configuration": "identify log.csv --config {}",
    "excitation": "experiment dissertation-2 --excitation {}",
    "response": "response {} --input torque --response angle",
    "resonance test": "shaper {}",
    "ping": "identify {} --ping dissertation-2 --span upper",
}


@pytest.mark.parametrize("words", WRITERS.values(), ids=WRITERS.keys())
def test_a_pipe_is_refused_in_one_line(tmp_path, words):
    os.mkfifo(tmp_path / "pipe.csv")
    began = time.monotonic()
    result = call(*words.format(*[tmp_path / "pipe.csv"] * 2).split())
    assert result.exit_code == 2, result.stderr
    assert result.stderr.count("\n") == 1, result.stderr
    assert "pipe" in result.stderr, result.stderr
    assert time.monotonic() - began < 5.0


@pytest.mark.parametrize("words", ["check {}", "identify {}", "resonance dissertation-2 --motion {}"])
def test_a_device_is_refused_in_one_line(words):
    began = time.monotonic()
    result = call(*words.format("/dev/zero").split())
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1), result.stderr
    assert time.monotonic() - began < 5.0


def test_a_name_that_is_no_text_and_a_path_too_long_are_refused(tmp_path):
    named = os.fsdecode(os.fsencode(str(tmp_path)) + b"/\xff\xfe.csv")
    for path in (named, str(tmp_path / ("x" * 5000)), str(tmp_path / "a.csv" / "b.csv")):
        result = call("identify", path)
        assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1), result.stderr
    with open(named, "w") as file:
        file.write("time,torque\n1,x\n")
    result = run("identify", named)
    assert (result.returncode, result.stderr.count("\n")) == (2, 1), result.stderr
