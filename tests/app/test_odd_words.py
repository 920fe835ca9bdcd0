"""Words and numbers of a stranger: each ends in one line that names value and remedy, never a defect."""

import numpy as np
import pytest

from command import refusal

HEAD = "time [s],torque [N m],angle [deg]"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of its own with a short log and odd files."""
    monkeypatch.chdir(tmp_path)
    time = 1e-3 * np.arange(2000)
    table = np.column_stack([time, np.sin(6 * time), np.degrees(np.cos(6 * time))])
    np.savetxt("log.csv", table, delimiter=",", header=HEAD, comments="")
    for name, text in (
        ("long.csv", "time [s],torque [N m]\n0,0\n1e300,1\n"),
        ("short.csv", "time [s],torque [N m]\n0,0\n1e-300,0.001\n"),
        ("narrow.toml", "[identify]\nbandwidth = 1e-9\n"),
        ("fading.toml", '[identify]\nmodel = "rigid-axis-stribeck"\nfading = 1e-300\n'),
        ("late.toml", "[log]\nstart = 1e300\n"),
    ):
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            "identify log.csv --config narrow.toml",
            "bandwidth = 1e-09 Hz has no whole period in a log of 1.999 s",
        ),
        ("identify log.csv --config fading.toml", "identify.fading = 1e-300 rad/s is of no machine"),
        ("identify log.csv --config late.toml", "nothing between 1e+300 s and 1.999 s"),
        ("identify log.csv --column torque=torque:mN*1e400", 'scale "1e400" must be finite'),
        ("identify log.csv --model=", 'model "" is unknown'),
        ("identify log.csv --method=", 'method "" is unknown'),
        ("response log.csv --input torque --output angle --segment=-1", "segment = -1 s must be above 0"),
        (
            "response log.csv --input torque --output angle --overlap 1e300",
            "overlap = 1e+300 s must lie from 0",
        ),
        ("response log.csv --input torque --output angle --coulomb 1e300", "--coulomb = 1e+300 N m must lie"),
        ("response log.csv --input torque --output angle --coulomb=-1", "--coulomb = -1 N m must lie from 0"),
        ("resonance dissertation-2 --motion long.csv", "lasts 1e+300 s, which takes"),
        ("resonance dissertation-2 --motion short.csv", "lasts 1e-300 s, which takes 1 steps"),
        ("camera a.avi -o c.csv --scale 0", "scale = 0 m for one pixel must be finite and above 0"),
        ("study dissertation-3 --output=", "--output names no folder"),
        ("reproduce --quick --output=", "--output names no folder"),
        ("check --", "DRIVE"),
    ],
)
def test_odd_words_end_in_one_line(folder, arguments, words):
    before = sorted(folder.iterdir())
    assert words in refusal(*arguments.split())
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("command", ["check", "modes", "resonance", "track"])
def test_an_empty_name_of_a_drive_is_named_as_such(command):
    assert refusal(command, "") == (
        '"": no drive is named: give the path of a drive file, or a name of cabledrive drives'
    )
