"""Killed workers and drivers, and rows that end their process: the store of an undisturbed campaign."""

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

from cabledrive.campaign.engine import Plan, do_alone
from cabledrive.campaign.spec import read_spec
from cabledrive.campaign.store import check_store, done_chunks
from campaign_computations import Dangerous, Sleepy, swept
from command import call, object_of, python, refusal

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and processes of POSIX")


def contents(store):
    """All files of a store but those of the times that rows took."""
    files = (path for path in store.rglob("*") if path.is_file())
    named = {str(path.relative_to(store)): path for path in files}
    return {name: path.read_bytes() for name, path in named.items() if not name.startswith("time/")}


def transporter_modes(*, rows, chunk):
    """SPEC of rows that take some milliseconds each."""
    return f"""
drive = "dissertation-transporter"
[vary]
"cable.pretension" = {{ from = "3 N", to = "9 N" }}
[design]
kind = "random"
rows = {rows}
[compute]
what = "modes"
chunk = {chunk}
count = 8
"""


SPEC = 'drive = "dissertation-3"\n[vary]\nown.x = { from = 0, to = 29 }\n[design]\nkind = "grid"\nrows = 30\n'
SPEC += "[compute]\nchunk = 4\n"


def test_a_killed_worker_and_a_poisoned_row_leave_the_store_of_a_serial_run(tmp_path):
    swept(tmp_path, SPEC, "quiet.zarr", computation=Dangerous(folder=str(tmp_path)))
    wild = Dangerous(folder=str(tmp_path), poison=(17.0,), once=(5.0,))
    found = swept(tmp_path, SPEC, "wild.zarr", computation=wild, workers=2)
    assert (tmp_path / "killed-5").exists()
    assert (found.done, found.refused, found.failed) == (30, 1, 1)
    a, b = (xr.open_zarr(tmp_path / f"{name}.zarr").load() for name in ("quiet", "wild"))
    assert int(b.code[17]) == 3
    assert "SIGABRT" in b.reason.values[17]
    others = [row for row in range(30) if row != 17]
    assert b.isel(row=others).drop_vars("time").equals(a.isel(row=others).drop_vars("time"))


INERTIAS = """
drive = "dissertation-2"
[vary]
"pulley.1.inertia" = { from = "20 kg cm^2", to = "26 kg cm^2" }
[design]
kind = "sobol"
rows = 32
[compute]
what = "modes"
chunk = 16
"""


def test_a_chunk_that_ended_its_process_or_lost_its_status_gets_the_same_bytes_again(tmp_path):
    store = tmp_path / "store.zarr"
    swept(tmp_path, INERTIAS)
    before = contents(store)
    status = store / "code/c/1"
    status.write_bytes(bytes(status.stat().st_size))  # as a loss of power may leave it
    assert done_chunks(store) == {0}
    for file in (status, *store.glob("longitudinal_hz/c/1/*")):
        file.unlink(missing_ok=True)
    spec = read_spec(tmp_path / "spec.toml")
    do_alone(1, Plan(spec=spec, store=store.resolve(), chunk=check_store(store, spec)))
    assert contents(store) == before


