"""Kernels made ready in the background, so that the first slider, log or law does not wait for a compiler."""

import threading
import time
from collections.abc import Callable

from cabledrive.modal import modes
from cabledrive.parameters import InputRefused, NotComputed, load_drive


class Warm:
    """Runs each calculation once in a thread and knows which is next.

    Parameters
    ----------
    wanted : bool
        Whether anything is run.
    """

    def __init__(self, *, wanted: bool) -> None:
        self.words = _words(_CALCULATIONS[0][0]) if wanted else ""
        self._waits, self._ended = wanted, False

    def begin(self) -> None:
        """Start the thread, once: when the first page has gone out, which is not to wait for it."""
        if self._waits:
            self._waits = False
            threading.Thread(target=self._run, daemon=True, name="warm").start()

    def end(self) -> None:
        """Start no further calculation."""
        self._ended = True

    def _run(self) -> None:
        for words, calculation in _CALCULATIONS:
            if self._ended:
                break
            self.words = _words(words)
            try:
                calculation()
            except (InputRefused, NotComputed):  # the page will say so where it is asked for
                continue
            time.sleep(0)
        self.words = ""


def _words(calculation: str) -> str:
    return f"Getting ready: {calculation}. The page can be used meanwhile; the first result may take longer."


def _modes() -> None:
    for name in ("dissertation-3", "dissertation-transporter"):
        modes(load_drive(name), count=8)
        modes(load_drive(name), count=8, motor="held")


def _resonance() -> None:
    from cabledrive.studies.resonance import resonance

    resonance(load_drive("dissertation-2"))


def _control() -> None:
    from cabledrive.rig import track

    for law in ("pd", "darc-4"):
        track(load_drive("dissertation-3"), controller=law, bandwidth=30.0)


_CALCULATIONS: tuple[tuple[str, Callable[[], None]], ...] = (
    ("modes", _modes),
    ("internal resonance", _resonance),
    ("the rig of the controllers", _control),
)
