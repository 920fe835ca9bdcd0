"""Chapter "Parameters": every number with its interval, by the log or by the data sheet."""

from cabledrive.report.blocks import Block, Cell, Chapter, Figure, Note, Paragraph, Table, table
from cabledrive.report.figures.study_runs import intervals_picture
from cabledrive.report.study.acceptance import named, unit_shown
from cabledrive.report.study.verdict import listed
from cabledrive.report.typesetting import number
from cabledrive.report.words import texts
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.carriage_machine import carriage_quantities
from cabledrive.studies.study.machine import DATASHEET, GOAL, GUESS, LOG, WORDS, Quantity, by_datasheet

say = texts("study_knowledge")
SOURCES = {LOG: "log", DATASHEET: "data sheet", GOAL: "goal", GUESS: "guess"}


def knowledge_chapter(result: StudyResult) -> Chapter:
    """Identified parameters, and parameters from the data sheet."""
    known = result.knowledge
    identified = sum(q.source == LOG for q in known.quantities.values())
    blocks: list[Block] = [
        Paragraph(text=say("identified", count=identified, of=len(known.quantities), residual=known.residual))
    ]
    if known.undetermined:
        blocks.append(Note(text=listed(say("undetermined"), known.undetermined), tone="warning"))
    if known.findings:
        blocks.append(Note(text=listed(say("findings"), tuple(str(one) for one in known.findings))))
    blocks.append(_table(result))
    blocks.append(_picture(result))
    return Chapter(
        title="Parameters",
        anchor="known",
        blocks=tuple(blocks),
        methods=(say("method", name=known.method),),
    )


def _sheet(result: StudyResult) -> dict[str, Quantity]:
    """What stood in file and goals before any log."""
    if result.carried:
        return carriage_quantities(result.drive, result.goals)
    return by_datasheet(result.drive, result.goals.spreads)


def _table(result: StudyResult) -> Table:
    sheet = _sheet(result)
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            named(name),
            number(sheet[name].value, 4),
            number(q.value, 5),
            number(q.low, 4),
            number(q.high, 4),
            unit_shown(q.unit),
            SOURCES[q.source],
        )
        for name, q in result.knowledge.quantities.items()
    )
    return table(
        say("table"),
        "Quantity | Data sheet [] | Value [] | Low [] | High [] | Unit | From",
        rows,
        note=say("table_note"),
    )


def _picture(result: StudyResult) -> Figure:
    sheet = _sheet(result)
    picture = intervals_picture("intervals", result.knowledge.quantities, sheet)
    known = result.knowledge.quantities
    widths = {WORDS[name]: q.half_width / abs(q.value) for name, q in known.items() if q.value}
    return Figure(
        name="intervals",
        alt=say("intervals_seen", widths=widths),
        caption=say("intervals"),
        drawing=picture,
    )
