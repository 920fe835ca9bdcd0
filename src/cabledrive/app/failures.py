"""How a command can end: an exit status and one line on standard error, also after Ctrl-C at any moment."""

import _thread
import errno
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import click

from cabledrive.at_once import LEAVE_WITH, leave_at_once
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.fields import nearest

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


PROGRAM = "cabledrive"
QUIET, BEGUN = "cabledrive.quiet", "cabledrive.begun"


def colours() -> bool | None:
    """Whether to colour: False under NO_COLOR, else None: click looks whether it is a terminal."""
    return False if os.environ.get("NO_COLOR") else None


def complain(message: str) -> None:
    """Write the one line that says why there is no result."""
    _write(f"{click.style(f'{PROGRAM}:', fg='red', bold=True)} {message}")


def note(message: str) -> None:
    """Write a note or the progress of long work; none under ``--quiet``, with times under ``--verbose``."""
    context = click.get_current_context(silent=True)
    settings = {} if context is None else context.meta
    if not settings.get(QUIET):
        begun = settings.get(BEGUN)
        _write(message if begun is None else f"{time.monotonic() - begun:8.2f} s  {message}")


def _write(line: str) -> None:
    try:
        click.echo(line, err=True, color=colours())
    except OSError:  # full, closed, its reader gone: no reason to end the work
        with suppress(OSError, ValueError):  # what is buffered has to go somewhere
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stderr.fileno())


DONE = 0
DEFECT = 1
REFUSED = 2
NOT_COMPUTED = 3
INTERRUPTED = 130

FULL = {errno.ENOSPC, errno.EDQUOT}
NO_DEFECTS = FULL | {errno.EACCES, errno.EFBIG, errno.EIO, errno.EMFILE, errno.ENFILE, errno.ENOMEM}
NO_DEFECTS |= {errno.EPERM, errno.EROFS, errno.ESTALE}
"""What a system may refuse in the middle of the work, however carefully it was asked before."""

GO_ON = "nothing was kept; run the same command again"


class ReaderGone(Exception):
    """Who read standard output, such as ``head``, wants no more."""


@contextmanager
def watched_output() -> Iterator[None]:
    """Tell a defect from a closed (`ReaderGone`) or full standard output, round what only writes there."""
    try:
        yield
        if sys.stdout is not None:  # else the shell has closed it: nobody wants to read
            sys.stdout.flush()
    except OSError as error:
        if error.errno not in FULL | {errno.EPIPE, errno.EIO, errno.EBADF}:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is buffered has to go somewhere
        if error.errno == errno.EPIPE:
            raise ReaderGone from None
        raise InputRefused(f"standard output: cannot be written ({error.strerror}): free space") from None


def status_of(run: Callable[[], Any]) -> int:
    """Run a command and say in one line why it failed, if it did.

    ``run``: takes no argument; returns nothing, or the status with which click left early.
    Returns 0: done, also if the reader of standard output went away. 2: the input was refused, nothing was
    written. 3: the calculation could not be completed. 130: interrupted. 1: a defect of this package.
    """
    try:
        return run() or DONE
    except InputRefused as refusal:
        return _reported(str(refusal), REFUSED)
    except click.UsageError as error:
        return _reported(usage_line(error), REFUSED)
    except NotComputed as failure:
        return _reported(str(failure), NOT_COMPUTED)
    except MemoryError:
        return _reported("out of memory: ask for less, or for a smaller drive", NOT_COMPUTED)
    except (click.Abort, KeyboardInterrupt, Interrupted) as end:
        return interrupted(end)
    except ReaderGone:
        return DONE
    except OSError as error:
        if error.errno not in NO_DEFECTS:
            return _defect(error)
        return _reported(trouble_line(error), NOT_COMPUTED)
    except Exception as defect:
        if isinstance(defect.__cause__, KeyboardInterrupt):  # while a class was made
            return interrupted()
        return _defect(defect)


def interrupted(end: BaseException | None = None) -> int:
    """Say that the command was interrupted, and in the words of its end how to go on; the exit status."""
    cause = end.__cause__ if isinstance(end, click.Abort) else end
    LEAVE_WITH.append(INTERRUPTED)
    return _reported(f"interrupted; {str(cause or '') or GO_ON}", INTERRUPTED)


def trouble_line(error: OSError) -> str:
    """What the system refused in the middle of the work, where, and how to go on."""
    place = error.filename if isinstance(error.filename, str) else "a file of this run"
    remedy = "free space" if error.errno in FULL else "make it usable"
    return f"{place}: {error.strerror}: {remedy}, and give the same command again; what is finished is kept"


def _defect(defect: Exception) -> int:
    what = f"{type(defect).__name__}: {defect}"
    return _reported(f"a defect of cabledrive, {what}; please report it with the output of --verbose", DEFECT)


def usage_line(error: click.UsageError) -> str:
    """What is wrong with the arguments, in one line, with the nearest option where one was mistyped."""
    if error.ctx is None:
        return error.format_message()
    if isinstance(error, click.NoSuchOption):
        known = [name for option in error.ctx.command.get_params(error.ctx) for name in option.opts]
        options = [name for name in known if name.startswith("--")]
        what = f"no such option {error.option_name}{nearest(error.option_name, options)}"
    else:
        what = error.format_message().rstrip(".")
    return f"{what[:1].lower()}{what[1:]}; see {error.ctx.command_path} --help"


def _reported(message: str, status: int) -> int:
    complain(str(InputRefused(message)))
    return status
