"""Campaigns through `cabledrive sweep`, store included: ``python benchmarks/campaign.py [part ...]``.

Not a case of `run.py`, which keeps to one core: these use two.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from pathlib import Path

import psutil
from campaign_work import Sleeping, Spinning, spin

from cabledrive.campaign import run_sweep

OWN = 'drive = "dissertation-3"\n[vary]\nown.x = { from = 0, to = 1 }\n[design]\nkind = "random"\nrows = 40\n'
VARIED = """drive = "DRIVE"
[vary]
"cable.pretension" = { from = "3 N", to = "9 N" }
"cable.mass_per_length" = { from = "3 g/m", to = "6 g/m" }
"pulley.1.inertia" = { normal = ["23.5 kg cm^2", "0.6 kg cm^2"] }
[design]
kind = "sobol"
rows = ROWS
[compute]
"""
TURNS = 5_000_000


def swept(spec: str, folder: Path, *options: str, **environment: str) -> tuple[dict, float]:
    """Answer of the command, and its processor time with that of its workers [s]."""
    (folder / "spec.toml").write_text(spec)
    store = tempfile.mkdtemp(dir=folder) + "/store.zarr"
    command = [sys.executable, "-m", "cabledrive", "sweep", str(folder / "spec.toml"), "-o", store, "--json"]
    spent: dict[int, float] = {}
    with open(folder / "answer", "w") as answer, open(folder / "errors", "w") as errors:
        driver = subprocess.Popen(
            [*command, *options], stdout=answer, stderr=errors, env=os.environ | environment
        )
        with suppress(psutil.Error):  # the last process ends between two looks
            one = psutil.Process(driver.pid)
            while driver.poll() is None:
                look(one, spent)
                time.sleep(0.1)
    assert driver.wait() == 0, (folder / "errors").read_text()
    return json.loads((folder / "answer").read_text()), sum(spent.values())


def look(driver: psutil.Process, spent: dict[int, float]) -> None:
    """Note the processor time [s] of a process and of those that it began; workers are not its children."""
    for one in (driver, *driver.children(recursive=True)):
        with suppress(psutil.Error):
            times = one.cpu_times()
            spent[one.pid] = times.user + times.system


def command_line(name: str, spec: str, folder: Path) -> str:
    said, spent = swept(spec, folder, "--workers", "2")
    assert said["failed"] == said["refused"] == 0, said
    return f"{name}: {said['rows']} rows, {said['seconds']:.1f} s, {said['setup_seconds']:.1f} s before; processor {spent:.1f} s"


def modes(folder: Path) -> str:
    spec = VARIED.replace("DRIVE", "dissertation-3").replace("ROWS", "1000000")
    return command_line("first 6 modes", spec + 'what = "modes"\ncount = 6\n', folder)


def thresholds(folder: Path) -> str:
    spec = VARIED.replace("DRIVE", "dissertation-2").replace("ROWS", "2000")
    return command_line("thresholds", spec + 'what = "resonance"\n', folder)


def own(folder: Path, computation, workers: int) -> float:
    """Time of 8 chunks of 5 rows [s]."""
    (folder / "own.toml").write_text(OWN + "[compute]\nchunk = 5\n")
    store = tempfile.mkdtemp(dir=folder) + "/store.zarr"
    return run_sweep(
        folder / "own.toml", store, computation=computation, workers=workers, progress=False
    ).seconds


def overhead(folder: Path) -> str:
    lines = []
    for workers in (1, 2):
        took, ideal = own(folder, Sleeping(1.0), workers), 40.0 / workers
        lines.append(
            f"chunks of 5 s, {workers} workers: {took:.2f} s for {ideal:g} s: {100 * (took / ideal - 1):.2f} %"
        )
    return "\n".join(lines)


def efficiency(folder: Path) -> str:
    one, two = (own(folder, Spinning(TURNS), workers) for workers in (1, 2))
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(spin, [1000] * 8))
        began = time.perf_counter()
        for _ in range(40):
            pool.submit(spin, TURNS).result()
        bare_one = time.perf_counter() - began
        began = time.perf_counter()
        list(pool.map(spin, [TURNS] * 40))
        bare_two = time.perf_counter() - began
    bare = bare_one / (2 * bare_two)
    return (
        f"40 rows: {one:.2f} s with 1 worker, {two:.2f} s with 2: efficiency {one / (2 * two):.3f}; "
        f"the same work in bare processes {bare_one:.2f} s and {bare_two:.2f} s: {bare:.3f}"
    )


def cold(folder: Path) -> str:
    """Kernels that all processes of a campaign compile on an empty cache: a file made anew has another number."""
    kernels = Path(tempfile.mkdtemp(dir=folder))
    seen: set[tuple[str, int]] = set()
    ended = threading.Event()

    def watch():
        while not ended.wait(0.01):
            for place, _, names in os.walk(kernels):
                for name in names:
                    with suppress(OSError):
                        seen.add((f"{place}/{name}", os.stat(f"{place}/{name}").st_ino))

    watcher = threading.Thread(target=watch)
    watcher.start()
    spec = (
        VARIED.replace("DRIVE", "dissertation-3").replace("ROWS", "32")
        + 'what = "track"\ncontroller = "pd"\nchunk = 4\n'
    )
    try:
        said, _ = swept(spec, folder, "--workers", "2", XDG_CACHE_HOME=str(kernels), NUMBA_CACHE_DIR="")
    finally:
        ended.set()
        watcher.join()
    made = Counter(name for name, _ in seen if "/.kernel-" not in name)
    twice = sum(count > 1 for count in made.values())
    return (
        f"cold caches, two workers: {len(made)} kernels compiled, {twice} of them more than once; "
        f"{said['setup_seconds']:.1f} s before the first chunk, {said['seconds']:.1f} s after"
    )


def plan(folder: Path) -> str:
    """First report of a plan of 10^7 rows, which is interrupted then."""
    spec = VARIED.replace("DRIVE", "dissertation-3").replace("ROWS", "10000000")
    (folder / "spec.toml").write_text(spec + 'what = "modes"\ncount = 6\n')
    status = folder / "store.zarr" / "code" / "c"
    command = [sys.executable, "-m", "cabledrive", "sweep", str(folder / "spec.toml"), "--workers", "2"]
    began = time.perf_counter()
    driver = subprocess.Popen([*command, "-o", str(folder / "store.zarr")], stderr=subprocess.DEVNULL)
    first, largest = None, 0
    while driver.poll() is None and (first is None or time.perf_counter() < began + 1.5 * first):
        with suppress(psutil.Error):
            largest = max(largest, psutil.Process(driver.pid).memory_info().rss)
        if first is None and status.is_dir() and any(status.iterdir()):
            first = time.perf_counter() - began
        time.sleep(0.02)
    driver.send_signal(signal.SIGINT)
    assert driver.wait() == 130
    return f"plan of 10^7 rows: first chunk done after {first:.1f} s; memory of the driver {largest / 1e6:.0f} MB"


PARTS = {one.__name__: one for one in (overhead, efficiency, cold, thresholds, modes, plan)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "parts", nargs="*", metavar="part", help=f"of {', '.join(PARTS)}; all if none is named"
    )
    for name in parser.parse_args().parts or PARTS:
        with tempfile.TemporaryDirectory() as folder:
            print(PARTS[name](Path(folder)), flush=True)


if __name__ == "__main__":
    main()
