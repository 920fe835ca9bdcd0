"""A file for HDF5, which survives no error of the disk and no interrupt in the middle of its work."""

import io
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


class CarefulFile(io.RawIOBase):
    """A new file, or one in another's place, that takes everything; ``error`` holds the first error."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.error: OSError | None = None
        self._file = path.open("wb+", buffering=0)

    def readable(self) -> bool:
        """True."""
        return True

    def writable(self) -> bool:
        """True."""
        return True

    def seekable(self) -> bool:
        """True."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        """As of any file."""
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        """As of any file."""
        return self._file.tell()

    def readinto(self, buffer: Any, /) -> int:
        """As of any file; what lies behind the end is zero."""
        size = self._file.readinto(buffer) or 0
        memoryview(buffer).cast("B")[size:] = bytes(len(buffer) - size)
        return len(buffer)

    def write(self, data: Any, /) -> int:
        """Write all, or remember why not; the size of all."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while len(left) and self.error is None:
                left = left[self._file.write(left) :]
        except OSError as error:
            self.error = error
        return size

    def truncate(self, size: int | None = None, /) -> int:
        """Cut or lengthen, or remember why not."""
        size = self.tell() if size is None else size
        try:
            self._file.truncate(size)
        except OSError as error:
            self.error = self.error or error
        return size

    def close(self) -> None:
        """Close the file; the errors of this, too, are remembered."""
        try:
            self._file.close()
        except OSError as error:
            self.error = self.error or error
        super().close()


@contextmanager
def interrupts_deferred() -> Iterator[list[int]]:
    """Keep interrupts back until the end, where `KeyboardInterrupt` is raised if one came.

    The list is not empty once one is waiting, so that long work can end early by itself.
    """
    waiting: list[int] = []
    usual = threading.current_thread() is threading.main_thread()
    if not usual or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield waiting
        return
    signal.signal(signal.SIGINT, lambda number, frame: waiting.append(number))
    try:
        yield waiting
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        if waiting:
            raise KeyboardInterrupt
