"""What the command settles before its libraries load: Ctrl-C, and threads; of no effect elsewhere."""

import _signal as signal  # type: ignore[import-not-found]  # the module signal would load others first
import atexit
import os
import sys
from contextlib import suppress

LEAVE_WITH: list[int] = []
"""The status of an interrupted command, left with after all else is put away."""


def leave_with_status() -> None:
    """Leave with the status of an interrupted command.

    Python itself leaves by the signal, whatever the status, once an interrupt has met code that it compiles
    from text, as dataclasses are.
    """
    if LEAVE_WITH:
        for file in (sys.stdout, sys.stderr):
            with suppress(AttributeError, OSError, ValueError):  # closed, or nobody reads
                file.flush()
        os._exit(LEAVE_WITH[0])


def leave_at_once(number: int, frame: object) -> None:
    """End the command on Ctrl-C while its libraries load: there is nothing yet to be put away.

    ``number``: of the signal.
    """
    try:
        os.write(2, b"cabledrive: interrupted; nothing was kept; run the same command again\n")
    finally:
        os._exit(130)


def _is_the_command() -> bool:
    """Whether this process is the command `cabledrive`, not another that imports the package."""
    name = os.path.splitext(os.path.basename(sys.argv[0] if sys.argv else ""))[0]
    return name == "cabledrive" or (name == "-m" and "cabledrive" in sys.orig_argv)


def _listen() -> bool:
    """End at once on an interrupt from here on, where that is this process's to decide."""
    if not _is_the_command() or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return False
    try:
        signal.signal(signal.SIGINT, leave_at_once)
    except ValueError:  # not in the main thread
        return False
    atexit.register(leave_with_status)  # the first to be registered is the last to run
    return True


def _with_one_thread() -> None:
    """Let the linear algebra use one thread: on small matrices several wait for one another."""
    for library in ("OPENBLAS", "MKL") if _is_the_command() else ():
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")


_with_one_thread()
LISTENS = _listen()
"""Whether an interrupt ends this process at once, until `cabledrive.app.failures` takes over."""
