"""Chapter "Verdict": the answer, why, with which margins, and what would help."""

from markupsafe import Markup

from cabledrive.report.blocks import Block, Cell, Chapter, Column, Note, Paragraph, RowGroup, Table
from cabledrive.report.numbers import number, quantity
from cabledrive.report.study.carriage_goals import CARRIAGE_METHODS, asked_of_carriage
from cabledrive.studies.study import Goals, StudyResult
from cabledrive.studies.study.verdict_stage import Margin
from cabledrive.studies.study.verdict_words import move_words

VERDICT_METHODS = (
    "Verdict: yes if a law keeps within the error goal on at least 99 % of the lumped plants (or plants with "
    "a carriage) and 95 % of the plants on the distributed cable, each as the lower end of a one-sided 95 % "
    "Clopper-Pearson interval; of several such laws the simplest. No if torque, speed, a slack span or "
    "resonance exclude the motion. Unknown in all other cases: without an error goal, if none of the tried "
    "laws meets it, if the log contradicts the data sheet or the model, or if data are missing.",
)
TONES = {"yes": "good", "no": "warning", "unknown": "warning"}
HEADS = {"yes": "Yes.", "no": "No.", "unknown": "Unknown."}
MARGINS = {
    "torque": "Torque of the motion, without feedback",
    "speed": "Speed of the pulley",
    "lost tension": "Largest loss of tension of a strand along the motion, against the pretension",
    "error, carriage": "Error that 99 % of the plants keep below, 95 % confidence, against the goal",
    "slack_torque": "Torque transmitted by the cable, against the slack torque",
    "error, lumped": "Error that 99 % of the lumped plants keep below, 95 % confidence, against the goal",
    "error, cable": "Error that 95 % of the cable plants keep below, 95 % confidence, against the goal",
    "bound": "Stated bound of the chosen law, against the goal",
}


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
        methods=(*VERDICT_METHODS, *(CARRIAGE_METHODS if result.carried else ())),
    )


def sentences(lines: tuple[str, ...]) -> str:
    """Lines as sentences."""
    return " ".join(f"{line[:1].upper()}{line[1:].rstrip('.')}." for line in lines)


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
            MARGINS[m.name],
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
        ("Each move", f"{move_words(goals)}, {goals.dwell:g} s rest"),
        ("Pulses", f"{goals.pulses}, rises of order {goals.order}"),
        ("Largest torque", quantity(goals.torque, "N m", 3) if goals.torque else "the motor's limit"),
        ("Load", _load(goals)),
        ("Test", f"{goals.draws} lumped plants, {goals.cable_draws} on the cable, seed {goals.seed}"),
    ]
    return Table(
        caption="Goals.",
        columns=(Column(title="Goal"), Column(title="Value")),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _load(goals: Goals) -> str:
    if goals.load_inertia is None:
        return "as found"
    low, high = goals.load_inertia
    return f"{number(low, 4)} to {number(high, 4)} kg m²"
