"""`cabledrive map`: what is written, and what is refused in one line."""

import pytest
import xarray as xr

from command import answer, call, refusal


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
    assert all(0.2 <= zone["low"] < zone["high"] <= 2.0 for zone in found["danger"])
    assert "Avoid" in call("map", "lift-2-to-1", *vary, *order).stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--vary", "head.x=60mm"), "KEY=FROM:TO"),
        (("--vary", "head.z=1:2"), "unknown key"),
        (("--vary", "head.x=60 kg:70 kg"), "dimension"),
        (("--vary", "head.x=60mm:360mm:0"), "number of values"),
        (("--vary", "head.x=60mm:360mm", "--order", "a=motor a"), "--speed"),
        (("--vary", "head.x=60mm:360mm", "--margin", "0.1"), "--order"),
        (("--vary", "head.x=60mm:360mm:99999", "--vary", "beam.y=1:2"), "number of values"),
    ],
)
def test_what_is_no_map_is_refused_in_one_line(options, words):
    assert words in refusal("map", "corexy", *options)
