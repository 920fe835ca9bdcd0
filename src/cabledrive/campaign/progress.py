"""How far a campaign is: rows, rate, failures, time left, memory of the workers, on standard error."""

import sys
import time
from collections.abc import Callable

from cabledrive.campaign.work import Report
from cabledrive.parameters.terminal_line import TerminalLine, on_a_terminal
from cabledrive.simulation.progress import rounded_time

ON_A_TERMINAL, ELSEWHERE = 0.5, 30.0
"""Seconds between two lines."""


class CampaignProgress:
    """Adds up chunks and shows a line, rewritten in place on a terminal, else one every half minute.

    It starts with those of the campaign's rows that were done, refused and failed before.
    """

    def __init__(self, rows: int, done: dict[str, int], *, shown: bool) -> None:
        self._rows, self._shown = rows, shown
        self._line = TerminalLine() if on_a_terminal() else None
        self.done, self.bad = done["done"], done["refused"] + done["failed"]
        self._from, self._began = self.done, time.monotonic()
        self._last = self._began
        self.last_mark = time.monotonic()

    def add(self, report: Report, memory: Callable[[], float | None] = lambda: None) -> None:
        """Count a chunk. ``memory``: of all workers [bytes], asked when a line is shown."""
        self.last_mark = now = time.monotonic()
        self.done += report.done
        self.bad += report.refused + report.failed
        between = ON_A_TERMINAL if self._line is not None else ELSEWHERE
        if self._shown and now - self._last >= between:
            self._last = now
            self._write(self.line(now, memory()))

    def line(self, now: float, memory: float | None) -> str:
        """The line at a time of the monotonic clock."""
        rate = (self.done - self._from) / max(now - self._began, 1e-9)
        left = (self._rows - self.done) / rate if rate > 0.0 else None
        parts = [f"{self.done} of {self._rows} rows", f"{rate:.4g} rows/s", f"{self.bad} refused or failed"]
        parts += [f"{rounded_time(left)} left"] if left is not None else []
        parts += [f"workers {memory / 1e6:.0f} MB"] if memory is not None else []
        return ", ".join(parts)

    def _write(self, line: str) -> None:
        if self._line is not None:
            self._line.write(line)
        else:
            print(line, file=sys.stderr, flush=True)

    def end(self) -> None:
        """Clear the line."""
        if self._line is not None:
            self._line.clear()
