"""What comes out of runs: labelled data, files, error estimates, ensembles."""

import numpy as np
import pytest
import xarray

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


def test_a_file_holds_the_dataset_with_units_for_everything(tmp_path):
    path = tmp_path / "run.nc"
    result = example(output=path)
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.drop_attrs(), result.dataset.drop_attrs())
        assert dict(stored.attrs) == result.dataset.attrs
        for name, variable in result.dataset.variables.items():
            assert stored[name].attrs == variable.attrs, name
    assert {channel.name for channel in CHANNELS} < set(result.dataset.data_vars)
    for name, variable in result.dataset.data_vars.items():
        assert variable.attrs["units"], name
        assert variable.attrs["long_name"], name
    np.testing.assert_allclose(result.dataset["probe_position"][2:], [0.3, 0.9])
    assert result.dataset.attrs["drive_hash"] == content_hash(DRIVE)


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
