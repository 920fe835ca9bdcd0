"""Compiled kernels on disk: one file per kernel and signature, believed only if it is whole and one's own.

numba's own cache keeps an index beside numbered data files. Two processes that compile two signatures of a
function at once may give both the same number, after which one loads the machine code of the other; and an
index cut by a loss of power stops every later process. Here a file is named after a hash of its key, holds
the key and its own hash, and appears whole or not at all. What cannot be read is deleted and made again;
where nothing can be written, kernels are compiled in each process.
"""

import hashlib
import os
import pickle
import re
import stat
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba
from filelock import FileLock, Timeout
from numba.core.caching import FunctionCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from cabledrive.mechanics.compile_time import announce

UNFINISHED = ".kernel-"
STALE = 3600.0
"""Age of a half-written file that a killed process left behind [s]."""
LONGEST = 90.0
"""How long a process waits for another that compiles the same kernel, before it does so itself [s]."""
_DIGEST = hashlib.sha256().digest_size
_ADDRESS = re.compile(r"0x[0-9a-f]+")


class KernelCache(FunctionCache):
    """What numba asks for a compiled kernel, and keeps in a folder named after the version of all sources."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        code = function.__code__
        self._py_func, self._name, self._enabled = function, repr(function), True
        self._folder = folder
        self._locks: dict[Path, Any] = {}
        plain = re.sub(r"[^\w.]", "", function.__qualname__)
        self._stem = f"{Path(code.co_filename).stem}.{plain}-{code.co_firstlineno}"

    @property
    def cache_path(self) -> str:
        """Where the kernels lie."""
        return str(self._folder)

    def flush(self) -> None:
        """Delete what is kept of this kernel."""
        for path in self._folder.glob(f"{self._stem}.*"):
            with suppress(OSError):
                path.unlink()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel of numba's signature; None: it has to be compiled."""
        target_context.refresh()
        if not self._enabled:
            return None
        key = self._whole_key(sig, target_context.codegen())
        place = self._place(key)
        found = self._load(place, key, target_context)
        if found is None and self._compiled_elsewhere(place):
            found = self._load(place, key, target_context)
        if found is None:
            announce(self._stem, self.cache_path)
        return found

    def _load(self, place: Path, key: Any, target_context: Any) -> Any:
        """What a file holds of a kernel, or None; a file that is not to be believed is deleted."""
        try:
            payload = _own_content(place)
            kept, reduced = pickle.loads(payload) if payload else (None, ())
            if kept == key:
                return CompileResult._rebuild(target_context, *reduced)
        except FileNotFoundError:
            return None
        except Exception:  # whatever a file can be that another build of numba wrote
            pass
        with suppress(OSError):
            place.unlink()
        return None

    def _compiled_elsewhere(self, place: Path) -> bool:
        """Wait while another process compiles this kernel; otherwise claim it, so that others wait."""
        lock = FileLock(f"{place}.lock")
        try:
            lock.acquire(blocking=False)
        except Timeout:
            with suppress(Timeout, OSError):
                lock.acquire(timeout=LONGEST)
                _drop(lock)
            return True
        except OSError:  # nothing can be written here
            return False
        self._locks[place] = lock
        return False

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel, if it can be kept and the disk takes it. ``sig``: numba's."""
        key = self._whole_key(sig, data.codegen)
        try:
            if (
                self._enabled
                and not data.library.has_dynamic_globals
                and all(x.can_cache for x in data.lifted)
            ):
                payload = dumps((key, data._reduce()))
                with suppress(OSError):
                    _sweep(self._folder)
                    _write(self._place(key), hashlib.sha256(payload).digest() + payload)
        finally:
            if (lock := self._locks.pop(self._place(key), None)) is not None:
                _drop(lock)

    def _whole_key(self, sig: Any, codegen: Any) -> Any:
        # Kernels of a closure are other objects in each process, under the same names.
        cells = (cell.cell_contents for cell in self._py_func.__closure__ or ())
        code = self._py_func.__code__.co_code, *(f"{one.__module__}.{one.__qualname__}" for one in cells)
        return numba.__version__, self._folder.name, self._stem, sig, codegen.magic_tuple(), code

    def _place(self, key: Any) -> Path:
        """Named by the key's words; two keys that differ in an address alone take turns in one file."""
        words = _ADDRESS.sub("", repr(key))
        return self._folder / f"{self._stem}.{hashlib.sha256(words.encode()).hexdigest()[:24]}"


def _drop(lock: FileLock) -> None:
    with suppress(OSError):
        Path(lock.lock_file).unlink()
    lock.release()


def _own_content(path: Path) -> bytes | None:
    """What a file holds, if nobody else can have written it and it is whole."""
    with path.open("rb") as file:
        status = os.fstat(file.fileno())
        if hasattr(os, "getuid") and (
            status.st_uid != os.getuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        ):
            return None
        content = file.read()
    payload = content[_DIGEST:]
    return payload if hashlib.sha256(payload).digest() == content[:_DIGEST] else None


def _write(path: Path, content: bytes) -> None:
    temporary = ""
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=UNFINISHED, delete=False) as file:
            temporary = file.name
            file.write(content)
        os.replace(temporary, path)
    finally:
        with suppress(OSError):  # it is gone where all went well
            os.unlink(temporary)


def _sweep(folder: Path) -> None:
    for path in folder.glob(f"{UNFINISHED}*"):
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > STALE:
                path.unlink()
