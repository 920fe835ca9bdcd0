"""Compiled kernels: numba where it is to be had, with a cache that outlives the process.

The cache lies in the user's own folder, not beside the sources: an installation may be read-only and serve
many. numba looks for changes only in the file of a function, not in those of the functions it calls and of
the numbers it knows by name. The cache of a module is therefore named after the package's version and a
digest of that module and of all that it imports from the package, directly or not
(`cabledrive.mechanics.sources`).
"""

import os
import stat
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.parameters.version import __version__

F = TypeVar("F", bound=Callable[..., Any])

# Not among them: nnan and ninf, so that a NaN stays one and is found.
FAST_MATH = {"reassoc", "contract", "nsz", "arcp", "afn"}


def njit(function: F) -> F:
    """Compile a kernel when first called, with fast arithmetic that keeps NaN; without numba leave it."""
    return _compile(function, FAST_MATH)


def njit_in_place(function: F) -> F:
    """Compile a kernel that makes no arrays, only views of those it is given.

    References to arrays are then not counted, which takes more time than the arithmetic of a short kernel.
    """
    return _compile(function, FAST_MATH, _nrt=False)


def njit_part(function: F) -> F:
    """As `njit_in_place`, compiled into each of its callers: for parts of a loop that take large tuples.

    A call passes every array of a tuple by its seven numbers, which takes longer than a short part. Python
    may call it as well.
    """
    return _compile(function, FAST_MATH, forceinline=True, _nrt=False)


def njit_strict(function: F) -> F:
    """Compile a kernel whose rounding matters: no arithmetic is reordered."""
    return _compile(function, False)


def for_kernels(function: F) -> F:
    """Mark a function, before it is compiled, as one that only kernels call.

    It then gets no entry from Python, which takes longer to compile than many a kernel, and is compiled into
    each of its callers. A call that were left would go to one version of it in the process that compiled and
    to another in those that load from the cache, and the two may round differently. Functions whose name
    begins with an underscore need no mark.
    """
    function.__dict__["for_kernels"] = True
    return function


def njit_inner(function: F) -> F:
    """As `njit_in_place`, called by kernels alone, see `for_kernels`."""
    return njit_in_place(for_kernels(function))


@cache
def numba_at_hand() -> bool:
    """Whether kernels can be compiled here: not without numba, nor where NUMBA_DISABLE_JIT is set."""
    try:
        import numba
    except ImportError:
        return False
    config: Any = numba.config
    return not config.DISABLE_JIT


def why_plain() -> str | None:
    """Why kernels run as plain Python here, in one line; None if they are compiled."""
    return None if numba_at_hand() else "numba is not installed or is switched off"


def _compile(function: F, fast_math: Any, **options: Any) -> F:
    if not numba_at_hand():
        return function
    import numba

    config: Any = numba.config
    options |= {"error_model": "numpy", "fastmath": fast_math, "nogil": True}
    inside = function.__name__.startswith("_") or "for_kernels" in function.__dict__
    options |= {"no_cpython_wrapper": inside, "no_cfunc_wrapper": True}
    options["forceinline"] = inside or options.get("forceinline", False)
    compiled: Any = numba.njit(**options)(function)
    module = getattr(function, "sources", function.__code__.co_filename)
    folder = _cache_folder(Path(module), config.CACHE_DIR)
    if folder:
        from cabledrive.mechanics.kernel_cache import KernelCache

        compiled._cache = KernelCache(function, Path(folder))
    from cabledrive.mechanics.kernel_parts import as_part_of_callers

    as_part_of_callers(compiled)
    return cast(F, compiled)


@cache
def _cache_folder(module: Path, chosen: str = "") -> str:
    """A folder for kernels, ``chosen`` by NUMBA_CACHE_DIR, writable and nobody else's; empty: none."""
    try:
        digest = digest_with_imports(module)
    except OSError:  # no sources: a stale cache looks like a fresh one
        return ""
    name = f"kernels-{__version__}-py{sys.version_info[0]}{sys.version_info[1]}-{digest[:12]}"
    if chosen:
        return str(Path(chosen) / name) if _is_own(Path(chosen) / name) else ""
    if sys.platform == "win32":
        users = Path(os.environ.get("LOCALAPPDATA", "")) / "cabledrive"
    else:
        users = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")) / "cabledrive"
    if users.is_absolute() and _is_own(users) and _is_own(users / name):
        return str(users / name)
    try:
        user = os.getuid() if hasattr(os, "getuid") else "user"
        temporary = Path(tempfile.gettempdir()) / f"cabledrive-{user}"
    except OSError:  # nothing can be written anywhere
        return ""
    return str(temporary / name) if _is_own(temporary) and _is_own(temporary / name) else ""


def _is_own(folder: Path) -> bool:
    """Whether the folder is there or could be made, can be written, and nobody else can write into it."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = folder.stat()
    except OSError:
        return False
    if not os.access(folder, os.W_OK):
        return False
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
