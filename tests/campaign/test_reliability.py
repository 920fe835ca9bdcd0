"""Campaigns whose processes are killed again and again, and whose disk fills up: the store of a quiet run."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress

import pytest
import xarray as xr

from cabledrive.campaign import run_sweep
from campaign_computations import Sleepy
from campaign_stores import contents, transporter_modes
from command import object_of, run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and processes of POSIX")

OWN = (
    'drive = "dissertation-3"\n[vary]\nown.x = { from = 0, to = 1 }\n[design]\nkind = "random"\nrows = 600\n'
)
MODES = transporter_modes(rows=900, chunk=6)


def workers_of(driver):
    """Processes that a process started or had forked; not what tracks resources or forks them."""
    import psutil

    found = []
    for one in psutil.Process(driver).children(recursive=True):
        with suppress(psutil.Error):  # it has ended
            line, forked = " ".join(one.cmdline()), one.ppid() != driver
            found += [one] * ("spawn_main" in line or (forked and "forkserver" in line))
    return found


@pytest.mark.verify
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")
def test_a_random_worker_killed_every_five_seconds_until_the_end(tmp_path, measured):
    (tmp_path / "spec.toml").write_text(OWN + "[compute]\nchunk = 10\n")
    run_sweep(tmp_path / "spec.toml", tmp_path / "quiet.zarr", computation=Sleepy(0.0), progress=False)
    ended, killed = threading.Event(), []

    def kill():
        chosen = random.Random(1)
        while not ended.wait(5.0):
            if not list((tmp_path / "wild.zarr").glob("code/c/*")):
                continue  # it has not begun
            try:
                victim = chosen.choice(workers_of(os.getpid()))
                victim.kill()
                killed.append(victim.pid)
            except (IndexError, ProcessLookupError):
                continue

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        spec, store = tmp_path / "spec.toml", tmp_path / "wild.zarr"
        found = run_sweep(spec, store, computation=Sleepy(0.1), workers=2, progress=False)
    finally:
        ended.set()
        killer.join()
    measured(f"{len(killed)} workers killed within {found.seconds:.0f} s, {found.done} of 600 rows done")
    assert len(killed) >= 4
    assert (found.done, found.refused, found.failed) == (600, 0, 0)
    assert contents(tmp_path / "wild.zarr") == contents(tmp_path / "quiet.zarr")


@pytest.mark.verify
def test_a_driver_killed_at_ten_random_moments_ends_with_the_bytes_of_a_quiet_run(tmp_path, measured):
    (tmp_path / "spec.toml").write_text(MODES)
    whole, cut = tmp_path / "whole.zarr", tmp_path / "cut.zarr"
    run_sweep(tmp_path / "spec.toml", whole, progress=False)
    command = [sys.executable, "-m", "cabledrive", "sweep", str(tmp_path / "spec.toml"), "-o", str(cut)]
    moments, reached = random.Random(3), []
    for number in range(10):
        driver = subprocess.Popen(
            [*command, "--workers", "1" if number % 2 else "2"], stderr=subprocess.DEVNULL
        )
        before = len(list(cut.glob("code/c/*")))
        # half of the moments lie before the first chunk of this driver, the others some chunks later
        wanted, latest = before + moments.randrange(1, 12), time.monotonic() + moments.uniform(0.5, 6.0)
        while driver.poll() is None:
            later = len(list(cut.glob("code/c/*")))
            if later >= wanted or (number % 3 == 0 and time.monotonic() > latest):
                break
            time.sleep(0.005)
        assert driver.poll() is None, "the campaign ended before the driver was killed"
        os.kill(driver.pid, signal.SIGKILL)
        driver.wait()
        reached.append(len(list(cut.glob("code/c/*"))))
    resumed = run("sweep", tmp_path / "spec.toml", "-o", cut, "--workers", 1, "--json")
    measured(f"chunks done when the driver was killed: {reached} of 150")
    assert object_of(resumed.stdout)["done"] == 900, resumed.stderr
    assert contents(cut) == contents(whole)


@pytest.mark.verify
def test_the_engine_takes_under_three_percent_of_chunks_of_five_seconds(tmp_path, measured):
    """Rows that sleep need no processor: what a worker loses is the engine's and the store's."""
    (tmp_path / "spec.toml").write_text(OWN.replace("600", "320") + "[compute]\nchunk = 10\n")
    found = run_sweep(
        tmp_path / "spec.toml",
        tmp_path / "store.zarr",
        computation=Sleepy(0.5),
        workers=8,
        progress=False,
    )
    data = xr.open_zarr(found.store).load()
    ideal = float(data.time.sum()) / 8.0
    lost = found.seconds / ideal - 1.0
    measured(
        f"32 chunks of 5 s on 8 sleeping workers: {found.seconds:.2f} s for {ideal:.2f} s, {100 * lost:.1f} %"
    )
    assert lost < 0.03
