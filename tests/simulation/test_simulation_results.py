"""What comes out of runs: labelled data, files, error estimates, ensembles."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray

from cabledrive import __version__
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.schema import content_hash
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.simulation.channels import CHANNELS

DRIVE = load_drive("dissertation-2")
OPTIONS = {
    "torque": Sine(amplitude=0.02, frequency=81.7),
    "start": Start(plucks=(Pluck(height=1e-3, shape="half-sine"),)),
    "scheme": Scheme(segments=20),
}
RECORDING = Recording(rate=2000.0, fields=5, probes=(("lower", 0.3), ("upper", 0.9)))


def example(**options):
    return simulate(DRIVE, 0.05, **{**OPTIONS, "recording": RECORDING, **options})


def test_a_dataset_has_units_and_coordinates_for_everything():
    data = example().dataset
    assert dict(data.sizes) == {
        "time": 101, "probe": 4, "plane": 3, "span": 2, "node": 21, "field_time": 21
    }  # fmt: skip
    for name, variable in data.data_vars.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    assert {channel.name for channel in CHANNELS} < set(data.data_vars)
    assert list(data["probe_span"].values) == ["upper", "lower", "lower", "upper"]
    np.testing.assert_allclose(data["probe_position"][2:], [0.3, 0.9])
    assert data.attrs["drive_hash"] == content_hash(DRIVE)
    assert data.attrs["cabledrive"] == __version__
    assert json.loads(data.attrs["method"])["segments"] == 20


def test_a_file_holds_the_dataset(tmp_path):
    path = tmp_path / "run.nc"
    result = example(output=path)
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.drop_attrs(), result.dataset.drop_attrs())
        assert dict(stored.attrs) == result.dataset.attrs
        for name, variable in result.dataset.variables.items():
            assert stored[name].attrs == variable.attrs, name
    assert result.path == path


def test_energies_add_up_to_what_a_textbook_says():
    """Half-sine pluck: integral of T0 s + EA s^2 / 2 with s = w'^2 / 2, to the fourth power of its height."""
    weightless = replace(DRIVE, layout=replace(DRIVE.layout, gravity=0.0))
    result = simulate(weightless, 1e-3, start=OPTIONS["start"], scheme=Scheme(segments=200))
    height, length = 1e-3, DRIVE.pulley_distance
    slopes = 0.5 * (np.pi * height / length) ** 2
    expected = 0.5 * DRIVE.cable.pretension * slopes * length
    expected += 0.5 * DRIVE.cable.axial_rigidity * (3.0 / 8.0) * slopes**2 * length
    assert result.channel("strain_energy_upper")[0] == pytest.approx(expected, rel=1e-4)
    assert result.energy_handled == pytest.approx(result.channel("strain_energy_upper")[0], rel=1e-9)


@pytest.mark.parametrize(("shape", "order"), [("half-sine", 2.0), ("triangle", 1.0)])
def test_the_error_estimate_covers_the_error_and_sees_its_order(shape, order):
    """Against n = 640: the estimate at n = 80 is not below half the error, nor above five times it."""
    options = {"torque": OPTIONS["torque"], "start": Start(plucks=(Pluck(height=1e-3, shape=shape),))}
    coarse, fine = (
        simulate(DRIVE, 0.1, **options, scheme=Scheme(segments=n), error_estimate=n == 80) for n in (80, 640)
    )
    estimate = coarse.error_estimate
    assert estimate.segments == (80, 40, 20)
    true = {
        "load_angle": np.max(np.abs(coarse.load_angle - fine.load_angle)),
        "upper_midpoint": np.max(np.abs(coarse.midpoint()[:, 2] - fine.midpoint()[:, 2])),
    }
    for name, error in true.items():
        found = getattr(estimate, name)
        assert 0.5 * error < found.error < 5.0 * error, (
            f"{name}: estimated {found.error:.2e}, true {error:.2e}"
        )
    assert estimate.upper_midpoint.order == pytest.approx(order, abs=0.5)
