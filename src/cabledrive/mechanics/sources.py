"""What a module is made of: its own source and that of everything it imports from the package."""

import hashlib
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
IMPORTS = re.compile(
    rf"^[ \t]*(?:from[ \t]+({PACKAGE.name}[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)"
    rf"|import[ \t]+({PACKAGE.name}[\w.]*))",
    re.MULTILINE,
)


def digest_with_imports(module: Path, package: Path = PACKAGE) -> str:
    """Digest of a source file and of the files of the package that it imports, directly or through others.

    A package's ``__init__`` counts only for whom takes a name out of it, not for whom passes through it.

    ``module``: source file, of the package or not; ``package``: folder of the package.
    Returns SHA-256, hexadecimal; the same wherever the package lies.
    Raises `OSError` if a source cannot be read.
    """
    found, waiting = {module}, [module]
    while waiting:
        new = _source(waiting.pop(), package)[1] - found
        found |= new
        waiting.extend(new)
    digest = hashlib.sha256()
    for path in sorted(found, key=lambda path: (path.name, str(path))):
        digest.update(path.name.encode() + _source(path, package)[0])
    return digest.hexdigest()


def imported_names(text: str) -> Iterator[tuple[str, str]]:
    """Modules of the package that a source imports absolutely, and a name out of each, empty: the module."""
    for taken_from, names, whole in IMPORTS.findall(text):
        if whole:
            yield whole, ""
        for line in names.strip("()").splitlines():
            for name in line.split("#")[0].split(","):
                if name.strip():
                    yield taken_from, name.split()[0]


@cache
def _source(path: Path, package: Path) -> tuple[bytes, frozenset[Path]]:
    """Digest of a file, and the files of the package it imports."""
    content = path.read_bytes()
    places = (_file_of(package, *names) for names in imported_names(content.decode()))
    return hashlib.sha256(content).digest(), frozenset(place for place in places if place)


@cache
def _file_of(package: Path, module: str, name: str) -> Path | None:
    """File of a module's name, or of the module itself where the name is no module."""
    folder = package.joinpath(*module.split(".")[1:])
    for place in (folder / f"{name}.py", folder / name / "__init__.py") if name else ():
        if place.is_file():
            return place
    for place in (folder.with_suffix(".py"), folder / "__init__.py"):
        if place.is_file():
            return place
    return None
