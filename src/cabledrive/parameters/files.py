"""Files that appear whole or not at all, and never replace another unasked."""

import os
import stat
import tempfile
from pathlib import Path

from cabledrive.parameters.errors import InputRefused


def require_regular(path: str | Path, remedy: str) -> Path:
    """Refuse an input that is no regular file: a pipe would keep a command waiting, a device never ends.

    Parameters
    ----------
    path : path-like
    remedy : str
        What to give instead.

    Returns
    -------
    Path

    Raises
    ------
    InputRefused
        If it is missing, a folder, a pipe or a device, or its place cannot be looked at.
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
    """Refuse an output path before the work starts.

    Parameters
    ----------
    path : path-like
        File that is going to be written.
    force : bool, default False
        Whether an existing file may be replaced.

    Returns
    -------
    Path

    Raises
    ------
    InputRefused
        If it exists (without `force`), is no file, or its folder is missing or not writable.
    """
    path = Path(path)
    try:
        fault = _fault(path, path.parent, force)
    except OSError as error:  # a name too long, a ring of links
        fault = f"cannot be written ({error.strerror}): choose another place"
    if fault:
        raise InputRefused(fault).at(str(path))
    return path


def _fault(path: Path, folder: Path, force: bool) -> str:
    """What stands in the way, with its remedy; nothing if the path can be written."""
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


def write_whole(path: str | Path, content: str | bytes, *, force: bool = False) -> Path:
    """Write a file so that it appears whole or not at all.

    Parameters
    ----------
    path : path-like
        File to write.
    content : str or bytes
        What it holds; text is written as UTF-8.
    force : bool, default False
        Whether an existing file may be replaced.

    Returns
    -------
    Path
        Where it was written.

    Raises
    ------
    InputRefused
        If the path cannot be written, see `check_writable`, or the disk refuses.
    """
    path = check_writable(path, force=force)
    data = content.encode() if isinstance(content, str) else content
    temporary = ""
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".cabledrive-", delete=False) as file:
            temporary = file.name
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except (OSError, ValueError) as error:  # ValueError: a path with a NUL in it
        reason = getattr(error, "strerror", None) or error
        raise InputRefused(f"cannot be written ({reason}): choose another place").at(str(path)) from error
    finally:
        Path(temporary).unlink(missing_ok=True) if temporary else None
    return path


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
