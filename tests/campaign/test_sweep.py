"""A sweep gives for each row what the single command gives, in a store with labels and units."""

import tomllib
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr

import cabledrive as cd
from cabledrive.campaign.design import NamedDesign
from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import spec_of
from cabledrive.parameters.files import one_process
from campaign_computations import Dangerous, swept
from command import answer, refusal

SPEC = """
drive = "dissertation-3"
[vary]
"cable.pretension" = { from = "3 N", to = "9 N" }
pulley.1.inertia = { normal = ["23.5 kg cm^2", "1 kg cm^2"] }
"pulley.0.inertia" = { same_as = "pulley.1.inertia", factor = 0.3 }
[design]
kind = "sobol"
rows = 13
seed = 4
[compute]
what = "modes"
count = 3
chunk = 5
"""


@pytest.fixture
def sweep(tmp_path):
    """Runs a SPEC into a store, by the command in this process; returns answer and data set."""

    def run(text, *options, name="store.zarr"):
        (tmp_path / "spec.toml").write_text(text)
        store = tmp_path / name
        found = answer("sweep", str(tmp_path / "spec.toml"), "-o", str(store), "--workers", "1", *options)
        return found, xr.open_zarr(store).load()

    return run


@pytest.fixture
def refused(tmp_path):
    """The line with which a SPEC into a store is refused."""

    def run(text, name="store.zarr"):
        (tmp_path / "spec.toml").write_text(text)
        return refusal("sweep", str(tmp_path / "spec.toml"), "-o", str(tmp_path / name), "--workers", "1")

    return run


def test_rows_equal_the_single_command(sweep):
    found, data = sweep(SPEC)
    assert (found["rows"], found["done"], found["refused"], found["failed"]) == (13, 13, 0, 0)
    assert found["seconds"] > 0.0
    assert found["store"].endswith("store.zarr")
    assert data.longitudinal_hz.dims == ("row", "mode")
    assert data.longitudinal_hz.shape == (13, 3)
    assert data["cable.pretension"].attrs["units"] == "N"
    assert data.longitudinal_hz.attrs["units"] == "Hz"
    for row in (0, 4, 12):
        keys = ("cable.pretension", "pulley.0.inertia", "pulley.1.inertia")
        settings = [f"{key}={float(data[key][row])!r}" for key in keys]
        drive = cd.load_drive("dissertation-3", overrides=settings)
        alone = cd.natural_frequencies(drive, count=3)[:3]
        np.testing.assert_allclose(data.longitudinal_hz[row], alone, rtol=1e-12)
    assert np.all(data.longitudinal_proven == 1)
    np.testing.assert_allclose(data["pulley.0.inertia"], 0.3 * data["pulley.1.inertia"])
    assert np.all((data["cable.pretension"] >= 3.0) & (data["cable.pretension"] <= 9.0))


def test_a_refused_row_is_a_row_with_the_single_command_s_line(sweep):
    text = 'drive = "dissertation-3"\n[vary]\ncable.pretension = { values = ["5 N", -1.0, "7 N"] }\n'
    found, data = sweep(text + '[design]\nkind = "list"\n[compute]\nwhat = "modes"\n')
    assert (found["done"], found["refused"], found["failed"]) == (3, 1, 0)
    assert data.code.values.tolist() == [0, 2, 0]
    line = refusal("modes", "dissertation-3", "--set", "cable.pretension=-1")
    assert line == f"dissertation-3: {data.reason.values[1]}"
    assert np.isnan(data.longitudinal_hz[1]).all()
    assert int(data.longitudinal_proven[1]) == -1


def test_a_table_is_read_row_by_row_with_its_units(sweep, tmp_path):
    import pyarrow as pa
    from pyarrow.parquet import write_table

    (tmp_path / "fleet.csv").write_text("cable.pretension [kN],radius\n0.005,3 cm\n0.006,4 cm\n")
    write_table(pa.table({"axial": [4000.0, 5000.0]}), tmp_path / "fleet.parquet")
    text = 'drive = "dissertation-3"\n[vary]\n"cable.pretension" = { table = "fleet.csv" }\n'
    text += '"pulley.0.radius" = { table = "fleet.csv", column = "radius" }\n'
    text += '"lumped.cable_stiffness" = { table = "fleet.parquet", column = "axial" }\n'
    _, data = sweep(text + '[design]\nkind = "list"\n[compute]\nwhat = "modes"\ncount = 1\n')
    assert data["cable.pretension"].values.tolist() == [5.0, 6.0]
    assert data["pulley.0.radius"].values.tolist() == [0.03, 0.04]
    assert data["lumped.cable_stiffness"].values.tolist() == [4000.0, 5000.0]


