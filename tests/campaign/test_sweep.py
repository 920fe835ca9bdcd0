"""A sweep gives for each row what the single command gives; indices and yields as of known functions."""

import json
import re
import shlex
import tomllib
from base64 import b64decode
from itertools import chain, pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.stats import beta

import cabledrive as cd
from cabledrive.campaign.design import NamedDesign
from cabledrive.campaign.results import indices
from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import spec_of
from cabledrive.parameters.files import one_process
from campaign_computations import Dangerous, Ishigami, swept
from command import answer, call, refusal, run

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
        drive = cd.load_drive("dissertation-3", overrides=settings).listed
        alone = cd.natural_frequencies(drive, count=3, taut=True)[:3]
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
    assert found["first_reason"] == data.reason.values[1]
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
FOLLOWS = '"pulley.1.radius" = { same_as = "cable.pretension", factor = 0.01 }\n'


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
        (HEAD + VARY + FOLLOWS + DESIGN + COMPUTE, ["pulley.1.radius", "in N", "same unit"]),
        (HEAD + VARY.replace('"ca', '"plant.ca') + DESIGN + COMPUTE, ["plant.cable.pretension", "modes"]),
        (HEAD + "[motion]\npulses = 2\n" + VARY + DESIGN + COMPUTE, ["motion", "modes"]),
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
            patch.setattr("cabledrive.campaign.kinds.plain_rows", lambda spec, values: None)
            _, singly = sweep(text.replace("DRIVE", name), name=f"{name}-b.zarr")
        assert at_once.code.values.tolist() == [0, 0, 0, 2, 2, 2, 0, 0, 0]
        np.testing.assert_allclose(at_once.longitudinal_hz, singly.longitudinal_hz, rtol=1e-12)
        for same in ("code", "reason", "longitudinal_proven", "seed"):
            assert at_once[same].values.tolist() == singly[same].values.tolist()


@pytest.mark.parametrize(
    ("name", "tensions", "apart"), [("camera-line", (800, 1100), 1e-3), ("elevator", (17e3, 2e4), 2e-5)]
)
def test_rows_of_ropes_that_sag_or_bear_weights_have_the_modes_of_the_command(sweep, name, tensions, apart):
    text = (
        f'drive = "{name}"\n[vary]\n"cable.pretension" = {{ values = {[f"{own} N" for own in tensions]} }}\n'
    )
    text += '[design]\nkind = "grid"\n[compute]\nwhat = "modes"\ncount = 3\n'
    _, rows = sweep(text)
    for tension, found in zip(tensions, rows.longitudinal_hz.values, strict=True):
        drive = cd.load_drive(name, overrides=[f"cable.pretension={tension} N"]).listed
        known = [mode.frequency for mode in cd.modes(drive, count=3).longitudinal]
        np.testing.assert_allclose(found, known[:3], rtol=1e-9)
        straight = cd.natural_frequencies(drive, count=3, taut=True)
        assert np.abs(found / straight[:3] - 1.0).max() > apart


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
    assert "first_reason" not in found
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


# --- Indices, yields and tolerances agree with functions whose answers are known
A, B = 7.0, 0.1
VARIANCE = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5
FIRST = np.array([0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0]) / VARIANCE
TOTAL = FIRST + np.array([1.0, 0.0, 1.0]) * B**2 * np.pi**8 * (1 / 18 - 1 / 50) / VARIANCE

KEYS = "".join(f'"own.x{i}" = {{ from = {-np.pi}, to = {np.pi} }}\n' for i in (1, 2, 3))
ISHIGAMI = f'drive = "dissertation-3"\n[vary]\n{KEYS}[design]\nkind = "saltelli"\nbase = 512\nseed = 2\n'


@pytest.fixture(scope="module")
def ishigami(tmp_path_factory):
    return swept(tmp_path_factory.mktemp("ishigami"), ISHIGAMI, computation=Ishigami()).store


