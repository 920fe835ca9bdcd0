"""What comes out of runs: labelled data, files, error estimates, ensembles."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray

from cabledrive import __version__
from cabledrive.mechanics import compiled
from cabledrive.parameters.carriage import Carriage
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.hashing import content_hash
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


def test_fields_and_probes_show_the_same_motion():
    result = example()
    data = result.dataset
    upper = data["field"].sel(span="upper", plane="w").values
    np.testing.assert_array_equal(upper[:, 10], result.midpoint("upper")[::5, 2])
    np.testing.assert_array_equal(
        data["field"].sel(span="lower", plane="w").values[:, 10], result.midpoint("lower")[::5, 2]
    )
    np.testing.assert_allclose(data["field_time"], result.time[::5])
    place = data["position"].sel(span="lower").values
    at_probe = [np.interp(0.3, place, shape) for shape in data["field"].sel(span="lower", plane="w").values]
    np.testing.assert_allclose(result.probe(2)[::5, 2], at_probe, atol=1e-18)


def test_a_file_holds_the_dataset(tmp_path):
    path = tmp_path / "run.nc"
    result = example(output=path)
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        xarray.testing.assert_identical(stored.drop_attrs(), result.dataset.drop_attrs())
        assert dict(stored.attrs) == result.dataset.attrs
        for name, variable in result.dataset.variables.items():
            assert stored[name].attrs == variable.attrs, name
    assert result.path == path


def test_the_summary_is_what_the_command_answers_with():
    result = example()
    summary = result.summary()
    json.dumps(summary, allow_nan=False)
    assert summary["steps"] == result.steps == round(0.05 / result.step)
    angle = result.load_angle
    assert summary["load_angle"]["peak_to_peak"] >= np.ptp(angle)
    assert summary["load_angle"]["peak_to_peak"] == pytest.approx(np.ptp(angle), rel=1e-2)
    assert summary["upper_midpoint"]["peak"] == pytest.approx(
        np.max(np.abs(result.midpoint()[:, 2])), rel=1e-2
    )
    assert summary["slack_events"] == []
    assert 0.0 < summary["energy_budget_error"] < 1e-5


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


@pytest.mark.parametrize(
    "drive", [DRIVE, replace(DRIVE, carriage=(Carriage(mass=1e-3, position=0.4, guided=False),))]
)
def test_the_energy_handled_is_counted_from_where_the_cable_would_rest(drive):
    """A straight cable under gravity starts above its rest by the energy that its sag would release."""
    straight = simulate(drive, 0.005, scheme=Scheme(segments=40))
    resting = simulate(drive, 0.005, scheme=Scheme(segments=40), start=Start(from_equilibrium=True))
    assert straight.energy_handled > 1e-7
    assert resting.energy_handled < 1e-3 * straight.energy_handled


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


def test_an_error_estimate_of_too_few_segments_is_refused():
    with pytest.raises(InputRefused, match="segments = 11: an error estimate halves them twice and needs 12"):
        simulate(DRIVE, 0.01, scheme=Scheme(segments=11), error_estimate=True)


def test_compiled_kernels_lie_in_a_folder_of_the_user_and_version(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiled._cache_folder.cache_clear()
    sources = compiled.Path(compiled.__file__)
    folder = compiled.Path(compiled._cache_folder(sources))
    assert folder.parent == tmp_path / "cabledrive"
    assert __version__ in folder.name
    assert folder.stat().st_mode & 0o077 == 0
    compiled._cache_folder.cache_clear()


def test_a_cache_others_can_write_into_is_not_used(tmp_path, monkeypatch):
    """Nor one that cannot be made: then there is none in that place, and kernels are compiled anew."""
    (tmp_path / "cabledrive").mkdir()
    (tmp_path / "cabledrive").chmod(0o777)
    assert not compiled._is_own(tmp_path / "cabledrive")
    (tmp_path / "file").touch()
    assert not compiled._is_own(tmp_path / "file" / "below")
