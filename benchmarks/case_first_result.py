"""From the call to the first result with no kernel in the cache, beside a kernel that never changes."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from harness import table

TITLE = "First result in a new environment"
CALLS = {
    "modes": "cd.modes(cd.load_drive('dissertation-2'), below=300.0)",
    "simulate": "cd.simulate(cd.load_drive('dissertation-2'), 0.01)",
    "track": "cd.track(cd.load_drive('dissertation-3'), controller='pd')",
}
WANTED = {"modes": 2.0, "simulate": 6.0, "track": 20.0}
"""Seconds wanted on an idle AMD EPYC, which compiles the fixed kernel in `FIXED` seconds."""
FIXED = 1.05
ROUNDS = 3
SCRIPT = """
import sys, time
import cabledrive as cd
began = time.process_time()
{call}
print(time.process_time() - began)
"""


def report() -> str:
    """A row for each call: its time, and its ratio to the fixed kernel's compiled in the same round."""
    fixed, times = [], {name: [] for name in CALLS}
    for _ in range(ROUNDS):
        fixed.append(_in_a_new_process([str(Path(__file__).with_name("fixed_kernel.py"))]))
        for name, call in CALLS.items():
            times[name].append(_in_a_new_process(["-c", SCRIPT.format(call=call)]))
    rows = []
    for name, taken in times.items():
        ratio = min(one / base for one, base in zip(taken, fixed, strict=True))
        wanted = WANTED[name] / FIXED
        rows.append(
            (f"`{name}`", f"{min(taken):.1f} s", f"{ratio:.1f}", f"{wanted:.1f} ({WANTED[name]:g} s)")
        )
    note = (
        f"Processor time from the call to the result in a new process with an empty cache, least of {ROUNDS} "
        f"rounds; the fixed kernel (`benchmarks/fixed_kernel.py`) takes {min(fixed):.2f} s here and {FIXED:g} s on "
        "the idle AMD EPYC of the wanted seconds."
    )
    return table(["call", "time", "ratio to the fixed kernel", "wanted at most"], rows) + "\n\n" + note


def _in_a_new_process(arguments: list[str]) -> float:
    """Seconds that a process prints which finds no compiled kernel."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"XDG_CACHE_HOME": folder, "NUMBA_CACHE_DIR": ""}
        done = subprocess.run(
            [sys.executable, *arguments], env=environment, capture_output=True, text=True, check=True
        )
    return float(done.stdout.split()[-1])
