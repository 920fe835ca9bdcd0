"""How a command ends: its exit status, and one line on standard error for every status but 0."""

import os
import signal
import subprocess
import sys
import time

import click
import pytest

from cabledrive.app.failures import status_of, watched_output
from cabledrive.app.options import answering, machine_argument
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import NotComputed
from command import call, listening, object_of, run, the_line

needs_full_disk = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")


NEW, KEPT = "nothing was kept; run the same command again", "12 of 40 draws are kept; add --resume to go on"


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (ZeroDivisionError("two\nlines"), 1, ("ZeroDivisionError: two\\nlines", "--verbose")),
        (KeyboardInterrupt(), 130, (NEW,)),
        (KeyboardInterrupt(KEPT), 130, (KEPT,)),
    ],
)
def test_a_defect_is_status_1_and_named_an_interrupt_130_and_says_how_to_go_on(capsys, error, status, words):
    def fail():
        raise error

    assert status_of(fail) == status
    printed = capsys.readouterr()
    assert printed.out == ""
    line = the_line(printed.err)
    assert all(part in line for part in words), line


def test_an_interrupt_while_a_class_is_made_is_one(capsys):
    """Some versions of Python hand it on as the cause of an error of theirs."""

    class Interrupts:
        def __set_name__(self, owner, name):
            raise KeyboardInterrupt

    assert status_of(lambda: type("Made", (), {"field": Interrupts()})) == 130
    assert capsys.readouterr().err.startswith("cabledrive: interrupted; ")


def test_reader_that_wants_no_more_is_no_failure():
    """`cabledrive modes elevator --json | head -1` leaves the pipe full and closed."""
    for arguments in (["modes", "elevator", "--json"], ["--help"], ["drives", "--json"]):
        read, write = os.pipe()
        os.close(read)
        done = run(*arguments, stdout=write, stderr=subprocess.PIPE, capture_output=False)
        os.close(write)
        assert (done.returncode, done.stderr) == (0, ""), arguments


@needs_full_disk
@pytest.mark.parametrize("arguments", [["modes", "elevator", "--json"], ["--help"], ["check", "elevator"]])
def test_full_disk_under_standard_output_is_status_2(arguments):
    with open("/dev/full", "w") as full:
        done = run(*arguments, stdout=full, stderr=subprocess.PIPE, capture_output=False)
    assert done.returncode == 2, done.stderr
    assert the_line(done.stderr).startswith("standard output: cannot be written (")


def test_file_trouble_that_is_not_standard_output_comes_through():
    with pytest.raises(PermissionError), watched_output():
        raise PermissionError(13, "no")


@click.command()
@answering
@machine_argument
def diverging(drive):
    """Finds nothing."""
    raise NotComputed("diverged at t = 3 s")


@click.command()
@answering
@machine_argument
def incomplete(drive):
    """Finds a part."""
    found = {"first": 1.0}
    return Answer(data=found, text="first: 1", provenance=provenance(drive), incomplete="second not found")


@click.command()
@answering
def defective():
    """Breaks."""
    raise ZeroDivisionError("here")


@pytest.mark.parametrize(
    ("command", "why", "first"),
    [(diverging, "diverged at t = 3 s", None), (incomplete, "second not found", 1.0)],
)
def test_what_was_found_is_printed_before_the_failure_with_its_reason(capsys, command, why, first):
    with pytest.raises(NotComputed, match=why):
        command(["dissertation-2", "--json"], standalone_mode=False)
    found = object_of(capsys.readouterr().out)
    assert (found["incomplete"], found.get("first")) == (why, first)
    assert found["provenance"]["drive"] == "Dissertation, configuration 2"
    with pytest.raises(NotComputed, match=why):
        command(["dissertation-2"], standalone_mode=False)
    assert capsys.readouterr().out == ("first: 1\n" if first else "")


def test_verbose_shows_the_traceback_of_a_defect(capsys):
    for arguments, shown in ([], False), (["--verbose"], True):
        with pytest.raises(ZeroDivisionError):
            defective(arguments, standalone_mode=False)
        assert ("Traceback" in capsys.readouterr().err) == shown


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_help_is_an_answer(arguments):
    result = call(*arguments)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "cabledrive study dissertation-3 --quick -o study" in result.stdout


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
    line = f'"{sys.executable}" -m cabledrive modes elevator --json {closed}'
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
