"""Knowing a finished study again, without the libraries that made it."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from cabledrive.parameters import Drive, InputRefused, Machine, content_hash
from cabledrive.parameters.files import check_folder_writable, intact_object, require_regular
from cabledrive.parameters.version import __version__

RESULTS, REPORT, STAGES = "results.json", "report.html", "stages"


def asked_hash(drive: Machine | Drive, files: Sequence[str | None], switches: tuple[bool, ...] = ()) -> str:
    """Hash of version, drive with its words, and bytes of goals and logs; refused if one cannot be read."""
    words = [__version__, content_hash(drive), drive.name, drive.title, str(switches)]
    words += ["" if file is None else _bytes_hash(file) for file in files]
    words += [Path(file).name for file in files[1:] if file is not None]
    return hashlib.sha256(json.dumps(words).encode()).hexdigest()


def _bytes_hash(file: str) -> str:
    try:
        if Path(file).exists() and not Path(file).is_dir():
            require_regular(file, "give the path of a file")
        with Path(file).open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except InputRefused:
        raise
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputRefused(f"{Path(file)}: cannot be read ({why}): check the path") from None


def code_hash() -> str:
    """Hash of all modules that make a study and its report."""
    from cabledrive.mechanics.sources import digest_with_imports  # `--help` does not wait for it

    return digest_with_imports(Path(__file__).parent / "commands" / "study.py")


def finished(folder: Path) -> dict[str, Any] | None:
    """The results of a study that finished, with all files as it wrote them; else None."""
    data = intact_object(folder / RESULTS)
    hashes = data.get("files") if data is not None else None
    if not isinstance(hashes, dict) or REPORT not in hashes:
        return None
    with suppress(InputRefused):
        if all(_bytes_hash(str(folder / name)) == sha for name, sha in hashes.items()):
            return data
    return None


def folder_of(output: str) -> Path:
    """The folder that ``--output`` names; refused if it names none."""
    if not output:
        raise InputRefused("--output names no folder: give one, or . for this one")
    return Path(output)


@contextmanager
def kept_if_interrupted(folder: Path) -> Iterator[None]:
    """Say after Ctrl-C that finished stages are kept."""
    try:
        yield
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"what is finished is kept in {folder / STAGES}; to go on, give the same command again"
        ) from None


def check_folder(folder: Path, *, force: bool = False) -> None:
    """Refuse a folder that cannot be written, or, without ``force``, holds what no finished study wrote."""
    check_folder_writable(folder)
    if not folder.is_dir() or finished(folder):
        return
    taken = [name for name in (RESULTS, REPORT) if (folder / name).exists()]
    if taken and not (folder / STAGES).is_dir():
        raise InputRefused(f"{folder}: holds a {taken[0]} that is no study's: choose another folder")
    if RESULTS in taken and not force:
        raise InputRefused(
            f"{folder}: {RESULTS} or a file beside it was changed since a study wrote it, or has no hash of "
            "its own: choose another folder, or add --force to write it anew"
        )
