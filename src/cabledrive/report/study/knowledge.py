"""Chapter "Parameters": every number with its interval, by the log or by the data sheet."""

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
    """Identified parameters, and parameters from the data sheet."""
    known = result.knowledge
    identified = sum(q.source == LOG for q in known.quantities.values())
    blocks: list[Block] = [Paragraph(text=_words(result, identified))]
    if known.undetermined:
        blocks.append(
            Note(text=listed("Not identifiable from the logs:", known.undetermined), tone="warning")
        )
    if known.findings:
        blocks.append(Note(text=listed("Log and data sheet disagree:", known.findings)))
    blocks.append(_table(result))
    blocks.append(_picture(result))
    return Chapter(
        title="Parameters",
        anchor="known",
        blocks=tuple(blocks),
        methods=(f"Identification: {known.method}.",),
    )


def _words(result: StudyResult, identified: int) -> str:
    known = result.knowledge
    if known.residual is None and not identified:
        return (
            "No parameter was identified from a log: all values are from the data sheet or the goals, with "
            "the relative uncertainty stated in the goals. The controller must tolerate all of it."
        )
    count = len(known.quantities)
    head = f"All {count} parameters" if identified == count else f"{identified} of {count} parameters"
    residual = (
        "" if known.residual is None else f" {100 * known.residual:.2g} % of the torque remains unexplained."
    )
    return (
        f"{head} were identified.{residual} An interval covers 95 % of the noise, the effect of the choice "
        "of the filter, and the error if the whole unexplained torque acted on this one parameter."
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
    return Table(
        caption="Parameters that the controller is designed for.",
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
        alt="Interval of each parameter over its data-sheet value, beside the uncertainty of the data sheet. "
        f"Half widths: {words}.",
        caption="Parameters over their data-sheet values: grey bars show the uncertainty of the data "
        "sheet, dots with whiskers the values used.",
        wide=picture.wide,
        narrow=picture.narrow,
    )
