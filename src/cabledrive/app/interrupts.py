"""Ctrl-C at any moment of the process: status 130 and one line, also while libraries load and at the end."""

import _thread
import os
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from cabledrive.at_once import leave_at_once

AGAIN = 0.01
"""Until an interrupt that could not be raised is raised again [s]."""
_UNRAISED: list[Any] = []


class Interrupted(Exception):
    """An interrupt on its way past those who would print a line of their own; says how to go on."""


def run_to_its_end(run: Callable[[], int], interrupted: Callable[[], int]) -> int:
    """Run what the process is for; from here on an interrupt is an exception, after it nothing.

    Where the process is not the command `cabledrive` itself, signals are left as they are. Both functions
    return the exit status.
    """
    here = threading.current_thread() is threading.main_thread()
    ours = here and signal.getsignal(signal.SIGINT) is leave_at_once
    if ours:
        _hold_the_standard_files()
        sys.unraisablehook = _unraisable
    try:
        try:
            if ours:
                signal.signal(signal.SIGINT, signal.default_int_handler)
            status = run()
            for unraisable in _UNRAISED if status == 0 else ():  # beside a failure, its line says it all
                sys.__unraisablehook__(unraisable)
            return status
        finally:
            if ours:
                signal.signal(
                    signal.SIGINT, signal.SIG_IGN
                )  # the status is known: nothing is left to interrupt
    except KeyboardInterrupt:
        return interrupted()


def _unraisable(unraisable: Any) -> None:
    """What came in a callback that can raise nothing: an interrupt is raised again a little later."""
    if isinstance(unraisable.exc_value, KeyboardInterrupt):
        again = threading.Timer(AGAIN, _thread.interrupt_main)
        again.daemon = True
        again.start()
    else:
        _UNRAISED.append(unraisable)


def _hold_the_standard_files() -> None:
    """Keep the numbers 0 to 2 from files that are opened later, where a shell has closed one of them."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            with suppress(OSError):
                os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
