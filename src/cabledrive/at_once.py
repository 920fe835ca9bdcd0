"""Ctrl-C while the libraries of the command load: imported before all of them, and of no effect elsewhere."""

import os
import signal
import sys
import threading
from contextlib import suppress


def leave_at_once(number: int, frame: object) -> None:
    """End the command on Ctrl-C while its libraries load: there is nothing yet to be put away.

    Parameters
    ----------
    number : int
        Of the signal.
    frame : object
    """
    with suppress(OSError):
        os.write(2, b"cabledrive: interrupted; nothing was kept; run the same command again\n")
    os._exit(130)


def _is_the_command() -> bool:
    """Whether this process is the command `cabledrive`, not another that imports the package."""
    name = os.path.splitext(os.path.basename(sys.argv[0] if sys.argv else ""))[0]
    return name == "cabledrive" or (name == "-m" and "cabledrive" in sys.orig_argv)


def _listen() -> bool:
    """End at once on an interrupt from here on, where that is this process's to decide."""
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not (usual and _is_the_command() and threading.current_thread() is threading.main_thread()):
        return False
    signal.signal(signal.SIGINT, leave_at_once)
    return True


LISTENS = _listen()
"""Whether an interrupt ends this process at once, until `cabledrive.app.interrupts` takes over."""
