"""The page of a campaign in a browser: its figures answer to the mouse."""

import re

import numpy as np
import pytest
import xarray as xr

from cabledrive.campaign import run_sweep
from command import answer
from studio_browser import browser_page, need_browser


@pytest.mark.verify
def test_an_interval_dragged_along_an_axis_chooses_the_rows_inside_it(tmp_path):
    need_browser()
    (tmp_path / "spec.toml").write_text(
        'drive = "dissertation-3"\n[vary]\n"cable.pretension" = { from = "3 N", to = "7 N" }\n'
        '"pulley.1.inertia" = { normal = ["23.5 kg cm^2", "1 kg cm^2"] }\n'
        '[design]\nkind = "sobol"\nrows = 128\n[compute]\nwhat = "modes"\ncount = 2\n'
    )
    store, path = tmp_path / "store.zarr", tmp_path / "page.html"
    run_sweep(tmp_path / "spec.toml", store, progress=False)
    answer("report", str(store), "--goal", "longitudinal_hz[0] < 5.9 Hz", "-o", str(path))
    data = xr.open_zarr(store).load()
    with browser_page(path.as_uri()) as page:
        drawn = page.locator("#chart").inner_html()
        page.select_option("#x", index=1)
        assert page.locator("#chart").inner_html() != drawn
        grip = page.locator("#parallel .grip").first
        grip.scroll_into_view_if_needed()
        box = grip.bounding_box()
        x, top, height = box["x"] + 0.5 * box["width"], box["y"], box["height"]
        page.mouse.move(x, top + 0.1)
        page.mouse.down()
        page.mouse.move(x, top + 0.5 * height)
        page.mouse.up()
        values = data["cable.pretension"].values
        upper = values > 0.5 * (values.min() + values.max())
        good = upper & (data.longitudinal_hz[:, 0].values < 5.9)
        chosen, rows, blue, *_ = map(int, re.findall(r"\d+", page.inner_text("#chosen")))
        assert (chosen, rows) == (
            pytest.approx(np.sum(upper), abs=2),
            128,
        )  # a pixel is wide
        assert blue == pytest.approx(np.sum(good), abs=2)
        page.click("#all")
        assert page.inner_text("#chosen").startswith("128 of 128")
        assert not page.said
        assert not [one for one in page.foreign if not one.startswith("file:")]
