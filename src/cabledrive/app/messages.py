"""Messages of a command on standard error, one line at a time."""

import os
import sys
import time
from contextlib import suppress

import click

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
