"""The two ways a request can end without a result, each with one line."""

from typing import Self

_LONGEST_LINE = 290
_LONGEST_PLACE = 120


class InputRefused(ValueError):
    """The input cannot be used: what, its value with unit, the bound it met, and the remedy.

    The command line prints the message as one line and ends with status 2; nothing was written.
    """

    def __init__(self, message: str) -> None:
        super().__init__(_one_line(message))

    def at(self, place: str) -> Self:
        """Say where: the same refusal with a file or key in front.

        Parameters
        ----------
        place : str
            File name or key path, put before the message and a colon.

        Returns
        -------
        InputRefused
            The refusal with its place.
        """
        shown = place if len(place) <= _LONGEST_PLACE else f"...{place[3 - _LONGEST_PLACE :]}"
        return type(self)(f"{shown}: {self}")


class NotComputed(RuntimeError):
    """A calculation could not be completed: what happened and when.

    The command line prints the message as one line, keeps what was found, and ends with status 3.
    """


def _one_line(message: str) -> str:
    """Escape what would break the line or hide in it; leave out the middle of what nobody would read."""
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in message)
    if len(line) <= _LONGEST_LINE:
        return line
    half = _LONGEST_LINE // 2 - 3
    return f"{line[:half]} ... {line[-half:]}"
