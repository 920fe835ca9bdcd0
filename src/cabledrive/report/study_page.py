"""The report of a study on one page: the verdict first, then what it rests on."""

from datetime import datetime

from cabledrive.parameters import content_hash
from cabledrive.report.page import page_of
from cabledrive.report.study.controller import acceptance_chapter, controller_chapter
from cabledrive.report.study.mechanics import modes_chapter, resonance_chapter
from cabledrive.report.study.verdict import data_chapter, knowledge_chapter, verdict_chapter
from cabledrive.studies.study import StudyResult


def study_html(result: StudyResult, written_at: datetime | None = None) -> str:
    """The report of a study as HTML that needs no other file; the time it states is now unless given."""
    first = (verdict_chapter, data_chapter, knowledge_chapter, modes_chapter, resonance_chapter)
    made = (chapter(result) for chapter in (*first, controller_chapter, acceptance_chapter))
    chapters = [chapter for chapter in made if chapter is not None]
    hashes = (
        (result.drive.name, content_hash(result.drive)),
        ("the same, as identified", content_hash(result.known)),
        *((log.name, log.sha256) for log in result.check.logs),
        ("all inputs of the study", result.key),
    )
    title = f"{result.drive.name}: {result.verdict.answer}"
    subtitle = result.drive.title or "A study from data sheet and logs to a controller"
    return page_of(title, subtitle, chapters, hashes, written_at)
