"""Ctrl-C at any moment of a process, from the package's first line to its end: status 130 and one line."""

import os
import signal
import subprocess
import sys
import time

import pytest

from command import listening

FIRST_LINE = """
import os, sys
class Watch:
    def find_spec(self, name, path=None, target=None):
        if name == "cabledrive.mechanics":  # the first import of the package that takes time
            os.write({descriptor}, b"loading")
sys.meta_path.insert(0, Watch())
"""


def interrupted_after(delay, tmp_path, *arguments):
    """A command that gets an interrupt some time [s] after the package began to load."""
    read, write = os.pipe()
    (tmp_path / "sitecustomize.py").write_text(FIRST_LINE.format(descriptor=write))
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "MPLBACKEND": "Agg"}
    process = subprocess.Popen(
        [sys.executable, "-m", "cabledrive", *arguments], env=environment, pass_fds=[write],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=listening,
    )  # fmt: skip
    os.close(write)
    assert os.read(read, 7) == b"loading"
    os.close(read)
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    return process.returncode, errors


@pytest.mark.parametrize(
    "delays",
    [(0.01, 0.1, 0.3, 0.8), pytest.param([0.02 * k for k in range(1, 126)], marks=pytest.mark.verify)],
    ids=["few", "many"],
)
def test_an_interrupt_while_libraries_load_or_at_the_end_is_status_130_or_too_late(
    delays, tmp_path, measured
):
    found = [interrupted_after(delay, tmp_path, "modes", "dissertation-2", "--quiet") for delay in delays]
    measured(f"{sum(status == 130 for status, _ in found)} of {len(found)} interrupted, the others done")
    for delay, (status, errors) in zip(delays, found, strict=True):
        assert status in (0, 130), (delay, status, errors)
        assert len([line for line in errors.splitlines() if line]) == (status == 130), (delay, errors)
        assert status == 0 or errors.startswith("cabledrive: interrupted; "), (delay, errors)
    assert found[0][0] == 130


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_a_standard_file_that_the_shell_has_closed_is_no_defect(closed):
    line = f'"{sys.executable}" -m cabledrive check dissertation-3 --json {closed}'
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
