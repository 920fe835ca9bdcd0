"""Compile and run what was exported."""

import shutil
import subprocess
from pathlib import Path

import pytest

needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
COMPILERS = [one for one in ("gcc", "clang") if shutil.which(one)]


def built(
    folder: Path, *flags: str, compiler: str = "cc", name: str = "check"
) -> subprocess.CompletedProcess[str]:
    """Compile every C file of a folder."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    files = [path.name for path in sorted(folder.glob("*.c"))]
    command = [compiler, "-std=c99", "-ffp-contract=off", *flags, *files, "-lm", "-o", name]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def checked(folder: Path, *flags: str, compiler: str = "cc") -> subprocess.CompletedProcess[str]:
    """Compile and run the self-test."""
    done = built(folder, *flags, compiler=compiler)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return subprocess.run(["./check"], cwd=folder, capture_output=True, text=True, check=False)
