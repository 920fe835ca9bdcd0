"""What every page is given: the machines, what was computed of them once, where the numbers come from."""

import platform
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from importlib.metadata import version
from math import pi

from cabledrive.modal import Modes, modes, natural_frequencies
from cabledrive.modal.natural import spectrum_of
from cabledrive.parameters import Drive, InputRefused, Machine
from cabledrive.parameters.version import __version__
from cabledrive.report.words import anchors

SHOWN_MODES = 5
MOST_LISTED = 10_000
_ROOM = 1.1  # more than two digits round off


@dataclass(frozen=True, kw_only=True, eq=False)
class ReportContext:
    """The machines of a report."""

    machines: tuple[Machine, ...]  # those like what people bring first, the dissertation's last
    progress: Callable[[str], None]  # called with a line of text when a longer part of the work begins

    @cached_property
    def anchors(self) -> tuple[str, ...]:
        """A name for each machine that is unique on the page and fit for a link."""
        return anchors([machine.name for machine in self.machines])

    @cached_property
    def modes(self) -> tuple[Modes, ...]:
        """Certified modes of each machine.

        Both kinds, a little beyond the fifth longitudinal one; where that would list more than ten thousand
        transverse modes, the first five of each kind instead.
        """
        return tuple(self._modes(machine) for machine in self.machines)

    def _modes(self, drive: Machine) -> Modes:
        self.progress(f"natural modes: {drive.name}")
        below = float(f"{_ROOM * natural_frequencies(drive, count=SHOWN_MODES)[-1]:.2g}")
        if spectrum_of(drive)[0].count(2 * pi * below) > MOST_LISTED:
            return modes(drive, count=SHOWN_MODES)
        return modes(drive, below=below)


def make_context(
    drives: Sequence[Machine | Drive], progress: Callable[[str], None] | None = None
) -> ReportContext:
    """Take up the machines of a report, refused without any; progress gets a line for each longer part."""
    if not drives:
        raise InputRefused("0 drives given, but a report is about at least 1: name a drive")
    return ReportContext(
        machines=tuple(sorted((own.machine for own in drives), key=_place)),
        progress=progress or (lambda line: None),
    )


BROUGHT = ("printer", "corexy", "lift", "elevator", "arm", "axis", "ropeway")
"""Words in the names of machines like those of most readers, first things first."""


def _place(drive: Machine) -> tuple[bool, int]:
    """Where a machine stands in a report; others keep their order."""
    name = drive.name.lower()
    found = (number for number, word in enumerate(BROUGHT) if word in name)
    return name.startswith("dissertation"), next(found, len(BROUGHT))


_PACKAGES = ("numpy", "scipy", "numba", "xarray", "matplotlib", "Jinja2")


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """What is needed to make a report again."""

    written_at: datetime  # time of the run, in UTC
    versions: tuple[tuple[str, str], ...]  # programs and their versions, `cabledrive` first
    hashes: tuple[tuple[str, str], ...]  # name and content hash of every drive
    methods: tuple[str, ...]  # how the numbers were computed


def provenance(
    hashes: Iterable[tuple[str, str]], methods: Iterable[str], written_at: datetime | None = None
) -> Provenance:
    """What a page is made again with; its time is now unless given, in UTC where it names no time zone."""
    at = written_at or datetime.now(UTC)
    packages = tuple((name, version(name)) for name in _PACKAGES)
    versions = (("cabledrive", __version__), ("Python", platform.python_version()), *packages)
    return Provenance(
        written_at=(at if at.tzinfo else at.replace(tzinfo=UTC)).astimezone(UTC),
        versions=versions,
        hashes=tuple(hashes),
        methods=tuple(dict.fromkeys(methods)),
    )
