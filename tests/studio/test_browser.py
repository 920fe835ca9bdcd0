"""The pages as a person uses them, in Chromium."""

import os
import re
import shlex
import statistics
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from command import call
from printer_logs import samples, write_densities
from studio_browser import CHROMIUM, VIEWS, need_browser, studio_page, studio_process

AXE = os.environ.get("AXE_CORE")  # path of axe.min.js
PICTURES = os.environ.get("STUDIO_PICTURES")  # folder that keeps the screenshots
WATCH = """() => {
  window.times = [];
  let begun = 0;
  const slider = document.querySelector("[data-slider='cable.pretension']");
  slider.addEventListener("input", () => { begun = performance.now(); }, true);
  const drawn = () => { if (begun) window.times.push(performance.now() - begun); begun = 0; };
  new MutationObserver(drawn).observe(document.getElementById("result"), { childList: true });
}"""


def slide(page, key, steps, button="ArrowRight"):
    slider = page.locator(f"[data-slider='{key}']")
    slider.focus()
    for _ in range(steps):
        page.keyboard.press(button)


def until(page, condition):
    """Wait until an expression holds; the page's own policy forbids what Playwright would evaluate in it."""
    deadline = time.monotonic() + 60.0
    while not page.evaluate(condition):
        assert time.monotonic() < deadline, condition
        page.wait_for_timeout(50)


def settled(page):
    """Wait until the page shows what its fields say."""
    until(page, "document.getElementById('result').dataset.shown?.split('?')[1] === location.search.slice(1)")


def test_a_slider_ends_in_what_modes_prints_and_undo_takes_it_back(tmp_path):
    with studio_page(tmp_path / "folder", "dissertation-3") as page:
        page.wait_for_selector("#result .pick")
        before = page.locator(".pick").all_inner_texts()
        slide(page, "cable.pretension", 100)
        settled(page)
        page.wait_for_timeout(300)
        shown = page.locator(".pick").all_inner_texts()
        line = shlex.split(page.locator("#command").inner_text())
        assert "cable.pretension=28 N" in " ".join(line)  # four times the value of the file
        assert shown == re.findall(
            r"^ *([\d.e+]+)  +\d+  (?:long|trans)", call(*line[1:]).stdout, re.MULTILINE
        )
        assert shown != before
        page.fill("[data-key='cable.pretension']", "-2 N")
        page.keyboard.press("Tab")
        beside = page.locator("[id='f-cable.pretension-r']")
        beside.wait_for()
        assert "must be above 0" in beside.inner_text()
        page.fill("[data-key='cable.pretension']", "9 N")
        page.keyboard.press("Tab")
        settled(page)
        assert 'pretension = "9 N"' in page.locator("#text").input_value()
        page.keyboard.press("Escape")
        page.go_back()  # to the refused state, which its address keeps
        beside.wait_for()
        assert "cable.pretension=9" not in page.url


@pytest.mark.verify
def test_the_page_is_usable_soon_after_the_start(tmp_path, measured):
    """Process start to a list of modes in the page, the browser open before; the second start of two."""
    need_browser()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        for name in ("first", "second"):
            page = browser.new_context().new_page()
            begun = time.perf_counter()
            with studio_process(tmp_path / name, "dissertation-3", warm=True) as (process, address):
                page.goto(address)
                page.wait_for_selector("#result .pick")
                taken, memory = time.perf_counter() - begun, resident(process.pid)
        browser.close()
    measured(f"process start to usable page: {taken:.2f} s; server {memory:.0f} MB then")
    assert taken < 5.0  # 2.5 s are wanted: benchmarks/performance.md has the distance


@pytest.mark.verify
def test_a_slider_moves_the_plot_within_a_frame_or_three(tmp_path, measured):
    """Input to new plot in the page, by the page's own clock; median and 90 % of 100 steps."""
    with studio_page(tmp_path / "folder", "dissertation-3", warm=True) as page:
        page.wait_for_selector("#warming", state="hidden", timeout=300_000)
        page.evaluate(WATCH)
        for _ in range(100):
            slide(page, "cable.pretension", 1)
            page.wait_for_timeout(120)
        settled(page)
        times = sorted(page.evaluate("window.times"))
        median, most = statistics.median(times), times[int(0.9 * len(times))]
        memory = resident(page.process.pid)
        measured(f"slider to plot: median {median:.0f} ms, 90 % {most:.0f} ms; server {memory:.0f} MB")
        assert len(times) >= 90
        assert (
            median < 250.0
        )  # 50 and 100 ms are wanted: benchmarks/performance.md has the distance and its cause
        assert most < 400.0
        assert memory < 200.0


