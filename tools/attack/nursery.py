"""A process that has loaded the package and starts each command it is asked for as a process of its own.

A command of its own takes more than a second to load its libraries; a fork of this process takes
milliseconds, and ends by the same signals, limits and faults. Run as a script by `Nursery`.
"""

import ctypes
import json
import os
import resource
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
COUNT, FAIL, FAIL_FROM_HERE, KILL, INTERRUPT = range(5)
SECONDS, BYTES = 600.0, 8 << 30


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How a command ended: its status (minus the signal that killed it), its two outputs, its writes."""

    status: int
    output: str
    errors: str
    calls: int = 0

    @property
    def line(self) -> str:
        """The last line on standard error."""
        return self.errors.rstrip("\n").rpartition("\n")[2]


class Nursery:
    """Starts commands; to be used as a context."""

    def __init__(self, *, library: Path | None = None, environment: dict[str, str] | None = None) -> None:
        given = os.environ | {"MPLBACKEND": "Agg", "OPENBLAS_NUM_THREADS": "1"} | (environment or {})
        if library is not None:
            given["LD_PRELOAD"] = str(library)
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / "nursery.py")],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=given,
        )  # fmt: skip
        self._answer()

    def __enter__(self) -> "Nursery":
        return self

    def __exit__(self, *error: object) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait(timeout=60)

    def run(self, *arguments: object, folder: Path, **options: Any) -> Ended:
        """One command, to its end; the options are those of a request, see `_become` and `_wait`."""
        return self.run_all([[*map(str, arguments)]], folder=folder, **options)[0]

    def run_all(self, commands: list[list[str]], *, folder: Path, **options: Any) -> list[Ended]:
        """Commands side by side, started at once."""
        assert self._process.stdin is not None
        request = {"commands": commands, "folder": str(folder), **options}
        self._process.stdin.write(json.dumps(request) + "\n")
        self._process.stdin.flush()
        return [Ended(**answer) for answer in self._answer()]

    def _answer(self) -> Any:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "the nursery has died"
        return json.loads(line)


def compiled_faults(folder: Path) -> Path | None:
    """The library of `faults.c`; None where there is no compiler, or no LD_PRELOAD."""
    compiler = next((c for c in ("cc", "gcc", "clang") if _there(c)), None)
    if compiler is None or not sys.platform.startswith("linux"):
        return None
    library = folder / "faults.so"
    command = [compiler, "-shared", "-fPIC", "-O1", "-o", str(library), str(HERE / "faults.c"), "-ldl"]
    done = subprocess.run(command, capture_output=True, text=True)
    return library if done.returncode == 0 else None


def _there(program: str) -> bool:
    return any(os.access(Path(folder) / program, os.X_OK) for folder in os.get_exec_path())


def _serve() -> None:
    import numpy as np

    _load_everything(np)
    _say([])
    for line in sys.stdin:
        request = json.loads(line)
        children = [_start(number, request) for number in range(len(request["commands"]))]
        _say([_wait(*child, request) for child in children])


def _say(answer: Any) -> None:
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()


def _load_everything(np: Any) -> None:
    """Import and compile in this process what the commands need: children find it done."""
    import filelock  # noqa: F401
    import h5netcdf  # noqa: F401
    import scipy.linalg  # noqa: F401

    import cabledrive.report
    import cabledrive.studies.study  # noqa: F401
    from cabledrive.app.main import main  # noqa: F401


def _start(number: int, request: dict[str, Any]) -> tuple[int, int, int, float]:
    """Fork one command; returns its process, the two files of its outputs and when it began."""
    output, errors = (os.memfd_create(name) for name in ("output", "errors"))
    began = time.monotonic()
    pid = os.fork()
    if pid == 0:
        _become(request["commands"][number], request, output, errors)
    return pid, output, errors, began


def _become(arguments: list[str], request: dict[str, Any], output: int, errors: int) -> None:
    """The child: never returns."""
    status = 97
    try:
        os.dup2(output, 1)
        os.dup2(errors, 2)
        sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
        sys.stderr = os.fdopen(2, "w", encoding="utf-8", closefd=False, buffering=1)
        os.chdir(request["folder"])
        resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        from cabledrive.app import main as door
        from cabledrive.at_once import leave_at_once

        for name, value in (request.get("set") or {}).items():
            _set(name, value)
        signal.signal(signal.SIGINT, leave_at_once)  # as where the process is the command
        if "mode" in request:
            journal = str(request.get("journal", ""))
            ctypes.CDLL(None).arm(
                str(request["root"]).encode(), journal.encode(), request["mode"],
                int(request.get("at", 0)), int(request.get("error", 0)),
            )  # fmt: skip
        try:
            door.main([*arguments], prog_name="cabledrive")
        except SystemExit as end:
            status = int(end.code or 0)
        sys.stdout.flush()
        if "mode" in request:
            os.write(errors, f"\nCALLS {ctypes.CDLL(None).counted()}".encode())
    except BaseException as error:
        os.write(2, f"\nescaped: {error!r}\n".encode())
        status = 98
    finally:
        os._exit(status)


def _set(name: str, value: Any) -> None:
    """A constant of a module, such as cabledrive.simulation.run:SECONDS_PER_COMMIT."""
    from importlib import import_module

    module, _, constant = name.partition(":")
    setattr(import_module(module), constant, value)


def _wait(pid: int, output: int, errors: int, began: float, request: dict[str, Any]) -> dict[str, Any]:
    deadline = began + float(request.get("seconds", SECONDS))
    while True:
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            break
        if time.monotonic() > deadline:
            os.kill(pid, signal.SIGKILL)
            done, status = os.waitpid(pid, 0)
            break
        time.sleep(0.001)
    message, calls = _content(errors), 0
    if "\nCALLS " in message:
        message, _, number = message.rpartition("\nCALLS ")
        calls = int(number)
    return {
        "status": os.waitstatus_to_exitcode(status),
        "output": _content(output),
        "errors": message,
        "calls": calls,
    }


def _content(descriptor: int) -> str:
    with os.fdopen(descriptor, "rb") as file:
        file.seek(0)
        return file.read().decode("utf-8", errors="replace")


if __name__ == "__main__":
    _serve()