def test_a_tracked_row_equals_the_single_command_with_the_row_s_seed(sweep):
    text = 'drive = "dissertation-3"\n[vary]\n"plant.lumped.cable_stiffness" = { values = ["800 N/m"] }\n'
    text += '"motion.angle" = { values = ["20 deg"] }\n[motion]\nrise = "0.3 s"\ndwell = "0.1 s"\n'
    _, data = sweep(text + '[compute]\nwhat = "track"\ncontroller = "darc-4"\ngains = "dissertation"\n')
    shared = ["--angle", "20", "--rise", "0.3", "--dwell", "0.1", "--seed", str(int(data.seed[0]))]
    plant = ["--plant-set", "lumped.cable_stiffness=800 N/m", "--gains", "dissertation"]
    alone = answer("track", "dissertation-3", "--controller", "darc-4", *shared, *plant)
    assert float(data.peak_error_deg[0]) == pytest.approx(alone["peak_error_deg"], rel=1e-12)


def test_the_parts_of_an_array_job_fill_one_store(sweep, tmp_path):
    _, whole = sweep(SPEC)
    spec, store = str(tmp_path / "spec.toml"), str(tmp_path / "parts.zarr")
    done = [answer("sweep", spec, "-o", store, "--part", f"{i}/2")["done"] for i in (2, 1)]
    assert done == [5, 13]
    parts = xr.open_zarr(store).load()
    assert parts.drop_vars("time").identical(whole.drop_vars("time"))


def test_a_design_and_a_computation_of_one_s_own_are_taken(tmp_path):
    class Corners:
        rows, identity = 4, "corners"

        def points(self, first, last):
            return np.array([[0.0], [0.25], [0.5], [1.0]])[first:last]

    text = 'drive = "dissertation-3"\n[vary]\nown.x = { from = 0, to = 8 }\n'
    data = swept(tmp_path, text, design=Corners(), computation=Dangerous(str(tmp_path))).open().load()
    assert data["own.x"].values.tolist() == [0.0, 2.0, 4.0, 8.0]
    np.testing.assert_array_equal(data.square, data["own.x"] ** 2 + data.seed % 7)


HEAD = 'drive = "dissertation-3"\n'
VARY = '[vary]\n"cable.pretension" = { from = "3 N", to = "9 N" }\n'
DESIGN = '[design]\nkind = "sobol"\nrows = 8\n'
COMPUTE = '[compute]\nwhat = "modes"\n'


@pytest.mark.parametrize(
    "text, parts",
    [
        (HEAD + VARY.replace("pretension", "pretention") + DESIGN + COMPUTE, ["pretention", "pretension"]),
        (HEAD + VARY.replace("9 N", "9 m") + DESIGN + COMPUTE, ["cable.pretension", "9 m", "N"]),
        (HEAD + VARY.replace("9 N", "2 N") + DESIGN + COMPUTE, ["cable.pretension", "3 N", "2 N"]),
        (HEAD + VARY + DESIGN.replace("sobol", "soboll") + COMPUTE, ["soboll", "sobol"]),
        (HEAD + VARY + DESIGN.replace("rows = 8", "") + COMPUTE, ["design.rows"]),
        (HEAD + VARY + DESIGN + COMPUTE.replace("modes", "modus"), ["modus", "modes"]),
        (HEAD + VARY + DESIGN + COMPUTE + "cuont = 3\n", ["cuont", "count"]),
        (HEAD + VARY + DESIGN + COMPUTE + 'outputs = ["frequency"]\n', ["frequency", "longitudinal_hz"]),
        (HEAD + VARY.replace("]", "]\n[compuet]", 1) + DESIGN + COMPUTE, ["compuet", "compute"]),
        (VARY + DESIGN + COMPUTE, ["drive"]),
        ('drive = "no-such"\n' + VARY + DESIGN + COMPUTE, ["no-such"]),
        (HEAD + VARY + DESIGN.replace("sobol", "grid").replace("rows = 8", "") + COMPUTE, ["n", "grid"]),
        (HEAD + VARY + DESIGN.replace("= 8", "= 20000000") + COMPUTE, ["20000000", "--yes"]),
        (HEAD + VARY + '[design]\nkind = "saltelli"\nrows = 8\n' + COMPUTE, ["base", "3"]),
    ],
)
def test_a_spec_that_cannot_be_meant_is_refused_in_a_line_and_nothing_is_written(
    text, parts, refused, tmp_path
):
    line = refused(text)
    assert all(part in line for part in parts), line
    assert [path.name for path in tmp_path.iterdir()] == ["spec.toml"]


