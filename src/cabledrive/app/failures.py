"""How a command can end: an exit status, and one line on standard error for every status but 0."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from errno import EDQUOT, EIO, ENOSPC, EPIPE
from typing import Any

import click

from cabledrive.app.messages import complain
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.fields import nearest

DONE = 0
DEFECT = 1
REFUSED = 2
NOT_COMPUTED = 3
INTERRUPTED = 130

GO_ON = "nothing was kept; run the same command again"


class ReaderGone(Exception):
    """Who read standard output, such as ``head``, wants no more."""


@contextmanager
def watched_output() -> Iterator[None]:
    """Tell a defect from a standard output that takes no more.

    Yields
    ------
    None

    Raises
    ------
    ReaderGone
        If the reader has gone away.
    InputRefused
        If the disk is full.
    """
    try:
        yield
        sys.stdout.flush()
    except OSError as error:
        if error.errno not in (EPIPE, ENOSPC, EDQUOT, EIO):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is buffered has to go somewhere
        if error.errno == EPIPE:
            raise ReaderGone from None
        raise InputRefused(f"standard output: cannot be written ({error.strerror}): free space") from None


def status_of(run: Callable[[], Any]) -> int:
    """Run a command and say in one line why it failed, if it did.

    Parameters
    ----------
    run : callable
        Takes no argument; returns nothing, or the status with which click left early.

    Returns
    -------
    int
        0: done, also if the reader of standard output went away. 2: the input was refused, nothing was
        written. 3: the calculation could not be completed. 130: interrupted. 1: a defect of this package.
    """
    try:
        return run() or DONE
    except InputRefused as refusal:
        return _told(str(refusal), REFUSED)
    except click.UsageError as error:
        return _told(usage_line(error), REFUSED)
    except NotComputed as failure:
        return _told(str(failure), NOT_COMPUTED)
    except MemoryError:
        return _told("out of memory: ask for less, or for a smaller drive", NOT_COMPUTED)
    except (click.Abort, KeyboardInterrupt) as end:
        return _told(f"interrupted; {_advice(end)}", INTERRUPTED)
    except ReaderGone:
        return DONE
    except Exception as defect:
        what = f"{type(defect).__name__}: {defect}"
        return _told(f"a defect of cabledrive, {what}; please report it with the output of --verbose", DEFECT)


def usage_line(error: click.UsageError) -> str:
    """What is wrong with the arguments, in one line, with the nearest option where one was mistyped.

    Parameters
    ----------
    error : click.UsageError

    Returns
    -------
    str
    """
    if error.ctx is None:
        return error.format_message()
    if isinstance(error, click.NoSuchOption):
        known = [name for option in error.ctx.command.get_params(error.ctx) for name in option.opts]
        options = [name for name in known if name.startswith("--")]
        what = f"no such option {error.option_name}{nearest(error.option_name, options)}"
    else:
        what = error.format_message().rstrip(".")
    return f"{what[:1].lower()}{what[1:]}; see {error.ctx.command_path} --help"


def _advice(end: BaseException) -> str:
    """How to go on: a command that kept something says so in its KeyboardInterrupt."""
    cause = end.__cause__ if isinstance(end, click.Abort) else end
    return str(cause or "") or GO_ON


def _told(message: str, status: int) -> int:
    complain(str(InputRefused(message)))
    return status
