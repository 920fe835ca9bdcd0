"""A whole study of dissertation-3, 1,000 lumped plants and 20 on the cable, and the same served again."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from harness import table

TITLE = "Study"
TARGETS = {"study, 1,000 + 20 plants": "-", "the same again": "3 s"}


def report() -> str:
    with tempfile.TemporaryDirectory() as folder:
        command = ["study", "dissertation-3", "-o", str(Path(folder, "out")), "--quiet"]
        spent([*command[:2], "--quick", *command[2:3], str(Path(folder, "warm")), "--quiet"])  # compiles
        first, again = spent(command), min(spent(command) for _ in range(5))
    rows = [
        (name, f"{seconds:.2f} s", TARGETS[name])
        for name, seconds in zip(TARGETS, (first, again), strict=True)
    ]
    return table(["process", "time", "target"], rows) + "\n\nSeconds of the processor, start-up included."


def spent(arguments: list[str]) -> float:
    """Processor seconds of a command."""
    before = os.times()
    subprocess.run([sys.executable, "-m", "cabledrive", *arguments], check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system
