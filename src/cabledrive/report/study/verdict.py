"""Chapter "Verdict": the answer, why, with which margins, and what would help."""

from markupsafe import Markup

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Note, Paragraph, RowGroup, Table
from cabledrive.report.numbers import quantity
from cabledrive.report.study.carriage_goals import asked_of_carriage, carriage_method
from cabledrive.report.study.goals_table import goals_table, load_range
from cabledrive.report.wording import sentences, texts
from cabledrive.studies.study import Goals, StudyResult
from cabledrive.studies.study.verdict_stage import Margin
from cabledrive.studies.study.verdict_words import move_words

say = texts("study_verdict")
TONES = {"yes": "good", "no": "warning", "unknown": "warning"}
HEADS = {"yes": "Yes.", "no": "No.", "unknown": "Unknown."}


def verdict_chapter(result: StudyResult) -> Chapter:
    """The answer before the reasons."""
    verdict = result.verdict
    answer = Markup("<strong>{}</strong> {}").format(HEADS[verdict.answer], sentences(verdict.reasons[:1]))
    blocks: list[Block] = [Note(text=answer, tone=TONES[verdict.answer])]
    if verdict.reasons[1:]:
        blocks.append(points("Further reasons:", verdict.reasons[1:]))
    if verdict.remedies:
        blocks.append(points("Recommended changes:", verdict.remedies))
    if verdict.margins:
        blocks.append(_margins(verdict.margins))
    if verdict.cautions:
        blocks.append(points("Notes:", verdict.cautions))
    travels = result.goals.travel is not None
    blocks.append(asked_of_carriage(result.goals) if travels else _asked(result.goals))
    return Chapter(
        title="Verdict",
        anchor="verdict",
        blocks=tuple(blocks),
        methods=(say("method"), *((carriage_method(),) if result.carried else ())),
    )


def points(head: str, lines: tuple[str, ...]) -> Paragraph:
    """A head and lines as a paragraph of the page, a list where they are several."""
    if len(lines) == 1:
        return Paragraph(text=f"{head} {sentences(lines)}")
    return Paragraph(text=head, items=lines)


def listed(head: str, lines: tuple[str, ...]) -> Markup:
    """A head and lines inside a remark, a list where they are several."""
    if len(lines) == 1:
        return Markup("{} {}").format(head, sentences(lines))
    items = Markup("").join(Markup("<li>{}</li>").format(line) for line in lines)
    return Markup("{}<ul>{}</ul>").format(head, items)


def _margins(margins: tuple[Margin, ...]) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            say("margin", name=m.name),
            quantity(m.value, m.unit, 3),
            quantity(m.allowed, m.unit, 3),
            min(m.value / m.allowed, 9.99),
        )
        for m in margins
    )
    return Table(
        caption="Margins.",
        columns=(
            Column(title="Figure"),
            Column(title="Value", numeric=True),
            Column(title="Allowed", numeric=True),
            Column(title="Used", unit="%", bar=True),
        ),
        groups=(RowGroup(rows=rows),),
    )


def _asked(goals: Goals) -> Table:
    rows: list[tuple[Cell, ...]] = [
        ("Error of the load", quantity(goals.error, "rad", 3) if goals.error else "no goal"),
        ("Each move", say("move", words=move_words(goals), dwell=goals.dwell)),
        ("Pulses", f"{goals.pulses}, rises of order {goals.order}"),
        ("Largest torque", quantity(goals.torque, "N m", 3) if goals.torque else "the motor's limit"),
        ("Load", load_range(goals, "as found")),
        ("Test", say("test", goals=goals)),
    ]
    return goals_table(rows)
