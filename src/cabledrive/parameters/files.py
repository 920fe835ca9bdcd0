"""Files that appear whole or not at all, folders of one process at a time, JSON that carries its hash."""

import hashlib
import json
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EMLINK, ENOTSUP, EPERM
from pathlib import Path
from typing import Any

from cabledrive.parameters.errors import InputRefused, NotComputed


def require_regular(path: str | Path, remedy: str) -> Path:
    """Refuse an input that is no regular file: a pipe would keep a command waiting, a device never ends.

    ``remedy``: what to give instead.
    """
    path = Path(path)
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        raise InputRefused(f"no such file: {remedy}").at(str(path)) from None
    except (OSError, ValueError) as error:  # no permission, a name too long, a NUL in it
        reason = getattr(error, "strerror", None) or error
        raise InputRefused(f"cannot be read ({reason}): check the path").at(str(path)) from None
    if stat.S_ISDIR(mode):
        raise InputRefused(f"is a folder: {remedy}").at(str(path))
    if not stat.S_ISREG(mode):
        raise InputRefused(f"is a device or a pipe, no regular file: {remedy}").at(str(path))
    return path


def check_writable(path: str | Path, *, force: bool = False) -> Path:
    """Refuse an output path before the work starts: no file, no writable folder, or there without `force`."""
    path = _check_place(Path(path), force)
    try:
        _try_to_write(path.parent)
    except OSError as error:
        why = f"cannot be written ({error.strerror or error}): choose another place"
        raise InputRefused(why).at(str(path)) from None
    return path


def _check_place(path: Path, force: bool) -> Path:
    """Refuse a path by what is there, without a try."""
    try:
        fault = _fault(path, path.parent, force)
    except OSError as error:  # a name too long, a ring of links
        fault = f"cannot be written ({error.strerror}): choose another place"
    if fault:
        raise InputRefused(fault).at(str(path))
    return path


def _fault(path: Path, folder: Path, force: bool) -> str:
    """What stands in the way, with its remedy; nothing if the path can be written."""
    if "\0" in str(path):
        return "cannot be written (a NUL in its name): choose another name"
    if path.is_dir():
        return "is a folder: name a file in it"
    if path.exists() and not path.is_file():
        return "is a device or a pipe and is not replaced by a file: choose another name"
    if path.exists() and not force:
        return "exists and is not overwritten: choose another name or add --force"
    if folder.exists() and not folder.is_dir():
        return f"{folder} is a file, no folder: choose another name"
    if not folder.is_dir():
        return f"its folder {folder} does not exist: create it first"
    if not os.access(folder, os.W_OK):
        return f"its folder {folder} is not writable: choose another"
    return ""


def check_folder_writable(folder: str | Path) -> Path:
    """Refuse a folder for results before the work starts; it may be missing, its own folder not."""
    folder = Path(folder)
    try:
        if folder.exists() and not folder.is_dir():
            raise InputRefused(f"{folder}: is a file, a folder is needed: choose another name")
        if not folder.exists() and not folder.parent.is_dir():
            raise InputRefused(f"{folder}: its folder {folder.parent} does not exist: create it first")
        _try_to_write(folder if folder.is_dir() else folder.parent)
    except OSError as error:
        why = f"cannot be written ({error.strerror or error}): choose another place"
        raise InputRefused(why).at(str(folder)) from None
    return folder


def _try_to_write(folder: Path) -> None:
    """Make a file that is gone at once: the only test that knows of every reason not to."""
    with tempfile.TemporaryFile(dir=folder, prefix=".cabledrive-") as file:
        file.write(b"0")


def write_whole(path: str | Path, content: str | bytes, *, force: bool = False) -> Path:
    """Write a file, text as UTF-8, so that it appears whole or not at all.

    Refused as by `check_writable`, or if it appeared while the work was done; `NotComputed` if the disk
    refuses: full, over a quota, failing.
    """
    path = _check_place(Path(path), force)
    data = content.encode() if isinstance(content, str) else content
    temporary = ""
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".cabledrive-", delete=False) as file:
            temporary = file.name
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~umask())
        put_in_place(Path(temporary), path, force=force)
    except OSError as error:
        raise not_written(path, error) from error
    finally:
        if temporary:
            with suppress(OSError):
                Path(temporary).unlink(missing_ok=True)
    return path


def not_written(path: Path, error: OSError) -> NotComputed:
    """The failure of a command whose disk refuses what it has computed."""
    why = error.strerror or error
    return NotComputed(
        f"{path}: cannot be written ({why}): free space or choose another place, and give the command again"
    )


def put_in_place(temporary: Path, path: Path, *, force: bool) -> None:
    """Give a file, whole on disk in that folder, its name, so that no loss of power takes it back.

    Refused if another process has written the file meanwhile (without `force`); `OSError` if the disk
    refuses.
    """
    if force or not hasattr(os, "link"):
        os.replace(temporary, path)
    else:
        _put_where_nothing_is(temporary, path)
    sync_folder(path.parent)


def _put_where_nothing_is(temporary: Path, path: Path) -> None:
    try:
        os.link(temporary, path)  # unlike a rename, it fails where there is a file by now
    except FileExistsError:
        raise InputRefused("was written meanwhile by another process: choose another name").at(
            str(path)
        ) from None
    except OSError as error:
        if error.errno not in (EPERM, ENOTSUP, EMLINK):
            raise
        os.replace(temporary, path)  # a file system without links
        return
    temporary.unlink()


def sync_folder(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the system has a call for it."""
    with suppress(OSError):  # some file systems have none
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def umask() -> int:
    """What the process takes away from the permissions of files it makes."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


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


OWN_HASH = "sha256"


def with_own_hash(data: dict[str, Any]) -> dict[str, Any]:
    """An object of JSON, numbers finite, with the hash of its content under `OWN_HASH` at the end."""
    content = {key: value for key, value in data.items() if key != OWN_HASH}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return content | {OWN_HASH: hashlib.sha256(canonical.encode()).hexdigest()}


def intact_object(path: Path) -> dict[str, Any] | None:
    """The object of a file from `with_own_hash`; None where it is absent or does not agree with its hash."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(data, dict) or OWN_HASH not in data:
        return None
    return data if with_own_hash(data)[OWN_HASH] == data[OWN_HASH] else None
