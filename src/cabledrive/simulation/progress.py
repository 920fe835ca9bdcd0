"""A line on standard error: how far a run is and how long it will take."""

import time

from cabledrive.parameters.terminal_line import TerminalLine, on_a_terminal

SECONDS_BETWEEN = 0.5


class Progress:
    """Progress of a run of some length [s], rewritten twice a second, by default where a terminal reads."""

    def __init__(self, duration: float, shown: bool | None) -> None:
        self._duration = duration
        self._shown = on_a_terminal() if shown is None else shown
        self._began = self._last = time.monotonic()
        self._from: float | None = None
        self._line = TerminalLine()

    def at(self, simulated: float) -> None:
        """Show the time reached in the run [s]."""
        now = time.monotonic()
        if self._from is None:
            self._from, self._began = simulated, now
        if not self._shown or now - self._last < SECONDS_BETWEEN or simulated <= self._from:
            return
        self._last = now
        left = (now - self._began) * (self._duration - simulated) / (simulated - self._from)
        share = 100.0 * simulated / self._duration
        words = f"{simulated:.4g} s of {self._duration:.4g} s ({share:.0f} %)"
        self._line.write(f"{words}, {rounded_time(left)} left")

    def end(self) -> None:
        """Clear the line."""
        self._line.clear()


def rounded_time(seconds: float) -> str:
    """A time [s] in seconds, minutes or hours."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = seconds / 60.0
    return f"{minutes:.0f} min" if minutes < 90.0 else f"{minutes / 60.0:.1f} h"
