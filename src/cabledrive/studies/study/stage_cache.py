"""Results of stages as plain data, kept by the hash of all that they depend on, logs by their bytes."""

import dataclasses
import hashlib
import inspect
import json
import sys
import time
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any, Generic, TypeVar

from cabledrive.identification.logs.log import ColumnMap, Log
from cabledrive.identification.logs.reading import read_log
from cabledrive.mechanics.sources import PACKAGE, digest_with_imports
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.files import intact_object, with_own_hash, write_whole
from cabledrive.parameters.tables import drive_from_tables, tables_from_drive
from cabledrive.parameters.version import __version__
from cabledrive.studies.study.knowledge_stage import usable_log


def as_plain(value: Any) -> Any:
    """What JSON can hold of a result, without loss; fields that no comparison sees are left out."""
    if isinstance(value, Machine | Drive):
        axis = getattr(value, "chain_of", None)
        return tables_from_drive(value) | ({"axis": as_plain(axis)} if axis else {})
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        seen = (field.name for field in dataclasses.fields(value) if field.compare)
        return {name: as_plain(getattr(value, name)) for name in seen}
    if isinstance(value, Mapping):
        return {str(key): as_plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_plain(item) for item in value]
    if isinstance(value, float) and not isfinite(value):
        raise ValueError(f"{value} cannot be kept: give None with a reason")
    return value


def revived(kind: Any, data: Any) -> Any:
    """The result that plain data stand for, of that kind."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin in (types.UnionType, typing.Union):
        if data is None:
            return None
        found = [kind for kind in arguments if kind is not type(None)]
        if len(found) > 1:  # of several dataclasses the one with these fields
            found = [one for one in found if {field.name for field in dataclasses.fields(one)} == set(data)]
        return revived(found[0], data)
    if kind is Drive:
        return drive_from_tables(data)
    if dataclasses.is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        given = {
            field.name: revived(hints[field.name], data[field.name]) for field in dataclasses.fields(kind)
        }
        return typing.cast(Any, kind)(**given)
    if origin is tuple:
        kinds = [arguments[0]] * len(data) if arguments[-1] is Ellipsis else list(arguments)
        return tuple(revived(k, item) for k, item in zip(kinds, data, strict=True))
    if origin is not None and issubclass(origin, Mapping):
        return {key: revived(arguments[1], item) for key, item in data.items()}
    if kind is float and isinstance(data, int):
        return float(data)
    return data


Result = TypeVar("Result")
STALE = 3600.0
"""Age of a half-written file that an ended run left behind [s]."""


def key_of(name: str, inputs: Mapping[str, Any]) -> str:
    """Hash of a stage's name, of this version, and of all that the stage depends on, 64 digits."""
    content = {"stage": name, "cabledrive": __version__, "inputs": as_plain(inputs)}
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


@dataclass(frozen=True, slots=True, eq=False)
class Made(Generic[Result]):
    """What a function makes of its arguments when needed, which are its key as an argument of a stage."""

    function: Callable[..., Result]
    arguments: tuple[Any, ...]
    kept: list[Result] = field(default_factory=list)

    @property
    def value(self) -> Result:
        """The thing itself."""
        if not self.kept:
            self.kept.append(self.function(*(value_of(one) for one in self.arguments)))
        return self.kept[0]


def value_of(argument: Any) -> Any:
    """An argument, or what is made of it."""
    return argument.value if isinstance(argument, Made) else argument


def call_of(function: Callable[..., Any], *arguments: Any, **named: Any) -> dict[str, Any]:
    """A call as plain data: the function, the sources that it stands on, and each argument by its name."""
    given = inspect.signature(function).bind(*arguments, **named)
    given.apply_defaults()
    return {
        "function": f"{function.__module__}.{function.__qualname__}",
        "sources": sources_hash(function.__module__),
        "arguments": {
            name: call_of(one.function, *one.arguments) if isinstance(one, Made) else as_plain(one)
            for name, one in given.arguments.items()
        },
    }


@cache
def sources_hash(module: str = "cabledrive.studies.study.pipeline") -> str:
    """Hash of a module with all that it imports, in whatever room, and of the packaged drives."""
    source = sys.modules[module].__file__
    assert source is not None
    digest = hashlib.sha256(digest_with_imports(Path(source)).encode())
    for path in sorted(PACKAGE.rglob("*.toml")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class StageCache:
    """A folder with one file per finished stage or part of a stage; a changed or cut file is not believed."""

    folder: Path | None  # None: nothing is kept
    note: Callable[[str], None]  # called with what is computed and what was found

    def staged(self, name: str, compute: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """A function's result via its plain data, from the folder or kept there; the call is the key."""
        key, begun, place, content = "", time.perf_counter(), None, None
        if self.folder is not None:
            key = key_of(name, call_of(compute, *arguments, **named))
            place = self.folder / f"{name}-{key[:24]}.json"
            content = intact_object(place)
        if content is None or content.get("key") != key:
            given = {word: value_of(one) for word, one in named.items()}
            plain = json.dumps(as_plain(compute(*map(value_of, arguments), **given)), allow_nan=False)
            seconds = round(time.perf_counter() - begun, 3)
            content = {"key": key, "seconds": seconds, "result": json.loads(plain)}
            if place is not None:
                place.parent.mkdir(parents=True, exist_ok=True)
                write_whole(place, json.dumps(with_own_hash(content)), force=True)
        result: Result = revived(typing.get_type_hints(compute)["return"], content["result"])
        return result


def sweep(folder: Path) -> None:
    """Remove half-written files that runs killed long ago left behind."""
    for path in folder.glob(".cabledrive-*"):
        if path.is_file() and time.time() - path.stat().st_mtime > STALE:
            path.unlink(missing_ok=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFile:
    """One log: its name and SHA-256 say what it is, its path only where it lies."""

    path: Path = field(compare=False)
    name: str
    sha256: str


Logs = Made[list[Log]]


def log_files(paths: Sequence[Path]) -> tuple[LogFile, ...]:
    """Logs by their bytes."""
    found = []
    for path in paths:
        try:
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise InputRefused(f"{path}: cannot be read ({error.strerror}): check the path") from None
        found.append(LogFile(path=path, name=path.name, sha256=digest))
    return tuple(found)


def read_all(files: Sequence[LogFile], columns: ColumnMap) -> list[Log]:
    """All logs, each with torque and angle."""
    return [usable_log(read_log(file.path, columns)) for file in files]
