"""`cabledrive modes`, `map`, `check`, `drives`: objects, tables that lose nothing, pictures of the same."""

import tomllib

import numpy as np
import pytest
import xarray as xr

import cabledrive as cd
from cabledrive.modal.mode import multiplets
from cabledrive.parameters import load_drive, packaged_text
from cabledrive.studies.resonance import resonance
from command import answer, call


@pytest.mark.parametrize("name", ["elevator", "lift-2-to-1", "corexy"])
def test_count_lists_so_many_frequencies_of_each_kind_and_certifies_each_to_its_last(name):
    """Twice the list is asked for: up to each bound of the certificate, by frequency, the same modes."""
    few, many = (cd.modes(cd.load_drive(name), count=count) for count in (4, 12))
    proof = answer("modes", name, "--count", "4")["certificate"]
    bounds = {kind: proof[f"{kind}_below_hz"] for kind in ("longitudinal", "transverse")}
    for kind, bound in bounds.items():
        listed = [mode for mode in few.modes if mode.kind == kind]
        assert len(multiplets(listed)) == 4
        assert listed[-1].frequency < bound
        again = [mode for mode in many.modes if mode.kind == kind and mode.frequency < bound]
        assert sum(m.multiplicity for m in listed) == sum(m.multiplicity for m in again)
    assert proof["below_hz"] == min(bounds.values())
    below = sum(mode.multiplicity for mode in many.modes if mode.frequency < proof["below_hz"])
    assert proof["count"] == below >= 4


@pytest.mark.parametrize(("ending", "magic"), [("png", b"\x89PNG"), ("SVG", b"<?xml"), ("pdf", b"%PDF")])
def test_picture_is_written_in_the_format_of_its_name(ending, magic, tmp_path):
    path = tmp_path / f"modes.{ending}"
    done = call("modes", "dissertation-1", "--plot", path)
    assert (done.exit_code, done.stderr) == (0, f"written to {path}\n")
    assert path.read_bytes().startswith(magic)


def test_map_writes_a_data_set_a_figure_and_a_page(tmp_path):
    files = [tmp_path / name for name in ("map.nc", "map.svg", "map.html")]
    vary = ("--vary", "head.x=60mm:360mm:2", "--vary", "beam.y=0.05:0.33:3")
    found = answer(
        "map", "corexy", *vary, "--count", "1", "-o", files[0], "--plot", files[1], "--page", files[2]
    )
    assert (found["keys"], found["shape"]) == (["head.x", "beam.y"], [2, 3])
    with xr.open_dataset(files[0]) as stored:
        assert set(found["outputs"]) == set(stored.data_vars)
        assert stored.sizes["head.x"] == 2
        low = next(row for row in found["ranges"] if row.get("coordinate") == "beam.y")["lowest"]
        own = stored["coordinate_hz"].sel(coordinate="beam.y")
        assert low["frequency_hz"] == float(own.min())
    assert "uPlot" in files[2].read_text()
    assert files[1].read_text().startswith("<?xml")


def test_map_of_a_lift_names_speeds_to_avoid():
    vary = ("--vary", "car.y=5m:35m:2,counterweight.y=35m:5m", "--count", "2")
    order = ("--order", "sheave=traction sheave", "--order", "rails=car.y/5m", "--speed", "car.y=0.2m/s:2m/s")
    found = answer("map", "lift-2-to-1", *vary, *order)
    assert found["shape"] == [2]
    assert [one["name"] for one in found["orders"]] == ["sheave", "rails"]
    assert found["orders"][1]["hz_per_speed"] == pytest.approx(0.2)
    assert all(0.2 <= zone["low"] < zone["high"] <= 2.0 for zone in found["zones"])
    assert found["covered_hz"] >= 2.0 * found["orders"][0]["hz_per_speed"]
    assert "\nClear of all modes: " in call("map", "lift-2-to-1", *vary, *order).stdout