def resident(pid):
    """Memory of a process [MB]."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) / 1e3


@pytest.mark.verify
def test_the_whole_tour_by_keyboard(tmp_path):
    with studio_page(tmp_path / "folder", "dissertation-2", tour=True) as page:
        for step in range(1, 6):
            page.locator("#tour[open] #tour-step", has_text=f"Step {step} ").wait_for()
            assert page.evaluate("document.activeElement.id") == "tour-next"
            page.keyboard.press("Enter")
        until(page, "!document.getElementById('tour').open")
        assert page.url.split("?")[0].endswith("/studies")
        for key, view in zip("12345", VIEWS, strict=True):
            page.keyboard.press(key)
            page.wait_for_url(f"**/{view}?**")


@pytest.mark.verify
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1440, 3840])
def test_every_view_fits_its_window_and_asks_nothing_of_others(tmp_path, width, scheme):
    """No part wider than the window, none empty, no error; nothing serious by axe-core (AXE_CORE: file)."""
    log = "time [s],torque [N m],angle [rad]\n" + "".join(
        f"{k / 1000},{(k % 200) / 100 - 1},{k / 500}\n" for k in range(3000)
    )
    height = {390: 844, 1440: 900, 3840: 2160}[width]
    window = {"width": width, "height": height, "scheme": scheme}
    with studio_page(tmp_path / "folder", "dissertation-2", **window) as page:
        base = page.address.split("?")[0]
        for view in VIEWS:
            page.goto(f"{base}{view}?drive={'dissertation-3' if view == 'control' else 'dissertation-2'}")
            wait_for(page, view, log)
            page.wait_for_timeout(300)
            beyond = page.evaluate(
                "document.documentElement.scrollWidth - document.documentElement.clientWidth"
            )
            assert beyond <= 0, f"{view} is {beyond} px wider than {width} px"
            assert len(page.locator("main").inner_text()) > 100
            if PICTURES:
                picture(page, Path(PICTURES) / f"{view}-{width}-{scheme}.png")
            if AXE:
                assert serious(page) == []


def wait_for(page, view, log):
    if view == "machine":
        page.wait_for_selector("#result .pick")
    if view == "resonance":
        page.frame_locator("#map").locator("#chart svg text").first.wait_for()
        page.locator("#map").scroll_into_view_if_needed()  # a frame out of sight is not painted
        page.wait_for_timeout(300)
        page.evaluate("scrollTo(0, 0)")
    if view == "logs":
        page.set_input_files("#upload", {"name": "bench.csv", "mimeType": "text/csv", "buffer": log.encode()})
        page.wait_for_selector("#plots .uplot")
        page.wait_for_selector("#check li")
    if view == "control":
        page.wait_for_selector("#error .uplot")


def picture(page, path):
    """The window as it is, and the whole page with its bars where they stand in it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.with_stem(f"window-{path.stem}").write_bytes(page.screenshot())
    page.evaluate(
        "document.querySelectorAll('.top, .bottom').forEach((bar) => { bar.style.position = 'static'; })"
    )
    path.write_bytes(page.screenshot(full_page=True))
    if page.locator("#map").count():  # a frame that the window does not show is not painted in a tall picture
        path.with_stem(f"map-{path.stem}").write_bytes(page.locator("#map").screenshot())


def serious(page):
    """What axe-core calls serious or critical."""
    page.evaluate(Path(AXE).read_text())
    found = page.evaluate("axe.run(document, { resultTypes: ['violations'] })")
    return [
        (one["id"], [node["html"][:120] for node in one["nodes"][:3]])
        for one in found["violations"]
        if one["impact"] in ("serious", "critical")
    ]


# --- A use of a machine with routes, walked through in the browser without a terminal
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


@pytest.mark.verify
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