def test_the_indices_of_ishigami_s_function_lie_in_their_intervals(ishigami):
    found = answer("sensitivity", str(ishigami), "--output", "y")
    assert (found["output"], found["rows"], found["groups_left_out"]) == ("y", 512 * 5, 0)
    assert found["standard_deviation"] == pytest.approx(np.sqrt(VARIANCE), rel=0.03)
    for i, key in enumerate(f"own.x{n}" for n in (1, 2, 3)):
        for kind, truth in (("first", FIRST[i]), ("total", TOTAL[i])):
            index = found[kind][key]
            assert index["low"] <= truth <= index["high"], (key, kind, index, truth)
            assert index["high"] - index["low"] < 0.35
            assert index["low"] <= index["value"] <= index["high"]


def test_bootstrap_intervals_hold_the_truth_as_often_as_they_say():
    """Of y = x1 + 2 x2, x normal: indices 0.2 and 0.8. 95 % intervals, 30 repetitions of 64 groups."""
    generator, held, asked = np.random.default_rng(4), 0, 0
    for _ in range(30):
        a, b = generator.normal(size=(2, 64, 2))
        mixed = [
            a[:, 0] * (i != 0) + b[:, 0] * (i == 0) + 2 * (a[:, 1] * (i != 1) + b[:, 1] * (i == 1))
            for i in (0, 1)
        ]
        groups = np.column_stack((a @ [1.0, 2.0], b @ [1.0, 2.0], *mixed))
        for truth, one in zip((0.2, 0.8, 0.2, 0.8), chain(*indices(groups, generator)), strict=True):
            held, asked = held + (one["low"] <= truth <= one["high"]), asked + 1
    assert 0.86 <= held / asked <= 0.99, f"{held} of {asked}"


def test_screening_finds_the_effects_of_a_product_and_a_line(tmp_path):
    """y = x1 x2 - 3 x3 over [0, 2]: effects of x1 are 2 x2: mean 2, deviation 1.118."""
    keys = "".join(f'"own.x{i}" = {{ from = 0, to = 2 }}\n' for i in (1, 2, 3, 4))
    text = f'drive = "dissertation-3"\n[vary]\n{keys}[design]\nkind = "morris"\nbase = 400\nseed = 5\n'

    class Product(Ishigami):
        def one(self, row):
            return {"y": row.own["x1"] * row.own["x2"] - 3.0 * row.own["x3"]}

    store = swept(tmp_path, text, computation=Product()).store
    found = answer("sensitivity", str(store), "--output", "y")
    assert (found["rows"], found["groups"], found["groups_left_out"]) == (2000, 400, 0)
    assert next(iter(found["effects"])) == "own.x3"
    line, idle = found["effects"]["own.x3"], found["effects"]["own.x4"]
    assert line["mean"] == pytest.approx(-6.0)
    assert line["mean_size"]["value"] == pytest.approx(6.0)
    assert line["deviation"] == pytest.approx(0.0, abs=1e-12)
    assert idle["mean_size"]["value"] == idle["deviation"] == 0.0
    for key in ("own.x1", "own.x2"):
        bent = found["effects"][key]
        assert bent["mean_size"]["low"] <= 2.0 <= bent["mean_size"]["high"], bent
        assert bent["deviation"] == pytest.approx(np.sqrt(1.25), rel=0.05)


def test_yield_and_tolerance_of_a_limit_on_one_key(tmp_path):
    """y = x^2 + noise below 7, x uniform from 0 to 8: y < 23 below sqrt(17) always, above sqrt(23) never."""
    text = 'drive = "dissertation-3"\n[vary]\n"own.x" = { from = 0, to = 8 }\n'
    text += '"own.idle" = { from = 0, to = 1 }\n[design]\nkind = "sobol"\nrows = 2048\n'
    store = swept(tmp_path, text, computation=Dangerous(folder=str(tmp_path))).store
    found = answer("tolerance", str(store), "--goal", "square < 23", "--target", "0.999")
    assert np.sqrt(17.0) / 8.0 < found["yield"] < np.sqrt(23.0) / 8.0
    assert found["yield_low"] < found["yield"] < found["yield_high"]
    first = next(iter(found["keys"]))
    assert first == "own.x"
    tight = found["keys"]["own.x"]["tightened"]
    assert tight["low"] < 0.01
    assert 3.6 <= tight["high"] <= np.sqrt(17.0) + 0.05
    assert found["keys"]["own.idle"]["tightened"] is None
    slope = found["keys"]["own.x"]["gain_per_high"]
    assert slope == pytest.approx(found["yield"] / 8.0, rel=0.1), "(Y - 0) times the density 1/8"


