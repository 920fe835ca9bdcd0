"""The pages as a person uses them, in Chromium."""

import os
import re
import shlex
import statistics
import time
from pathlib import Path

import pytest

from command import call
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
