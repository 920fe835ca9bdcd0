"""`cabledrive modes`, `map`, `check`, `drives`: objects, tables that lose nothing, pictures of the same."""

import pytest
import xarray as xr

import cabledrive as cd
from cabledrive.modal.mode import multiplets
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
    done = call("modes", "camera-line", "--plot", path)
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
