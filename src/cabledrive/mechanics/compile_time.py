"""The first compilation of kernels on a machine takes seconds to minutes: what reports its begin."""

from collections.abc import Callable

LISTENERS: list[Callable[[str], None]] = []
"""Each is called with one line when a kernel of this process has to be compiled for the first time."""
_ANNOUNCED: list[str] = []


def announce(kernel: str, folder: str) -> None:
    """Say once in a process that kernels are compiled, and where they are kept for the next run."""
    if LISTENERS and not _ANNOUNCED:
        _ANNOUNCED.append(kernel)
        for listener in LISTENERS:
            listener(f"compiling kernels: seconds to a minute, once per version; kept in {folder}")
