"""Chapters "Verdict" and "Drive and data" of a study."""

from markupsafe import Markup

from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.report.blocks import Block, Cell, Chapter, Note, Paragraph, Table, table
from cabledrive.report.machine.data import derived_table
from cabledrive.report.typesetting import number, quantity
from cabledrive.report.words import sentences, texts
from cabledrive.studies.study import Goals, StudyResult
from cabledrive.studies.study.check_stage import LogWords
from cabledrive.studies.study.findings import move_words
from cabledrive.studies.study.verdict_stage import Margin


def goals_table(rows: list[tuple[Cell, ...]]) -> Table:
    """Goals beside their values; each row two cells."""
    return table("Goals.", "Goal | Value", rows)


def load_range(goals: Goals, otherwise: str) -> str:
    """Range of the load's inertia in words; ``otherwise`` where none was asked for."""
    if goals.load_inertia is None:
        return otherwise
    low, high = goals.load_inertia
    return f"{number(low, 4)} to {number(high, 4)} kg m²"


say_goals = texts("study_carriage_goals")


def carriage_method() -> str:
    """How the verdict of a carriage is found, for the provenance."""
    return say_goals("method")


def asked_of_carriage(goals: Goals) -> Table:
    """The goals of a study with a carriage."""
    error, hung = goals.carriage_error, goals.hanging_mass
    assert goals.travel is not None
    rows: list[tuple[Cell, ...]] = [
        ("Error of the carriage", quantity(error, "m", 3) if error else "none given"),
        ("Each move", say_goals("move", goals=goals)),
        ("Pulses", f"{goals.pulses}, rises of order {goals.order}"),
        ("Largest torque", quantity(goals.torque, "N m", 3) if goals.torque else "the motor's limit"),
        ("Below the carriage", say_goals("hung", goals=goals) if hung else "no hanging mass"),
        ("Load pulley", load_range(goals, "as in the file")),
        ("Test", say_goals("test", goals=goals)),
    ]
    return goals_table(rows)


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
    return table("Margins.", "Figure | Value [] | Allowed []", rows, bars=("Used",))


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


say_data = texts("study_data")


def data_chapter(result: StudyResult) -> Chapter:
    """The drive file and the logs."""
    found = result.check
    blocks: list[Block] = [derived_table(found.derived, say_data("datasheet"))]
    if isinstance(result.drive, AxisDrive):
        blocks.append(_chain(result.drive))
    if found.missing:
        blocks.insert(0, Note(text=listed(say_data("missing"), found.missing), tone="warning"))
    if found.warnings:
        blocks.append(Note(text=listed("Warnings:", found.warnings), tone="warning"))
    if found.logs:
        blocks.append(_logs(found.logs))
        said = tuple(f"{log.name}: {words}" for log in found.logs for words in (*log.repaired, *log.findings))
        blocks += [points("In the logs:", said)] if said else []
    else:
        blocks.append(Paragraph(text=say_data("no_log")))
    return Chapter(
        title="Drive and data",
        anchor="data",
        blocks=tuple(blocks),
        methods=(say_data("method"),),
    )


def _chain(drive: AxisDrive) -> Paragraph:
    """What "load pulley" and its angle stand for on an axis of a machine with routes."""
    motors = " and ".join(f"{'-' if sign < 0 else ''}{name}" for name, sign in drive.words["motors"].items())
    gain = f"{1e3 * abs(drive.gain):.4g} mm/rad" if drive.slides else f"{abs(drive.gain):.4g} rad/rad"
    return Paragraph(text=say_data("axis", drive=drive, motors=motors, gain=gain))


def _logs(logs: tuple[LogWords, ...]) -> Table:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            log.name,
            f"{log.rows}",
            f"{log.duration:.4g}",
            f"{log.sample_rate:.6g}",
            ", ".join(name.replace("_", " ") for name in log.channels),
        )
        for log in logs
    )
    return table("The logs.", "File | Rows [] | Length [s] | Rate [Hz] | Channels", rows)
