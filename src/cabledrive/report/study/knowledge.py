"""Chapter "What is known": every number with its interval, by the log or by the data sheet."""

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Note, Paragraph, RowGroup, Table
from cabledrive.report.figures.study_runs import intervals_picture
from cabledrive.report.numbers import number
from cabledrive.report.study.quantity_tables import named, unit_shown
from cabledrive.report.study.verdict import listed
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.carriage_machine import carriage_quantities
from cabledrive.studies.study.datasheet_bounds import by_datasheet
from cabledrive.studies.study.machine import DATASHEET, GOAL, GUESS, LOG, WORDS, Quantity

SOURCES = {LOG: "log", DATASHEET: "data sheet", GOAL: "goal", GUESS: "guess"}


def knowledge_chapter(result: StudyResult) -> Chapter:
    """What the logs told, and what stayed with the data sheet."""
    known = result.knowledge
    told = sum(q.source == LOG for q in known.quantities.values())
    blocks: list[Block] = [Paragraph(text=_words(result, told))]
    if known.undetermined:
        blocks.append(Note(text=listed("The logs cannot tell:", known.undetermined), tone="warning"))
    if known.findings:
        blocks.append(Note(text=listed("Against the data sheet:", known.findings)))
    blocks.append(_table(result))
    blocks.append(_picture(result))
    return Chapter(
        title="What is known",
        anchor="known",
        blocks=tuple(blocks),
        methods=(f"Identification: {known.method}.",),
    )


def _words(result: StudyResult, told: int) -> str:
    known = result.knowledge
    if known.residual is None and not told:
        return (
            "No log told anything, so every number is the data sheet's or the goals', with the relative "
            "uncertainty that the study was given. The controller has to live with all of it."
        )
    residual = (
        ""
        if known.residual is None
        else f" They leave {100 * known.residual:.2g} % of the torque unexplained."
    )
    return (
        f"The logs told {told} of {len(known.quantities)} numbers.{residual} An interval holds 95 % of what "
        "the noise allows, what the choice of the filter moves, and what the unexplained torque would do "
        "if all of it hid in that one number."
    )


def _sheet(result: StudyResult) -> dict[str, Quantity]:
    """What stood in file and goals before any log."""
    if result.carriage is not None:
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
    return Table(
        caption="The numbers that the controller rests on.",
        columns=(
            Column(title="Quantity"),
            Column(title="Data sheet", numeric=True),
            Column(title="Value", numeric=True),
            Column(title="Low", numeric=True),
            Column(title="High", numeric=True),
            Column(title="Unit"),
            Column(title="From"),
        ),
        groups=(RowGroup(rows=rows),),
        note="Friction and offset at the motor's shaft; stiffness and damping of one span.",
    )


def _picture(result: StudyResult) -> Figure:
    sheet = _sheet(result)
    picture = intervals_picture("intervals", result.knowledge.quantities, sheet)
    words = "; ".join(
        f"{WORDS[name]} {100 * q.half_width / abs(q.value):.2g} %"
        for name, q in result.knowledge.quantities.items()
        if q.value
    )
    return Figure(
        name="intervals",
        alt="Each number's interval over its data sheet value, beside the data sheet's own uncertainty. "
        f"Half widths: {words}.",
        caption="Every number over its data sheet value: a broad grey bar for what the data sheet leaves "
        "open, a dot with whiskers for what is known now.",
        wide=picture.wide,
        narrow=picture.narrow,
    )
