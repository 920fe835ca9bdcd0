"""How a command ends: its exit status, and one line on standard error for every status but 0."""

import os
import signal
import subprocess
import sys
import time

import click
import pytest

from cabledrive.app.failures import status_of, watched_output
from cabledrive.app.options import answering, drive_argument
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import InputRefused, NotComputed
from command import call, object_of, refusal, run, the_line

needs_full_disk = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")


def ending_of(capsys, error):
    """Exit status and line of a command that raises an error."""

    def fail():
        raise error

    status = status_of(fail)
    captured = capsys.readouterr()
    assert captured.out == ""
    return status, the_line(captured.err)


def test_done_is_status_0_and_silent():
    done = run("modes", "dissertation-2", "--count", "1")
    assert (done.returncode, done.stderr) == (0, "")
    assert "81.7420768" in done.stdout


def test_refused_input_is_status_2(capsys):
    assert ending_of(capsys, InputRefused("cable.pretension = 0 N must be above 0")) == (
        2,
        "cable.pretension = 0 N must be above 0",
    )


def test_calculation_that_fails_is_status_3(capsys):
    assert ending_of(capsys, NotComputed("diverged at t = 3 s")) == (3, "diverged at t = 3 s")


def test_out_of_memory_is_status_3(capsys):
    status, line = ending_of(capsys, MemoryError())
    assert status == 3
    assert "out of memory" in line


def test_defect_is_status_1_in_one_line_that_names_it(capsys):
    status, line = ending_of(capsys, ZeroDivisionError("two\nlines"))
    assert status == 1
    assert "ZeroDivisionError: two\\nlines" in line
    assert "--verbose" in line


@pytest.mark.parametrize(
    ("interrupt", "advice"),
    [
        (KeyboardInterrupt(), "nothing was kept; run the same command again"),
        (
            KeyboardInterrupt("12 of 40 draws are kept; add --resume to go on"),
            "12 of 40 draws are kept; add --res",
        ),
    ],
)
def test_interrupt_is_status_130_and_says_how_to_go_on(capsys, interrupt, advice):
    status, line = ending_of(capsys, interrupt)
    assert status == 130
    assert advice in line


def test_ctrl_c_at_work_is_status_130():
    code = (
        "import signal, time; signal.signal(signal.SIGINT, signal.default_int_handler);"
        "from cabledrive.app import main, options;"
        "options.load_drive = lambda *given, **more: time.sleep(60.0);"  # work without an end
        "print(flush=True); main.main()"
    )
    command = [sys.executable, "-c", code, "modes", "elevator"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.5)  # from the command's start to its wait
        process.send_signal(signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    assert (process.returncode, output) == (130, "")
    assert "run the same command again" in the_line(errors.lstrip("\n"))


def test_reader_that_wants_no_more_is_no_failure():
    """`cabledrive modes ropeway --json | head -1` leaves the pipe full and closed."""
    for arguments in (["modes", "ropeway", "--json"], ["--help"], ["drives", "--json"]):
        read, write = os.pipe()
        os.close(read)
        done = run(*arguments, stdout=write, stderr=subprocess.PIPE, capture_output=False)
        os.close(write)
        assert (done.returncode, done.stderr) == (0, ""), arguments


@needs_full_disk
@pytest.mark.parametrize("arguments", [["modes", "elevator", "--json"], ["--help"], ["check", "ropeway"]])
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
@drive_argument
def diverging(drive):
    """Finds nothing."""
    raise NotComputed("diverged at t = 3 s")


@click.command()
@answering
@drive_argument
def incomplete(drive):
    """Finds a part."""
    found = {"first": 1.0}
    return Answer(data=found, text="first: 1", provenance=provenance(drive), incomplete="second not found")


@click.command()
@answering
def defective():
    """Breaks."""
    raise ZeroDivisionError("here")


def test_json_is_printed_when_nothing_could_be_computed(capsys):
    with pytest.raises(NotComputed, match="diverged at t = 3 s"):
        diverging(["dissertation-2", "--json"], standalone_mode=False)
    found = object_of(capsys.readouterr().out)
    assert found["incomplete"] == "diverged at t = 3 s"
    assert found["provenance"]["drive"] == "Dissertation, configuration 2"


@pytest.mark.parametrize("arguments", [["dissertation-2"], ["dissertation-2", "--json"]])
def test_what_was_found_is_printed_before_the_failure(capsys, arguments):
    with pytest.raises(NotComputed, match="second not found"):
        incomplete(arguments, standalone_mode=False)
    output = capsys.readouterr().out
    if "--json" in arguments:
        found = object_of(output)
        assert (found["first"], found["incomplete"]) == (1.0, "second not found")
    else:
        assert output == "first: 1\n"


def test_verbose_shows_the_traceback_of_a_defect(capsys):
    for arguments, shown in ([], False), (["--verbose"], True):
        with pytest.raises(ZeroDivisionError):
            defective(arguments, standalone_mode=False)
        assert ("Traceback" in capsys.readouterr().err) == shown


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["mode"], 'no such command "mode" (did you mean "modes"?); see cabledrive --help'),
        (["--versoin"], 'no such option --versoin (did you mean "--version"?); see cabledrive --help'),
        (
            ["modes", "elevator", "--belwo", "3"],
            'no such option --belwo (did you mean "--below"?); see cabledrive modes --help',
        ),
        (["check", "elevator", "--jsno"], 'no such option --jsno (did you mean "--json"?)'),
        (["modes"], "missing argument 'DRIVE'; see cabledrive modes --help"),
        (
            ["modes", "elevator", "--count", "few"],
            "invalid value for '--count': 'few' is not a valid integer",
        ),
        (
            ["check", "elevator", "ropeway"],
            "unexpected extra argument (ropeway); see cabledrive check --help",
        ),
        (["report", "elevator"], "missing option '-o' / '--output'; see cabledrive report --help"),
        (["modes", "elevator", "--below"], "'--below' requires an argument"),
        (
            ["modes", "elevator", "--below", "50 rad/s"],
            '--below: "50 rad/s" is an angular speed [rad/s], not Hz',
        ),
        (["modes", "elevator", "--below", "nan"], '--below: "nan" is not a quantity'),
        (["mo\ndes"], 'no such command "mo\\ndes"'),
    ],
)
def test_mistyped_arguments_are_refused_in_one_line_with_the_nearest(arguments, line):
    assert line.lower() in refusal(*arguments).lower()


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"]])
def test_help_is_an_answer(arguments):
    result = call(*arguments)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "cabledrive study dissertation-3 --quick -o study" in result.stdout
