"""An option that has no effect beside the others is refused or reported, and a wrong ending is refused."""

import os

import numpy as np
import pytest

from command import call, refusal


@pytest.fixture
def log(tmp_path, monkeypatch):
    """A log of 2 s at 1 kHz, in a folder of its own."""
    time = 1e-3 * np.arange(2000)
    table = np.column_stack([time, np.sin(6 * time), np.degrees(np.cos(6 * time))])
    monkeypatch.chdir(tmp_path)
    np.savetxt("log.csv", table, delimiter=",", header="time [s],torque [N m],angle [deg]", comments="")
    return "log.csv"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("identify log.csv --span upper", "--span belongs to --ping DRIVE"),
        ("identify log.csv --plucked lower", "--plucked belongs to --ping DRIVE"),
        ("identify log.csv --section 0", "--section belongs to --ping DRIVE"),
        ("identify log.csv --ping elevator --model rigid-axis", "--model is for the parameters of an axis"),
        ("identify log.csv --ping elevator --no-check", "--no-check is for the parameters of an axis"),
        ("identify log.csv --ping elevator --report p.html", "--report is for the parameters of an axis"),
        ("response log.csv --input torque --output angle --offset 1", "--offset belongs to --coulomb"),
        ("experiment dissertation-3 --stroke 1 -o a.csv", "--stroke belongs to --plan"),
        ("experiment dissertation-3 --plan -o a.csv", "--output writes nothing with --plan"),
        ("resonance dissertation-2 --floor 1um", "--floor belongs to --motion FILE"),
        ("resonance dissertation-2 --limit 1mm", "--limit belongs to --motion FILE"),
        ("simulate dissertation-2 --duration 1 --fields 2", "--fields keeps nodes in RUN.nc"),
        ("simulate dissertation-2 --duration 1 --model fast --segments 9", "does not go with --model fast"),
        ("track dissertation-3 --segments 9", "--segments divides the cable as plant"),
        ("track dissertation-3 --controller pid --no-adaptation", "--no-adaptation has no effect: pid"),
        ("camera a.avi --scale 1mm --known-pixels 3 -o a.csv", "--known-pixels has no effect beside --scale"),
    ],
)
def test_an_option_without_effect_is_refused_and_nothing_is_written(log, arguments, words):
    assert words in refusal(*arguments.split())
    assert os.listdir() == [log]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("track", "dissertation-3", "--as-printed"), "--as-printed has no effect"),
        (("track", "dissertation-3", "--ideal-sensors", "--observer", "kalman"), "--observer has no effect"),
        (("simulate", "dissertation-2", "--duration", "1 ms", "--pluck-shape", "half-sine"), "no span is"),
    ],
)
def test_an_option_of_the_agreed_ones_without_effect_is_reported(arguments, words):
    done = call(*arguments, "--json")
    assert done.exit_code == 0
    assert words in done.stderr
    assert "has no effect" not in call(*arguments, "--json", "--quiet").stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("report elevator -o r.pdf", "r.pdf: does not end in .html or .htm: rename it"),
        ("identify log.csv --report r.pdf", "does not end in .html or .htm"),
        ("resonance dissertation-2 --map r.svg", "does not end in .html or .htm"),
        ("check elevator -o c.html", "c.html: does not end in .json: rename it"),
        ("identify log.csv -o i.csv", "does not end in .json"),
        ("response log.csv --input torque --output angle -o r.csv", "does not end in .json"),
        ("shaper log.csv -o s.csv", "does not end in .json"),
        ("shaper log.csv --plot s.html", "does not end in .png or .svg or .pdf"),
        ("track dissertation-3 -o t.csv", "does not end in .json"),
        ("experiment dissertation-3 -o e.json", "does not end in .csv"),
        ("simulate dissertation-2 --duration 1 -o r.h5", "does not end in .nc"),
    ],
)
def test_a_file_of_one_format_has_its_ending(log, arguments, words):
    assert words in refusal(*arguments.split())
    assert os.listdir() == [log]


def test_a_page_of_a_log_that_is_read_in_blocks_is_refused_before_the_work(log, monkeypatch):
    monkeypatch.setattr("cabledrive.identification.long_logs.is_long", lambda recording: True)
    monkeypatch.setattr("cabledrive.identification.one_log.identify", None)  # were it begun: a defect
    assert "log.csv is too long to be drawn" in refusal("identify", log, "--report", "p.html")


@pytest.mark.parametrize(
    ("source", "target"), [("torque", "torque"), ("torque", "torque [N m]"), ("angle", "angle")]
)
def test_a_response_of_a_column_to_itself_is_refused(log, source, target):
    line = refusal("response", log, "--input", source, "--output", target)
    assert f'input and output are both the column "{source}"' in line
    assert "choose two of time, torque, angle" in line


def test_a_position_in_degrees_is_refused_with_a_mapping_that_works(log):
    with open(log) as file:
        content = file.read()
    with open("servo.csv", "w") as file:
        file.write(content.replace("angle [deg]", "position [deg]"))
    line = refusal("identify", "servo.csv")
    assert '"deg" is a unit of angle, position is in m: head it "angle [deg]"' in line
    assert '--column "torque=torque" --column "angle=position"' in line
    mapped = ("--column", "torque=torque", "--column", "angle=position")
    assert call("identify", "servo.csv", *mapped).stdout == call("identify", log).stdout
