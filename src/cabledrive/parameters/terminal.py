"""What a terminal shows: how far long work is."""

import sys
import time

ON_A_TERMINAL, ELSEWHERE = 0.5, 30.0
"""Seconds between two lines."""


def on_a_terminal() -> bool:
    """Whether somebody may be looking: standard error is a terminal; a closed one is none."""
    return sys.stderr is not None and sys.stderr.isatty()


class Progress:
    """How far long work is: a line rewritten twice a second on a terminal, else a line every half minute.

    ``whole``: what is reached in the end; ``shown``: whether at all, None: where a terminal reads.
    """

    def __init__(self, whole: float, shown: bool | None) -> None:
        self._whole, self._in_place, self._width = whole, on_a_terminal(), 0
        self._shown = self._in_place if shown is None else shown
        self._began = self._last = time.monotonic()
        self._from: float | None = None

    def at(self, reached: float, words: str) -> None:
        """Show what has been reached, in words, and the time left."""
        now = time.monotonic()
        if self._from is None:
            self._from, self._began = reached, now
        between = ON_A_TERMINAL if self._in_place else ELSEWHERE
        if not self._shown or now - self._last < between or reached <= self._from:
            return
        self._last = now
        left = (now - self._began) * (self._whole - reached) / (reached - self._from)
        self._write(f"{words}, {rounded_time(left)} left")

    def _write(self, line: str) -> None:
        start, end = ("\r", "") if self._in_place else ("", "\n")
        print(f"{start}{line:<{self._width}}", end=end, file=sys.stderr, flush=True)
        self._width = len(line) if self._in_place else 0

    def end(self) -> None:
        """Clear the line."""
        if self._width:
            self._write("")
            print("\r", end="", file=sys.stderr, flush=True)


def rounded_time(seconds: float) -> str:
    """A time [s] in seconds, minutes or hours."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = seconds / 60.0
    return f"{minutes:.0f} min" if minutes < 90.0 else f"{minutes / 60.0:.1f} h"