def yield_over(tmp_path, design):
    """Yield of y = x^2 + a number from 0 to 6 below 40 over a design, in which ``own.idle`` has no effect."""
    text = 'drive = "dissertation-3"\n[vary]\n"own.x" = { from = 0, to = 8, n = 12 }\n'
    text += f'"own.idle" = {{ from = 0, to = 1, n = 10 }}\n[design]\n{design}\n'
    store = swept(tmp_path, text, computation=Dangerous(folder=str(tmp_path))).store
    return store, answer("tolerance", str(store), "--goal", "square < 40")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_key_without_effect_is_not_to_be_tightened(seed, tmp_path):
    """Of 120 rows three quarters hold: in short intervals of any key all hold by chance alone."""
    _, found = yield_over(tmp_path, f'kind = "random"\nrows = 120\nseed = {seed}')
    assert 0.6 < found["yield"] < 0.9
    assert 5.0 < found["keys"]["own.x"]["tightened"]["high"] < np.sqrt(40.0)
    assert found["keys"]["own.idle"]["tightened"] is None


def test_the_share_of_a_grid_has_no_interval_and_equal_values_stay_together(tmp_path):
    store, found = yield_over(tmp_path, 'kind = "grid"')
    assert found["yield_low"] is found["yield_high"] is None
    assert "grid" in found["yield_low_reason"]
    tight = found["keys"]["own.x"]["tightened"]
    assert tight["rows"] == 10 * np.sum(np.linspace(0.0, 8.0, 12) <= tight["high"]), "whole values"
    assert "no interval" in call("tolerance", store, "--goal", "square < 17").stdout
    assert "nan" in refusal("tolerance", str(store), "--goal", "square < nan")


def test_groups_of_saltelli_count_as_two_points_each(tmp_path):
    """Rows of a group repeat the values of its two points: of four, as many as two."""
    _, found = yield_over(tmp_path, 'kind = "saltelli"\nbase = 64')
    held, rows = found["held"] / 2, found["rows"] / 2
    exact = beta.ppf([0.025, 0.975], [held, held + 1], [rows - held + 1, rows - held])
    assert [found["yield_low"], found["yield_high"]] == pytest.approx(exact)


def test_the_page_of_a_campaign_needs_nothing_else_and_gives_the_worst_machines_with_their_files(tmp_path):
    text = 'drive = "dissertation-3"\n[vary]\n"cable.pretension" = { from = "-0.2 N", to = "7 N" }\n'
    text += '"pulley.1.inertia" = { normal = ["23.5 kg cm^2", "1 kg cm^2"] }\n'
    text += '[design]\nkind = "sobol"\nrows = 128\n[compute]\nwhat = "modes"\ncount = 2\n'
    store, page = swept(tmp_path, text).store, tmp_path / "page.html"
    answer("report", str(store), "--goal", "longitudinal_hz[0] < 5.9 Hz", "-o", str(page))
    html = page.read_text()
    assert not re.findall(r'(?:src|href)="(?!data:|#)', html)
    assert "must be above 0" in html
    data = xr.open_zarr(store).load()
    held = float(np.mean((data.code == 0) & (data.longitudinal_hz[:, 0] < 5.9)))
    assert f"{100 * held:.2f}" in html
    files = [b64decode(text) for text in re.findall(r"data:application/toml;base64,([\w+/=]+)", html)]
    assert len(files) == 10
    worst = int(np.nanargmax(data.longitudinal_hz[:, 0]))
    (tmp_path / "worst.toml").write_bytes(files[0])
    drive = cd.load_drive(tmp_path / "worst.toml").listed
    assert drive.cable.pretension == float(data["cable.pretension"][worst])
    assert drive.load_pulley.inertia == float(data["pulley.1.inertia"][worst])
    assert "--goal" in refusal("report", "elevator", "--goal", "y < 3", "-o", str(tmp_path / "b.html"))


