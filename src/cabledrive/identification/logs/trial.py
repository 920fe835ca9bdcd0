"""A trial read in a process of its own: some libraries crash over a damaged file, or read it for ever."""

import os
import signal
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

from cabledrive.parameters import InputRefused

SECONDS = 3.0
BYTES_PER_SECOND = 50e6
LONGEST_WAIT = 15.0
"""Wall clock per second of processor time."""


def require_readable(path: Path, read: Callable[[], object]) -> None:
    """Refuse a file over which the process that reads it dies, or takes more time than its size explains.

    Where a process cannot be forked safely (anywhere but on Linux) nothing is tried.

    ``read``: reads what is to be read later; what it raises does not count here.
    Raises `InputRefused` if it crashes or does not end.
    """
    if sys.platform != "linux":
        return
    seconds = SECONDS + path.stat().st_size / BYTES_PER_SECOND
    sys.stdout.flush()
    sys.stderr.flush()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of threads: the child calls one library and ends
        child = os.fork()
    if child == 0:
        _try(read, seconds)
    try:
        status = _ended(child, LONGEST_WAIT * seconds)
    except BaseException:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        raise
    if status is None or os.WIFSIGNALED(status):
        number = None if status is None else os.WTERMSIG(status)
        endless = number in (None, signal.SIGXCPU)
        what = "reading it does not end" if endless else f"its library ends by signal {number}"
        raise InputRefused(f"{path.name}: is damaged ({what}): write it again")


def _try(read: Callable[[], object], seconds: float) -> None:
    """The child: reads, and never returns."""
    import resource

    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends it
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        read()
    finally:
        os._exit(0)


def _ended(child: int, longest: float) -> int | None:
    """Status of a process; None where it had to be killed."""
    began, pause = time.monotonic(), 1e-4
    while time.monotonic() - began < longest:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return status
        time.sleep(pause)
        pause = min(2.0 * pause, 0.02)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None
