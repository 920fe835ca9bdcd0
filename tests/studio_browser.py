"""A browser at a studio of its own, for tests; skipped with a reason where there is none."""

import os
import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

from command import listening

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
VIEWS = ("machine", "resonance", "logs", "control", "studies")


def need_browser():
    pytest.importorskip("playwright.sync_api", reason="needs playwright, which is not installed")
    if CHROMIUM is None:
        pytest.skip("needs the browser chromium, which is not here")


@contextmanager
def studio_process(folder, *arguments, warm=False):
    """A studio as a shell starts it, with its address; every warning of Python's is an error."""
    command = [sys.executable, "-W", "error", "-m", "cabledrive", "studio", *arguments, "--no-browser"]
    environment = os.environ | ({} if warm else {"CABLEDRIVE_STUDIO_WARM": "0"})
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(
        [*command, "--folder", str(folder)], **pipes, preexec_fn=listening, env=environment
    ) as process:
        try:
            assert process.stdout is not None
            yield process, process.stdout.readline().strip()
        finally:
            process.terminate()


@contextmanager
def browser_page(address, *, width=1440, height=900, scheme="light", tour=False):
    """A page that has the studio's cookie; what it says on its console and asks of others is kept."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
        context.set_default_timeout(90_000)
        if not tour:
            context.add_init_script("try { localStorage.setItem('cabledrive-tour', 'done') } catch {}")
        page = context.new_page()
        page.said, page.foreign = [], []
        page.on(
            "console", lambda message: page.said.append(message.text) if message.type == "error" else None
        )
        page.on("pageerror", lambda error: page.said.append(str(error)))
        origin = address.split("/?")[0]
        page.on(
            "request",
            lambda request: (
                None
                if request.url.startswith((origin, "data:", "blob:"))
                else page.foreign.append(request.url)
            ),
        )
        page.goto(address)
        try:
            yield page
        finally:
            browser.close()


@contextmanager
def studio_page(folder, drive, *, warm=False, **options):
    """A studio of a drive, and a page at it that at the end has said nothing and asked nothing of others."""
    need_browser()
    with (
        studio_process(folder, drive, warm=warm) as (process, address),
        browser_page(address, **options) as page,
    ):
        page.process, page.address = process, address
        yield page
        assert [words for words in page.said if "(Unprocessable" not in words] == []  # a refusal is no error
        assert page.foreign == []