@pytest.mark.parametrize(
    ("kills", "rows", "chunk"),
    [(1, 80, 4), pytest.param(10, 900, 6, marks=pytest.mark.verify)],
    ids=["once", "ten times"],
)
def test_a_driver_killed_at_random_moments_ends_with_the_bytes_of_a_quiet_run(
    kills, rows, chunk, tmp_path, measured
):
    whole, cut = tmp_path / "whole.zarr", tmp_path / "cut.zarr"
    swept(tmp_path, transporter_modes(rows=rows, chunk=chunk), "whole.zarr")
    command = [sys.executable, "-m", "cabledrive", "sweep", str(tmp_path / "spec.toml"), "-o", str(cut)]
    moments, reached = random.Random(3), []
    for number in range(kills):
        driver = subprocess.Popen(
            [*command, "--workers", "2" if number % 2 else "1"], stderr=subprocess.DEVNULL
        )
        before = len(list(cut.glob("code/c/*")))
        # some of the moments lie before the first chunk of this driver, the others some chunks later
        wanted, latest = before + moments.randrange(1, 12), time.monotonic() + moments.uniform(0.5, 6.0)
        while driver.poll() is None:
            later = len(list(cut.glob("code/c/*")))
            if later >= wanted or (number % 3 == 1 and time.monotonic() > latest):
                break
            time.sleep(0.005)
        assert driver.poll() is None, "the campaign ended before the driver was killed"
        os.kill(driver.pid, signal.SIGKILL)
        driver.wait()
        reached.append(len(list(cut.glob("code/c/*"))))
    resumed = call("sweep", tmp_path / "spec.toml", "-o", cut, "--workers", 1, "--json")
    measured(f"chunks done when the driver was killed: {reached} of {rows // chunk}")
    assert object_of(resumed.stdout)["done"] == rows, resumed.stderr
    assert contents(cut) == contents(whole)
    left = sorted(path.name for path in tmp_path.iterdir() if "lock" not in path.name)
    assert left == ["cut.zarr", "spec.toml", "whole.zarr"]


def test_workers_with_another_version_are_refused_and_nothing_is_written(tmp_path, monkeypatch):
    from distributed import LocalCluster

    (tmp_path / "spec.toml").write_text(transporter_modes(rows=8, chunk=4))
    monkeypatch.setattr("cabledrive.campaign.engine.__version__", "9.9.9")
    with LocalCluster(n_workers=1, processes=False, dashboard_address="127.0.0.1:0") as cluster:
        address = cluster.scheduler_address
        line = refusal("sweep", tmp_path / "spec.toml", "-o", tmp_path / "x.zarr", "--scheduler", address)
    assert "cabledrive 0" in line
    assert "this is 9.9.9: install one version everywhere" in line
    assert [path.name for path in tmp_path.iterdir()] == ["spec.toml"]


def test_what_workers_are_forked_from_has_loaded_numba_and_started_no_thread():
    """A fork copies one thread alone: locks that another holds would stay locked in the worker."""
    code = (
        "import sys, threading, cabledrive.campaign.loaded_kernels\n"
        "print('cabledrive.mechanics.kernel_cache' in sys.modules, threading.active_count())"
    )
    assert python(code).split() == ["True", "1"]


OWN = (
    'drive = "dissertation-3"\n[vary]\nown.x = { from = 0, to = 1 }\n[design]\nkind = "random"\nrows = 600\n'
)
OWN += "[compute]\nchunk = 10\n"


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
    swept(tmp_path, OWN, "quiet.zarr", computation=Sleepy(0.0))
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
        found = swept(tmp_path, OWN, "wild.zarr", computation=Sleepy(0.1), workers=2)
    finally:
        ended.set()
        killer.join()
    measured(f"{len(killed)} workers killed within {found.seconds:.0f} s, {found.done} of 600 rows done")
    assert len(killed) >= 4
    assert (found.done, found.refused, found.failed) == (600, 0, 0)
    assert contents(tmp_path / "wild.zarr") == contents(tmp_path / "quiet.zarr")


@pytest.mark.verify
def test_the_engine_takes_under_three_percent_of_chunks_of_five_seconds(tmp_path, measured):
    """Rows that sleep need no processor: what a worker loses is the engine's and the store's."""
    found = swept(tmp_path, OWN.replace("600", "320"), computation=Sleepy(0.5), workers=8)
    data = xr.open_zarr(found.store).load()
    ideal = float(data.time.sum()) / 8.0
    lost = found.seconds / ideal - 1.0
    measured(
        f"32 chunks of 5 s on 8 sleeping workers: {found.seconds:.2f} s for {ideal:.2f} s, {100 * lost:.1f} %"
    )
    assert lost < 0.03
