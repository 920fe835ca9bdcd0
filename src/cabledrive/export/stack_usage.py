"""Stack of a step, as a compiler at hand counts it."""

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

FLAGS = ("-std=c99", "-ffp-contract=off", "-O2", "-c", "-fstack-usage")


def stack_bytes(files: Mapping[str, str]) -> int | None:
    """Upper bound of the stack of any call [bytes]: all functions', none recursive; None: no compiler."""
    found = shutil.which("gcc")
    if found is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for name, text in files.items():
            if name.endswith((".h", ".c")):
                (place / name).write_text(text, encoding="utf-8")
        done = subprocess.run(
            [found, *FLAGS, "cabledrive_law.c"], cwd=place, capture_output=True, text=True, check=False
        )
        reports = list(place.glob("*.su"))
        if done.returncode or not reports:
            return None
        return sum(int(line.split("\t")[1]) for line in reports[0].read_text().splitlines())


def stack_words(files: Mapping[str, str]) -> str:
    """The stack in words."""
    found = stack_bytes(files)
    if found is None:
        return "Stack: compile with `gcc -fstack-usage`; no compiler was at hand to count it."
    return (
        f"Stack: at most {found} bytes, the sum over all functions as `gcc -O2 -fstack-usage` counts them "
        "where this was exported."
    )
