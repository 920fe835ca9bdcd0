"""A study cancelled and resumed in the browser; the whole studio where there is no network."""

import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from studio_browser import browser_page, need_browser, studio_process

pytestmark = pytest.mark.verify


def report_of(folder, number):
    """A study's numbers and its page, without the time of writing and the hashes over it."""
    place = folder / "work" / f"{number:04d}" / "study"
    numbers = json.loads((place / "results.json").read_text())
    page = re.sub(r"\d\d:\d\d:\d\d", "", (place / "report.html").read_text())
    return {key: one for key, one in numbers.items() if key not in ("files", "sha256")}, page


def start_study(page):
    page.locator("a[data-tab]", has_text="Studies").click()
    page.locator("form[data-kind='study'] button").click()
    page.wait_for_url("**/studies/*?*")


def test_a_study_cancelled_in_the_browser_is_resumed_to_the_same_report(tmp_path, measured):
    """Cancelled after its second stage: shown as such within 2 s, then the report of an undisturbed one."""
    need_browser()
    folder = tmp_path / "folder"
    with studio_process(folder, "dissertation-2") as (_, address), browser_page(address) as page:
        start_study(page)
        page.locator("#lines", has_text="[2/").wait_for(timeout=300_000)
        begun = time.perf_counter()
        page.click("#cancel")
        page.locator("#job .status.cancelled").wait_for()
        taken = time.perf_counter() - begun
        measured(f"a study is shown as cancelled {taken:.2f} s after the click")
        assert taken < 2.0
        page.click("#resume")
        page.locator("#job .status.done").wait_for(timeout=600_000)
        page.frame_locator("iframe[title='study/report.html']").locator("h1").first.wait_for()
        start_study(page)
        page.locator("#job .status.done").wait_for(timeout=600_000)
        assert report_of(folder, 1) == report_of(folder, 2)


def test_every_view_works_in_a_network_namespace_without_a_route():
    need_browser()
    if shutil.which("unshare") is None or subprocess.run(["unshare", "-n", "true"], check=False).returncode:
        pytest.skip("needs unshare -n, which is not allowed here")
    views = str(Path(__file__).with_name("test_browser.py"))
    alone = f"{sys.executable} -m pytest -q -p no:cacheprovider -m verify {views} -k 1440-light"
    found = subprocess.run(
        ["unshare", "-n", "sh", "-c", f"ip link set lo up && exec {alone}"],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert found.returncode == 0, found.stdout
    assert "1 passed" in found.stdout