# --- The tolerance study of the page on campaigns runs as it is printed
ROOT = Path(__file__).parents[2]
PAGE, EXAMPLE = ROOT / "docs" / "campaigns_export.md", ROOT / "examples" / "tolerance_campaign.toml"


@pytest.mark.verify
def test_from_one_drive_to_a_tolerance_study(tmp_path, monkeypatch):
    tutorial = PAGE.read_text().split("### From one drive to a tolerance study")[1].split("\n### ")[0]
    spec = re.search(r":caption: campaign.toml\n\n(.*?)```", tutorial, re.S)[1]
    assert EXAMPLE.read_text() == spec
    commands = re.findall(r"^\$ cabledrive (.*)$", tutorial, re.M)
    assert [line.split()[0] for line in commands] == ["sweep", "sensitivity", "tolerance", "report"]
    (tmp_path / "campaign.toml").write_text(spec)
    monkeypatch.chdir(tmp_path)
    answers = {}
    for line in commands:
        words = shlex.split(line)
        done = run(*words, "--json")
        assert done.returncode == 0, (line, done.stderr)
        answers[words[0]] = json.loads(done.stdout)
    data = xr.open_zarr("campaign.zarr").load()
    first = data.longitudinal_hz[:, 0]
    assert (answers["sweep"]["done"], answers["sweep"]["failed"]) == (1280, 0)
    # the share of rows that keep the goal, counted here
    kept = float(np.mean(first.values[data.code.values == 0] > 5.9))
    assert 0.0 < kept < 1.0, "the goal of the tutorial asks nothing"
    assert answers["tolerance"]["yield"] == pytest.approx(kept, abs=1e-12)
    assert set(answers["sensitivity"]["total"]) == {key for key in data if "." in key}
    page = (tmp_path / "campaign.html").read_text()
    assert f"{1280}" in page
    assert "longitudinal_hz" in page


@pytest.mark.parametrize("torque", ["", 'torque = "5 mN m"'])
def test_rows_of_a_machine_with_routes_have_the_resonance_of_the_command(torque, sweep):
    vary = '[vary]\n"cable.pretension" = { values = ["10.5 N", "30 N"] }\n[design]\nkind = "grid"\n'
    asked = 'what = "resonance"\noutputs = ["frequency_ratio", "verdict"]'
    _, data = sweep(f'drive = "printer-idlers"\n{vary}[compute]\n{asked}\n{torque}\n')
    assert not data.code.values.any()
    for row, pretension in enumerate(("10.5 N", "30 N")):
        options = ["--torque", "5 mN m"] if torque else []
        single = answer("resonance", "printer-idlers", "--set", f"cable.pretension={pretension}", *options)
        assert float(data.frequency_ratio[row]) == pytest.approx(single["frequency_ratio"], rel=1e-12)
        assert str(data.verdict.values[row]) == single["verdict"]


def test_the_verdict_of_a_row_looks_at_what_the_command_does(sweep):
    """A torque that slackens a span is not safe either; a campaign looked at the pulley mode alone."""
    vary = '[vary]\n"cable.pretension" = { values = ["7 N"] }\n[design]\nkind = "grid"\n'
    asked = 'what = "resonance"\noutputs = ["verdict"]\ntorque = "2 N m"'
    _, data = sweep(f'drive = "dissertation-3"\n{vary}[compute]\n{asked}\n')
    assert data.verdict.values.tolist() == [answer("resonance", "dissertation-3", "--torque", "2")["verdict"]]
    assert data.verdict.values.tolist() == ["close"]