@pytest.mark.parametrize(
    "old, new, key",
    [
        ("seed = 4", "seed = 5", "design.seed"),
        ('"9 N"', '"8 N"', "cable.pretension.to"),
        ("= 3\n", "= 2\n", "count"),
    ],
)
def test_another_spec_into_the_same_store_is_refused_by_the_key_that_differs(old, new, key, sweep, refused):
    sweep(SPEC)
    assert key in refused(SPEC.replace(old, new))
    assert sweep(SPEC.replace(old, new), "--force")[0]["done"] == 13


def test_what_is_no_store_of_this_version_or_has_a_driver_is_refused(sweep, refused, tmp_path):
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thing").touch()
    assert "full" in refused(SPEC, "full")
    with one_process(tmp_path / "store.zarr.lock" / "whole"):
        assert "another process" in refused(SPEC)
    sweep(SPEC)
    about = tmp_path / "store.zarr" / "zarr.json"
    about.write_text(about.read_text().replace(f'"cabledrive": "{cd.__version__}"', '"cabledrive": "9.9.9"'))
    line = refused(SPEC)
    assert "9.9.9" in line
    assert cd.__version__ in line


def test_rows_at_once_and_rows_one_by_one_are_the_same(sweep, monkeypatch):
    """Rows of every kind of motor, some refused, at once and by the single command's function."""
    text = 'drive = "DRIVE"\n[vary]\n"pulley.0.radius" = { values = ["3 cm", -1.0, "5 cm"] }\n'
    text += '"cable.pretension" = { from = "3 N", to = "9 N", n = 3 }\n[design]\nkind = "grid"\n'
    text += '[compute]\nwhat = "modes"\ncount = 4\n'
    for name in ("dissertation-2", "dissertation-3"):
        _, at_once = sweep(text.replace("DRIVE", name), name=f"{name}-a.zarr")
        with monkeypatch.context() as patch:
            patch.setattr("cabledrive.campaign.columns.plain_rows", lambda spec, values: None)
            _, singly = sweep(text.replace("DRIVE", name), name=f"{name}-b.zarr")
        assert at_once.code.values.tolist() == [0, 0, 0, 2, 2, 2, 0, 0, 0]
        np.testing.assert_allclose(at_once.longitudinal_hz, singly.longitudinal_hz, rtol=1e-12)
        for same in ("code", "reason", "longitudinal_proven", "seed"):
            assert at_once[same].values.tolist() == singly[same].values.tolist()


# --- A study as a row of a campaign is the study of the command
SPEC_STUDY = """
drive = "dissertation-3"
[vary]
"pulley.1.inertia" = { values = ["24 kg cm^2"] }
[goals]
error = "0.2 deg"
[design]
kind = "list"
seed = 7
[compute]
what = "study"
"""


