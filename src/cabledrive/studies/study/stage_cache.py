"""Results of stages by the hash of all that they depend on: what is done once is not done again."""

import hashlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from cabledrive.mechanics.sources import PACKAGE, digest_with_imports
from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import write_whole
from cabledrive.parameters.own_hash import intact_object, with_own_hash
from cabledrive.parameters.version import __version__
from cabledrive.studies.study.plain_data import as_plain, revived

Result = TypeVar("Result")
STALE = 3600.0
"""Age of a half-written file that an ended run left behind [s]."""


def key_of(name: str, inputs: Mapping[str, Any]) -> str:
    """Hash of a stage's name, of this version, and of everything that the stage depends on.

    ``inputs``: what `as_plain` takes.
    Returns 64 hexadecimal digits.
    """
    content = {"stage": name, "cabledrive": __version__, "inputs": as_plain(inputs)}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


@cache
def sources_hash() -> str:
    """Hash of all modules that a stage imports, in whatever room, and of the packaged drives."""
    digest = hashlib.sha256(digest_with_imports(Path(__file__).with_name("pipeline.py")).encode())
    for path in sorted(PACKAGE.rglob("*.toml")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def file_hash(path: Path) -> str:
    """Hash of a file's bytes.

    Raises `InputRefused` if it cannot be read.
    """
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputRefused(f"{path}: cannot be read ({error.strerror}): check the path") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class StageCache:
    """A folder with one file per finished stage or part of a stage; a changed or cut file is not believed.

    Attributes
    ----------
    folder : Path or None
        None: nothing is kept.
    note : callable
        Called with what is computed and what was found.
    """

    folder: Path | None
    note: Callable[[str], None]

    def staged(
        self, name: str, kind: type[Result], inputs: Mapping[str, Any], compute: Callable[[], Result]
    ) -> Result:
        """A result from the folder, or computed and kept there.

        ``kind``: of the result, a frozen dataclass; ``inputs``: all that the result depends on; ``compute``:
        takes nothing.
        Returns the result; a fresh one too has gone through its plain data, so that it is the same either
        way.
        """
        key = key_of(name, {**inputs, "sources": sources_hash()})
        data = self._found(name, key)
        if data is None:
            data = self._kept(name, key, compute)
        result: Result = revived(kind, data)
        return result

    def _found(self, name: str, key: str) -> Any:
        if self.folder is None:
            return None
        content = intact_object(self._place(name, key))
        return content["result"] if content is not None and content.get("key") == key else None

    def _kept(self, name: str, key: str, compute: Callable[[], Any]) -> Any:
        begun = time.perf_counter()
        data = json.loads(json.dumps(as_plain(compute()), allow_nan=False))
        if self.folder is not None:
            content = {"key": key, "seconds": round(time.perf_counter() - begun, 3), "result": data}
            self.folder.mkdir(parents=True, exist_ok=True)
            write_whole(self._place(name, key), json.dumps(with_own_hash(content)), force=True)
        return data

    def _place(self, name: str, key: str) -> Path:
        assert self.folder is not None
        return self.folder / f"{name}-{key[:24]}.json"


def sweep(folder: Path) -> None:
    """Remove half-written files that runs killed long ago left behind."""
    for path in folder.glob(".cabledrive-*"):
        if path.is_file() and time.time() - path.stat().st_mtime > STALE:
            path.unlink(missing_ok=True)