@pytest.mark.parametrize("name", cd.packaged_drives())
def test_a_packaged_drive_written_to_a_file_loads_as_the_same_drive(name, tmp_path):
    file = tmp_path / "start.toml"
    call("drives", name, "-o", file)
    assert cd.content_hash(cd.load_drive(file)) == cd.content_hash(cd.load_drive(name))
    assert file.read_text() == answer("drives", name)["file"]
    assert file.read_text().rstrip("\n") == call("drives", name).stdout.rstrip("\n")


def test_every_packaged_drive_is_listed_with_the_kind_of_its_file():
    kinds = {row["name"]: row["kind"] for row in answer("drives")["drives"]}
    assert kinds == {name: tomllib.loads(packaged_text(name))["kind"] for name in cd.packaged_drives()}


# --- cabledrive resonance: what the contract promises, reasons beside nulls
@pytest.mark.parametrize("drive", ["dissertation-2", pytest.param("linear-axis", marks=pytest.mark.verify)])
def test_people_and_programs_get_frequencies_in_hz(drive):
    """Detuning and half-width of the instability region: the averaged equations have them in rad/s."""
    instability = resonance(load_drive(drive)).instability
    found = answer("resonance", drive)
    region = found["instability_region"]
    for key, value in (("detuning_hz", instability.distance), ("half_width_hz", instability.half_width)):
        assert region[key] == pytest.approx(value / (2 * np.pi), rel=1e-12)
    text = call("resonance", drive).stdout
    assert f"is detuned from 1:2 by {region['detuning_hz']:.4g} Hz" in text
    assert "rad/s" not in text


TUNED = ("--set", "cable.pretension=3.28377 N", "--set", "cable.transverse_damping=2")
DAMPED = (*TUNED, "--set", "pulley.1.viscous_friction=6e-5")


def test_a_motion_that_excites_the_cable_is_dangerous(tmp_path):
    """Two seconds of a sine at the pulley mode's frequency."""
    rows = [f"{t / 4},{50 * np.sin(2 * np.pi * 0.0817421 * t / 4)}" for t in range(8000)]
    path = tmp_path / "motion.csv"
    path.write_text("\n".join(["time [ms],torque [mN m]", *rows]) + "\n")
    found = answer("resonance", "dissertation-2", *DAMPED, "--motion", path)["motion"]
    assert found["verdict"] == "dangerous"
    assert found["limit"] == 5e-4
    assert found["largest_transverse"] > 5e-4
    assert found["modes"][0]["number"] == 1
    assert found["modes"][0]["excitation"] == "parametric"
    assert "damp the cable" in found["remedy"]


def test_a_steady_load_splits_the_tuning_of_the_spans():
    """dT = 2 tau / (2 r) apart: the mean tensions that tune the spans lie as far apart as their tensions."""
    found = answer("resonance", "dissertation-2", *TUNED, "--load-torque", "1 mN m")
    split = found["tuned_pretension_under_load"]
    assert split["lower"] - split["upper"] == pytest.approx(1e-3 / 0.03, rel=0.02), split
    assert found["tuned_pretension"] == pytest.approx(3.28377, rel=1e-5)


def test_branches_without_damping_end_with_status_3_and_keep_the_rest():
    result = call("resonance", "dissertation-2", "--torque", "40 mN m", "--branches", "--json")
    assert result.exit_code == 3
    assert "undamped" in result.stderr
    assert '"threshold_torque": 0' in result.stdout


def test_a_trial_that_would_slacken_a_span_is_no_remedy():
    """The lift at half its pretension hangs slack beside the car: that change is left out."""
    assert resonance(load_drive("elevator"), details=False).verdict == "no excitation given"
    found = answer("resonance", "elevator", "--set", "excitation.torque_ripple=1")
    assert found["verdict"] == "resonant"
    assert found["threshold_torque"] > 0.0
    assert any("keep the torque" in one["text"] for one in found["remedies"]), found["remedies"]
