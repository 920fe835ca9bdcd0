"""cabledrive simulate: what it answers, what it writes, how it ends."""

import numpy as np
import xarray

from cabledrive.parameters import load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from command import answer, call, object_of

SHORT = ["--duration", "0.02", "--segments", "20"]
FORCED = ["--torque-amplitude", "0.02", "--torque-frequency", "81.7"]


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
    for gone in ("wall_time", "interpreted", "stopped"):  # a time, and notes that there are none of
        del expected[gone]
    assert found == expected
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        np.testing.assert_array_equal(stored["load_angle"], result.load_angle)
        assert stored["field"].sizes["field_time"] == 21
    assert "prefers-reduced-motion" in page.read_text()


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
