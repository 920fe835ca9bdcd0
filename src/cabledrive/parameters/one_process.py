"""A folder in which one process works at a time, for as long as it lives."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from cabledrive.parameters.errors import InputRefused

LOCK = ".lock"
TRIES = 10


@contextmanager
def one_process(folder: Path) -> Iterator[None]:
    """Make a folder and keep it for this process alone; the system ends the lock with the process.

    It is removed if it is empty in the end, and so is its parent if it was made here. Refused if another
    process works in the folder, or it cannot be made or written.
    """
    from filelock import FileLock, Timeout

    removed = [folder] if folder.parent.exists() else [folder, folder.parent]
    lock = FileLock(folder / LOCK, timeout=0.0, is_singleton=False)
    try:
        for attempt in range(TRIES):
            try:
                folder.mkdir(parents=True, exist_ok=True)
                lock.acquire()
                break
            except FileNotFoundError:  # a process that has just finished removed the folder
                if attempt == TRIES - 1:
                    raise
    except Timeout:
        raise InputRefused(
            f"{folder}: another process works there: wait until it ends, or choose another name"
        ) from None
    except OSError as error:
        raise InputRefused(
            f"{folder}: cannot be written ({error.strerror or error}): choose another place"
        ) from None
    try:
        yield
    finally:
        with suppress(OSError):  # while it is held: whoever waits for this file finds that it is gone
            (folder / LOCK).unlink()
        lock.release()
        for place in removed:
            with suppress(OSError):  # not empty
                place.rmdir()
