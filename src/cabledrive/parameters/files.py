"""Files that appear whole or not at all, and never replace another unasked."""

import os
import tempfile
from pathlib import Path

from cabledrive.parameters.errors import InputRefused


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
        If it exists (without `force`), is a folder, or its folder is missing or not writable.
    """
    path = Path(path)
    folder = path.parent
    if path.is_dir():
        raise InputRefused(f"{path}: is a folder: name a file in it")
    if path.exists() and not force:
        raise InputRefused(f"{path}: exists and is not overwritten: choose another name or add --force")
    if not folder.is_dir():
        raise InputRefused(f"{path}: its folder {folder} does not exist: create it first")
    if not os.access(folder, os.W_OK):
        raise InputRefused(f"{path}: its folder {folder} is not writable: choose another")
    return path


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
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
            temporary = file.name
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        raise InputRefused(
            f"{path}: cannot be written ({error.strerror}): free space or choose another place"
        ) from error
    finally:
        Path(temporary).unlink(missing_ok=True) if temporary else None
    return path


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
