"""A use of a machine with routes, walked through in the browser without a terminal."""

import numpy as np
import pytest
from scipy.io import wavfile

from printer_logs import samples, write_densities
from studio_browser import studio_page

pytestmark = pytest.mark.verify
AT_MOST = 240_000
"""Milliseconds that one command may take on a busy machine."""


def finished(page):
    """Wait until the work on the page is done."""
    page.wait_for_url("**/studies/*?*")
    page.locator("#job .status:not(.running)").wait_for(timeout=AT_MOST)
    words = page.locator("#lines").inner_text()
    assert page.locator("#job .status").inner_text() == "done", words


def view(page, name):
    page.locator("a[data-tab]", has_text=name).click()
    page.wait_for_url(f"**/{name.lower()}?**")


def started(page, kind, **fields):
    """Fill one form of the studies, start it, wait for its end."""
    view(page, "Studies")
    form = page.locator(f"form[data-kind='{kind}']")
    for name, value in fields.items():
        field = form.locator(f"[name='{name}']")
        if field.evaluate("field => field.tagName") == "SELECT":
            field.select_option(value)
        else:
            field.fill(value)
    form.locator("button").click()
    finished(page)


def uploaded(page, path):
    view(page, "Logs")
    page.set_input_files("#upload", path)
    page.wait_for_url("**/logs?*log=*")
    page.locator("#from-log").wait_for()


def test_a_printer_is_mapped_pinged_and_shaped(tmp_path):
    sound = pinged(tmp_path, {"belt-a.wav": 30.0, "belt-b.wav": 26.0})
    measured_peak(tmp_path / "resonances_x_my.csv", 47.0)
    with studio_page(tmp_path / "folder", "corexy") as page:
        page.wait_for_selector("#result .pick")
        started(page, "travel", vary1="head.x=60mm:360mm:3", vary2="beam.y=50mm:330mm:3", count="2")
        page.frame_locator("iframe[title='map.html']").locator("svg, canvas").first.wait_for()

        uploaded(page, sound["belt-a.wav"])
        uploaded(page, sound["belt-b.wav"])
        page.select_option("#span", "motor b to rear left b")
        page.select_option("#log2", label="belt-a.wav")
        page.select_option("#span2", "motor a to rear right a")
        page.click("[data-kind='ping']")
        finished(page)
        assert page.locator("#job").inner_text().count("motor a to rear right a") >= 1

        measured_peak(tmp_path / "belt_a.csv", 50.0)
        measured_peak(tmp_path / "belt_b.csv", 58.0)
        for name in ("belt_a.csv", "belt_b.csv", "resonances_x_my.csv"):
            uploaded(page, tmp_path / name)
        page.click("[data-kind='shaper']")
        finished(page)
        shown = page.frame_locator("iframe[title='printer.html']")
        assert "loosen belt B" in shown.locator("body").inner_text()
        assert shown.locator("#spectrum-x").count() == 1
        page.click("#klipper")
        page.locator("h1", has_text="Printer lines").wait_for()
        finished(page)
        assert page.locator(".works a", has_text=".cfg").count() == 1


def pinged(folder, tensions):
    """Recordings of free spans of 0.42 m of the printer's belt, written as sound."""
    time, made = np.arange(8000) / 4000, {}
    for name, tension in tensions.items():
        first = np.sqrt(tension * (1 + tension / 19.4e3) / 8.3e-3) / (2 * 0.42)
        sound = sum(np.exp(-2 * time) * np.cos(2 * np.pi * k * first * time + k) / k**2 for k in (1, 2, 3))
        sound += 0.03 * np.random.default_rng(1).normal(size=time.size)
        made[name] = folder / name
        wavfile.write(made[name], 4000, np.round(1e4 * sound).astype(np.int16))
    return made


def measured_peak(path, peak):
    """A printer's log of resonances with one peak [Hz]."""
    return write_densities(path, samples([(peak, 0.05, 1.0)], np.random.default_rng(0)))
