"""Kernels made ready in the background, so that the first slider, log or law does not wait for a compiler."""

import subprocess
import sys
import threading

from cabledrive.modal import modes
from cabledrive.parameters import load_drive


class Warm:
    """Runs each calculation, if it is wanted at all, once, in a thread or a process; knows which is next."""

    def __init__(self, *, wanted: bool) -> None:
        self.words = _words(_CALCULATIONS[0][0]) if wanted else ""
        self._waits, self._ended = wanted, False
        self._process: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Start the thread, once: when the first page has gone out, which is not to wait for it."""
        if self._waits:
            self._waits = False
            threading.Thread(target=self._run, daemon=True, name="warm").start()

    def end(self) -> None:
        """Start no further calculation, and end the one that runs in a process."""
        self._ended = True
        if self._process is not None:
            self._process.kill()

    def _run(self) -> None:
        for words, command in _CALCULATIONS:
            if self._ended:
                break
            self.words = _words(words)
            if command:
                self._compile(command)
            else:
                _modes()
        self.words = ""

    def _compile(self, command: tuple[str, ...]) -> None:
        """Run a command for the kernels that it leaves in the cache; what it refuses the page will say."""
        self._process = subprocess.Popen(
            (sys.executable, "-m", "cabledrive", *command, "--quiet", "--json"),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        if self._ended:  # in the meantime
            self._process.kill()
        self._process.wait()


def _words(calculation: str) -> str:
    return f"Getting ready: {calculation}. The page can be used meanwhile; the first result may take longer."


def _modes() -> None:
    for name in ("dissertation-3", "dissertation-transporter"):
        modes(load_drive(name), count=8)
        modes(load_drive(name), count=8, motor="held")


_CALCULATIONS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("modes", ()),
    ("internal resonance", ("resonance", "dissertation-2")),
    ("the rig of the controllers", ("track", "dissertation-3", "--controller=darc-4", "--bandwidth=30")),
)
"""What is made ready: its words, and the command whose kernels it needs, compiled in a process of its own so
that the server does not hold them until a page asks; without one, modes."""
