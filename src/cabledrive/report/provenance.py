"""Where the numbers of a report come from: versions, hashes, methods, time."""

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version

from cabledrive.parameters import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.report.context import ReportContext

_PACKAGES = ("numpy", "scipy", "xarray", "matplotlib", "Jinja2")


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """What is needed to make a report again."""

    written_at: datetime  # time of the run, in UTC
    versions: tuple[tuple[str, str], ...]  # programs and their versions, `cabledrive` first
    hashes: tuple[tuple[str, str], ...]  # name and content hash of every drive
    methods: tuple[str, ...]  # how the numbers were computed


def provenance(context: ReportContext, methods: Sequence[str], written_at: datetime) -> Provenance:
    """Collect the provenance of a report; a time of the run without a time zone is taken as UTC."""
    zoned = written_at if written_at.tzinfo else written_at.replace(tzinfo=UTC)
    return Provenance(
        written_at=zoned.astimezone(UTC),
        versions=versions(),
        hashes=tuple((one.name, content_hash(one)) for one in context.machines),
        methods=tuple(methods),
    )


def versions() -> tuple[tuple[str, str], ...]:
    """Programs that a report is made with, and their versions. Returns `cabledrive` first."""
    packages = tuple((name, version(name)) for name in _PACKAGES)
    return (("cabledrive", __version__), ("Python", platform.python_version()), *packages)
