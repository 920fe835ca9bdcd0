"""cabledrive simulate: what it answers, what it writes, how it ends."""

import json

import numpy as np
import pytest
import xarray

from cabledrive.parameters import load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from command import answer, call, object_of

SHORT = ["--duration", "0.02", "--segments", "20"]
FORCED = ["--torque-amplitude", "0.02", "--torque-frequency", "81.7"]
HELD = ["--set", "pulley.1.fixed=true"]


def test_the_command_is_a_few_lines_over_the_public_function(tmp_path):
    path, page = tmp_path / "run.nc", tmp_path / "run.html"
    options = ["--pluck-upper", "1 mm", "--pluck-lower", "0.5 mm", "--pluck-shape", "half-sine"]
    options += ["--fields", "10", "-o", path, "--animate", page]
    found = answer("simulate", "dissertation-2", *SHORT, *FORCED, *options)
    plucks = (Pluck(height=1e-3, shape="half-sine"), Pluck(height=5e-4, span="lower", shape="half-sine"))
    result = simulate(
        load_drive("dissertation-2"),
        0.02,
        torque=Sine(amplitude=0.02, frequency=81.7),
        start=Start(plucks=plucks),
        scheme=Scheme(segments=20),
        recording=Recording(fields=10),
    )
    del found["wall_time"], found["provenance"], found["error_estimate_reason"]
    expected = result.summary()
    del expected["wall_time"]
    assert found == expected
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        np.testing.assert_array_equal(stored["load_angle"], result.load_angle)
        assert stored["field"].sizes["field_time"] == 21
    assert "prefers-reduced-motion" in page.read_text()


def test_an_error_estimate_comes_with_the_answer_and_in_the_file(tmp_path):
    options = (*SHORT, *FORCED, "--error-estimate", "-o", tmp_path / "run.nc")
    found = answer("simulate", "dissertation-2", *options)["error_estimate"]
    with xarray.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as stored:
        assert json.loads(stored.attrs["error_estimate"]) == found
    assert found["segments"] == [20, 10, 5]
    assert 0.0 < found["load_angle"]["relative"] < 0.1


def test_a_load_that_does_not_move_has_no_relative_error():
    """Without torque and pluck what the load turns by is rounding."""
    found = answer("simulate", "dissertation-1", "--duration", "0.01", "--error-estimate")["error_estimate"]
    assert (found["load_angle"]["error"] < 1e-14, found["load_angle"]["relative"]) == (True, 0.0)


def test_slack_ends_the_run_with_status_3_and_keeps_what_was_found(tmp_path):
    path = tmp_path / "run.nc"
    options = ["--duration", "1", "--segments", "20", "--torque-amplitude", "0.5", "--torque-frequency", "0"]
    done = call("simulate", "dissertation-2", *HELD, *options, "--json", "-o", path)
    assert done.exit_code == 3
    found = object_of(done.stdout)
    event = found["slack_events"][0]
    assert event["span"] == "upper"
    assert found["steps"] * found["step"] == pytest.approx(event["time"])
    assert done.stderr.splitlines()[-1].startswith("cabledrive: the upper span goes slack at t = ")
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        assert stored["time"][-1] <= event["time"]
    allowed = answer("simulate", "dissertation-2", *HELD, *options, "--tension-only", "--duration", "0.1")
    assert allowed["slack_events"]


def test_a_picture_that_cannot_be_drawn_leaves_the_run_and_says_so(tmp_path, monkeypatch):
    """A slack span ends the run before there are records enough: status 3, the result written and printed."""
    monkeypatch.chdir(tmp_path)
    start = ("simulate", "dissertation-2", "--duration", "0.01", "--torque-amplitude", "1e3")
    done = call(*start, "--torque-frequency", "0", "-o", "run.nc", "--plot", "run.png", "--json")
    assert done.exit_code == 3
    assert (tmp_path / "run.nc").exists()
    assert not (tmp_path / "run.png").exists()
    assert object_of(done.stdout)["slack_events"]
    assert "not drawn: spectrum of" in done.stderr
