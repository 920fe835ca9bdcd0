"""Killed workers and drivers and rows that end their process: the store equals an undisturbed one."""

import os
import signal
import subprocess
import sys
import time

import xarray as xr

from cabledrive.campaign import run_sweep
from cabledrive.campaign.processes import do_alone
from cabledrive.campaign.spec import read_spec
from cabledrive.campaign.store import check_store, done_chunks
from cabledrive.campaign.work import Plan
from campaign_computations import Dangerous
from campaign_stores import contents, transporter_modes
from command import object_of, refusal, run

SPEC = 'drive = "dissertation-3"\n[vary]\nown.x = { from = 0, to = 29 }\n[design]\nkind = "grid"\nrows = 30\n'
CHUNK = "[compute]\nchunk = 4\n"


def test_a_killed_worker_and_a_poisoned_row_leave_the_store_of_a_serial_run(tmp_path):
    (tmp_path / "spec.toml").write_text(SPEC + CHUNK)
    quiet = Dangerous(folder=str(tmp_path))
    run_sweep(tmp_path / "spec.toml", tmp_path / "quiet.zarr", computation=quiet, progress=False)
    wild = Dangerous(folder=str(tmp_path), poison=(17.0,), once=(5.0,))
    found = run_sweep(
        tmp_path / "spec.toml", tmp_path / "wild.zarr", computation=wild, workers=2, progress=False
    )
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
    (tmp_path / "spec.toml").write_text(INERTIAS)
    store = tmp_path / "whole.zarr"
    run_sweep(tmp_path / "spec.toml", store, progress=False)
    before = contents(store)
    status = store / "code/c/1"
    status.write_bytes(bytes(status.stat().st_size))  # as a loss of power may leave it
    assert done_chunks(store) == {0}
    for file in (status, *store.glob("longitudinal_hz/c/1/*")):
        file.unlink(missing_ok=True)
    spec = read_spec(tmp_path / "spec.toml")
    do_alone(1, Plan(spec=spec, store=store.resolve(), chunk=check_store(store, spec)))
    assert contents(store) == before


MODES = transporter_modes(rows=80, chunk=4)


def test_a_driver_that_is_killed_resumes_to_the_same_bytes(tmp_path):
    (tmp_path / "spec.toml").write_text(MODES)
    whole, cut = tmp_path / "whole.zarr", tmp_path / "cut.zarr"
    run_sweep(tmp_path / "spec.toml", whole, progress=False)
    command = [sys.executable, "-m", "cabledrive", "sweep", str(tmp_path / "spec.toml"), "-o", str(cut)]
    driver = subprocess.Popen([*command, "--workers", "1"], stderr=subprocess.PIPE)
    deadline = time.monotonic() + 60.0
    while not list(cut.glob("code/c/*")):
        assert driver.poll() is None, driver.stderr.read()
        assert time.monotonic() < deadline
        time.sleep(0.01)
    os.kill(driver.pid, signal.SIGKILL)
    driver.wait()
    driver.stderr.close()
    before = len(list(cut.glob("code/c/*")))
    assert before < 20, "the driver was done before it was killed"
    resumed = run("sweep", tmp_path / "spec.toml", "-o", cut, "--workers", 1, "--json")
    assert object_of(resumed.stdout)["done"] == 80, resumed.stderr
    assert contents(cut) == contents(whole)
    assert sorted(path.name for path in tmp_path.iterdir() if "lock" not in path.name) == [
        "cut.zarr",
        "spec.toml",
        "whole.zarr",
    ]


def test_workers_with_another_version_are_refused_and_nothing_is_written(tmp_path, monkeypatch):
    from distributed import LocalCluster

    (tmp_path / "spec.toml").write_text(MODES)
    monkeypatch.setattr("cabledrive.campaign.cluster.__version__", "9.9.9")
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
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "1"]
