"""What a command tells people on standard error, one line at a time."""

import os

import click

PROGRAM = "cabledrive"
QUIET = "cabledrive.quiet"


def colours() -> bool | None:
    """Whether to colour: never under NO_COLOR, else where a terminal reads.

    Returns
    -------
    bool or None
        False, or None: click looks whether it is a terminal.
    """
    return False if os.environ.get("NO_COLOR") else None


def complain(message: str) -> None:
    """Write the one line that says why there is no result.

    Parameters
    ----------
    message : str
    """
    _write(f"{click.style(f'{PROGRAM}:', fg='red', bold=True)} {message}")


def note(message: str) -> None:
    """Write a note or the progress of long work; nothing under ``--quiet``.

    Parameters
    ----------
    message : str
    """
    context = click.get_current_context(silent=True)
    if context is None or not context.meta.get(QUIET):
        _write(message)


def _write(line: str) -> None:
    click.echo(line, err=True, color=colours())