@pytest.mark.verify
def test_a_row_has_the_verdict_error_and_law_of_the_command(tmp_path, measured):
    campaign = spec_of(tomllib.loads(SPEC_STUDY), tmp_path)
    row = compute_rows(campaign, 0, 1)
    (tmp_path / "goals.toml").write_text(f'error = "0.2 deg"\nseed = {row["seed"][0]}\n')
    machine = ["dissertation-3", "--set", "pulley.1.inertia=24 kg cm^2"]
    asked = ["--goals", str(tmp_path / "goals.toml"), "--quick", "-o", str(tmp_path / "study")]
    said = answer("study", *machine, *asked)
    measured(f"{row['verdict'][0]}: {row['chosen_controller'][0]}, {row['reached_error_deg'][0]:.4g} deg")
    assert row["code"][0] == 0
    assert row["verdict"][0] == said["verdict"]
    assert row["headline"][0] == said["headline"]
    assert row["reached_error_deg"][0] == said["reached_error_deg"]
    assert row["time"][0] > 0.0


def test_rows_of_a_machine_with_routes_are_its_runs(sweep):
    """A pluck at midspan is the largest height there; the tensions are those of `simulate` by itself."""
    found, data = sweep("""
drive = "capstan-arm"
[vary]
"pulley.joint.inertia" = { values = ["0.09 kg m^2", "0.12 kg m^2"] }
[compute]
what = "simulate"
duration = "0.3 ms"
torque_amplitude = "0.05 N m"
torque_frequency = "40 Hz"
pluck = "0.1 mm"
pluck_span = "lower idler to joint"
""")
    assert (found["done"], found["refused"]) == (2, 0)
    np.testing.assert_allclose(data["midpoint_peak"], 1e-4, rtol=1e-6)
    alone = ("simulate", "capstan-arm", "--set", "pulley.joint.inertia=0.12 kg m^2", "--duration", "0.3 ms")
    torque = ("--torque-amplitude", "0.05 N m", "--torque-frequency", "40 Hz")
    one = answer(*alone, *torque, "--pluck", "lower idler to joint=0.1 mm")
    least = min(span["least_tension"] for span in one["spans"])
    assert float(data["least_tension"][1]) == pytest.approx(least, rel=1e-12)


# --- Designs give exactly the rows that are asked for, each by its number alone
SHARES = (np.linspace(0.0, 1.0, 4), np.array([0.25, 0.75]), np.linspace(0.0, 1.0, 5))
KINDS = ("sobol", "halton", "lhs", "random", "list", "saltelli", "morris")
DESIGNS = [
    NamedDesign(kind="grid", rows=40, axes=3, shares=SHARES),
    *(NamedDesign(kind=kind, rows=100, axes=3, seed=1) for kind in KINDS),
]


@pytest.mark.parametrize("design", DESIGNS, ids=lambda design: design.identity)
def test_a_row_does_not_depend_on_how_rows_are_divided(design):
    whole = design.points(0, design.rows)
    assert whole.shape == (design.rows, 3)
    assert np.all((whole >= 0.0) & (whole <= 1.0))
    cuts = [0, 1, 7, 8, 33, design.rows]
    parts = [design.points(a, b) for a, b in pairwise(cuts)]
    np.testing.assert_array_equal(np.vstack(parts), whole)


def test_a_latin_hypercube_has_one_point_in_each_slice():
    points = NamedDesign(kind="lhs", rows=50, axes=2, seed=3).points(0, 50)
    for column in points.T:
        assert sorted(np.floor(50 * column).astype(int)) == list(range(50))


def test_groups_of_saltelli_exchange_one_column_at_a_time():
    groups = NamedDesign(kind="saltelli", rows=40, axes=3, seed=5).points(0, 40).reshape(8, 5, 3)
    a, b = groups[:, 0], groups[:, 1]
    for axis in range(3):
        expected = a.copy()
        expected[:, axis] = b[:, axis]
        np.testing.assert_array_equal(groups[:, 2 + axis], expected)
    assert not np.any(a == b)


def test_each_step_of_morris_moves_one_axis_by_half_and_each_axis_once():
    paths = NamedDesign(kind="morris", rows=250, axes=4, seed=2).points(0, 250).reshape(50, 5, 4)
    steps = np.abs(np.diff(paths, axis=1))
    np.testing.assert_array_equal(np.sort(steps, axis=2)[:, :, :3], 0.0)
    np.testing.assert_array_equal(steps.sum(axis=1), 0.5)
    assert set(np.unique(paths)) == {0.125, 0.375, 0.625, 0.875}
    assert len(np.unique(np.argmax(steps, axis=2), axis=0)) > 15, "the order is random"
