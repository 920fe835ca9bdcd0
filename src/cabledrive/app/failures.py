"""How a command can end: an exit status, and one line on standard error for every status but 0."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from errno import (
    EACCES,
    EBADF,
    EDQUOT,
    EFBIG,
    EIO,
    EMFILE,
    ENFILE,
    ENOMEM,
    ENOSPC,
    EPERM,
    EPIPE,
    EROFS,
    ESTALE,
)
from typing import Any

import click

from cabledrive.app.interrupts import Interrupted
from cabledrive.app.messages import complain
from cabledrive.at_once import LEAVE_WITH
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.fields import nearest

DONE = 0
DEFECT = 1
REFUSED = 2
NOT_COMPUTED = 3
INTERRUPTED = 130

NO_DEFECTS = {EACCES, EDQUOT, EFBIG, EIO, EMFILE, ENFILE, ENOMEM, ENOSPC, EPERM, EROFS, ESTALE}
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
        if error.errno not in (EPIPE, ENOSPC, EDQUOT, EIO, EBADF):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is buffered has to go somewhere
        if error.errno == EPIPE:
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
        return _defect(defect)


def interrupted(end: BaseException | None = None) -> int:
    """Say that the command was interrupted, and in the words of its end how to go on; the exit status."""
    cause = end.__cause__ if isinstance(end, click.Abort) else end
    LEAVE_WITH.append(INTERRUPTED)
    return _reported(f"interrupted; {str(cause or '') or GO_ON}", INTERRUPTED)


def trouble_line(error: OSError) -> str:
    """What the system refused in the middle of the work, where, and how to go on."""
    place = error.filename if isinstance(error.filename, str) else "a file of this run"
    remedy = "free space" if error.errno in (ENOSPC, EDQUOT) else "make it usable"
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
