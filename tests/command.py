"""Running the command `cabledrive` in tests, as a process of its own and inside this one; lines of Python."""

import json
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from cabledrive.parameters import InputRefused


def run(*arguments, **options):
    """The command as a process of its own, as a shell starts it; every warning of Python's is an error."""
    command = [sys.executable, "-W", "error", "-m", "cabledrive", *map(str, arguments)]
    environment = os.environ | {"MPLBACKEND": "Agg"} | options.pop("env", {})
    options = {"capture_output": True, "text": True, "timeout": 120} | options
    return subprocess.run(command, env=environment, **options)


def python(code, *arguments, paths=(), **environment):
    """What lines of Python print in a new process, which finds modules as this one does, and in ``paths``."""
    known = {"PYTHONPATH": os.pathsep.join(map(str, [*paths, *sys.path]))}
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, env=os.environ | known | environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def listening():
    """In a new process, before it starts: Ctrl-C counts, also where the tests were set to ignore it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def call(*arguments):
    """The command inside this process, which is faster; a defect comes through with its traceback."""
    from cabledrive.app.main import main

    result = CliRunner().invoke(main, [*map(str, arguments)], prog_name="cabledrive")
    assert isinstance(result.exception, SystemExit | None), result.exception
    return result


def refuse(constant):
    raise ValueError(f"{constant} in JSON")


def object_of(output):
    """The one JSON object of an output; no NaN, no Infinity, nothing before or after it."""
    found = json.loads(output, parse_constant=refuse)
    assert isinstance(found, dict)
    return found


def answer(*arguments):
    """The JSON object of a command that succeeds."""
    result = call(*arguments, "--json")
    assert result.exit_code == 0, result.stderr
    return object_of(result.stdout)


def refusal(*arguments, status=2):
    """The one line of a command that fails with this status and prints nothing on standard output."""
    result = call(*arguments)
    assert (result.exit_code, result.stdout) == (status, ""), (result.exit_code, result.output)
    return the_line(result.stderr)


def the_line(errors):
    """The one line on standard error, without the name of the program."""
    assert errors.count("\n") == 1, errors
    assert errors.endswith("\n"), errors
    program, line = errors.rstrip("\n").split(": ", maxsplit=1)
    assert program == "cabledrive", errors
    assert line.isprintable(), f"{line!r}"
    return line


def refused(call, *named):
    """The one line with which a call inside Python is refused; it holds all of these words."""
    with pytest.raises(InputRefused) as refusal:
        call()
    line = str(refusal.value)
    assert "\n" not in line
    assert all(words in line for words in named), line
    return line


def write_log(path):
    """A log of 2 s at 1 kHz: time, torque, angle."""
    time = 1e-3 * np.arange(2000)
    table = np.column_stack([time, np.sin(6 * time), np.degrees(np.cos(6 * time))])
    np.savetxt(path, table, delimiter=",", header="time [s],torque [N m],angle [deg]", comments="")
