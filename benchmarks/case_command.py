"""Whole commands and first results, start-up included, with compiled kernels in the cache and without."""

import json
import os
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

from harness import duration, side_by_side, table

TITLE = "Command and first result"
COMMAND = [
    "simulate", "dissertation-2", "--duration", "1",
    "--torque-amplitude", "0.02", "--torque-frequency", "81.6", "--pluck-upper", "1 mm", "--pluck-lower", "1 mm", "--json",
]  # fmt: skip
FIRST = (
    "import cabledrive as cd; print(cd.simulate(cd.load_drive('dissertation-2'), 0.01).energy_budget_error)"
)
TARGETS = {"command, warm": 1.5, "first result, warm": 1.5, "first result, cold": 8.0}


def report() -> str:
    with tempfile.TemporaryDirectory() as folder:
        warm = os.environ | {"XDG_CACHE_HOME": str(Path(folder, "warm"))}
        runs = {"command, warm": partial(command, warm), "first result, warm": partial(first, warm)}
        times = side_by_side(runs)
        cold = min(first_cold(Path(folder), n) for n in range(3))
        error = command(warm, "--error-estimate")["error_estimate"]
    rows = [(name, duration(times[name]), f"{TARGETS[name]:g} s") for name in runs]
    rows.append(("first result, cold", f"{cold:.2f} s", f"{TARGETS['first result, cold']:g} s"))
    note = (
        f"`cabledrive {' '.join(COMMAND)}`. First result: `{FIRST}`. Cold: an empty cache, least of three. At "
        f"the default {error['segments'][0]} segments the load angle is within "
        f"{100 * error['load_angle']['relative']:.1g} %, the midpoint within "
        f"{100 * error['w at the middle of upper']['relative']:.1g} % of its largest value at every instant by the run's own "
        "estimate: the corners of undamped triangles are nowhere smooth. Envelopes after half-sines and, damped, "
        "after triangles are within 1 % (`tests/simulation/test_convergence.py`, marker `verify`)."
    )
    return table(["process", "time", "target"], rows) + "\n\n" + note


def command(environment: dict[str, str], *more: str) -> dict:
    script = "from cabledrive.app.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", script, *COMMAND, *more],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


def first(environment: dict[str, str]) -> str:
    done = subprocess.run(
        [sys.executable, "-c", FIRST], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout


def first_cold(folder: Path, number: int) -> float:
    """Processor seconds of a first result with nothing in the cache."""
    environment = os.environ | {"XDG_CACHE_HOME": str(folder / f"cold-{number}")}
    before, began = os.times(), time.perf_counter()
    first(environment)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return min(used, time.perf_counter() - began)
