"""The logs of a study: known by their bytes, read when first needed."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cabledrive.identification.logs.column_map import ColumnMap
from cabledrive.identification.logs.log import Log
from cabledrive.identification.logs.reading import read_log
from cabledrive.studies.study.knowledge_stage import usable_log
from cabledrive.studies.study.stage_cache import Made, file_hash


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFile:
    """One log: its name and SHA-256 say what it is, its path only where it lies."""

    path: Path = field(compare=False)
    name: str
    sha256: str


Logs = Made[list[Log]]


def log_files(paths: Sequence[Path]) -> tuple[LogFile, ...]:
    """Logs by their bytes.

    Raises `InputRefused` if a file cannot be read.
    """
    return tuple(LogFile(path=path, name=path.name, sha256=file_hash(path)) for path in paths)


def logs_of(files: Sequence[LogFile], columns: ColumnMap) -> Logs:
    """Logs that are read when a stage needs them."""
    return Made(read_all, (tuple(files), columns))


def read_all(files: Sequence[LogFile], columns: ColumnMap) -> list[Log]:
    """All logs, each with torque and angle."""
    return [usable_log(read_log(file.path, columns)) for file in files]
