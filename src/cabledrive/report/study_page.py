"""The report of a study on one page: the verdict first, then what it rests on."""

import platform
from datetime import UTC, datetime
from importlib.metadata import version

from cabledrive.parameters import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.report.context import Provenance
from cabledrive.report.page import Page, render
from cabledrive.report.study.acceptance import (
    acceptance_chapter,
    carriage_acceptance_chapter,
    carriage_controller_chapter,
)
from cabledrive.report.study.controller import controller_chapter, modes_chapter, resonance_chapter
from cabledrive.report.study.knowledge import knowledge_chapter
from cabledrive.report.study.verdict import data_chapter, verdict_chapter
from cabledrive.studies.study import StudyResult

PACKAGES = ("numpy", "scipy", "numba", "matplotlib", "Jinja2")
TITLES = {
    "yes": "yes",
    "no": "no",
    "unknown": "unknown",
}


def study_html(result: StudyResult, written_at: datetime | None = None) -> str:
    """The report of a study as HTML that needs no other file; the time it states is now unless given."""
    chapters = tuple(
        chapter
        for chapter in (
            verdict_chapter(result),
            data_chapter(result),
            knowledge_chapter(result),
            modes_chapter(result),
            resonance_chapter(result),
            controller_chapter(result),
            acceptance_chapter(result),
            carriage_controller_chapter(result),
            carriage_acceptance_chapter(result),
        )
        if chapter is not None
    )
    versions = tuple((name, version(name)) for name in PACKAGES)
    hashes = (
        (result.drive.name, content_hash(result.drive)),
        ("the same, as identified", content_hash(result.known)),
        *((log.name, log.sha256) for log in result.check.logs),
        ("all inputs of the study", result.key),
    )
    return render(
        Page(
            title=f"{result.drive.name}: {TITLES[result.verdict.answer]}",
            subtitle=result.drive.title or "A study from data sheet and logs to a controller",
            chapters=chapters,
            provenance=Provenance(
                written_at=(written_at or datetime.now(UTC)).astimezone(UTC),
                versions=(("cabledrive", __version__), ("Python", platform.python_version()), *versions),
                hashes=hashes,
                methods=tuple(method for chapter in chapters for method in chapter.methods),
            ),
        )
    )
