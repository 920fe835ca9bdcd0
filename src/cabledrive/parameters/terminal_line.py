"""A line on standard error that the next one covers."""

import sys


def on_a_terminal() -> bool:
    """Whether somebody may be looking: standard error is a terminal; a closed one is none."""
    return sys.stderr is not None and sys.stderr.isatty()


class TerminalLine:
    """A line that is rewritten in place and cleared at the end."""

    def __init__(self) -> None:
        self._width = 0

    def write(self, line: str) -> None:
        """Show a line over the one before, all of it."""
        print(f"\r{line:<{self._width}}", end="", file=sys.stderr, flush=True)
        self._width = len(line)

    def clear(self) -> None:
        """Leave nothing behind."""
        if self._width:
            self.write("")
            print("\r", end="", file=sys.stderr, flush=True)
