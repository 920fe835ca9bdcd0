"""Chapters "Verdict", "Drive and data" and "Parameters" of a study."""

from dataclasses import replace

from markupsafe import Markup

from cabledrive.answers.figures import number, quantity
from cabledrive.parameters.drive import Axis
from cabledrive.report.blocks import Block, Chapter, Note, Paragraph, Table, pictured, table
from cabledrive.report.figures.study_runs import intervals_picture
from cabledrive.report.machine.data import derived_table
from cabledrive.report.words import sentences, texts
from cabledrive.studies.study import Goals, StudyResult
from cabledrive.studies.study.carriage import know_carriage
from cabledrive.studies.study.check_stage import LogWords
from cabledrive.studies.study.findings import move_words
from cabledrive.studies.study.machine import DATASHEET, GOAL, GUESS, LOG, WORDS, Quantity, by_datasheet
from cabledrive.studies.study.verdict_stage import Margin

say = texts("study_verdict")
TONES = {"yes": "good", "no": "warning", "unknown": "warning"}


def verdict_chapter(result: StudyResult) -> Chapter:
    """The answer before the reasons."""
    verdict = result.verdict
    answer = Markup("<strong>{}:</strong> {}.").format(verdict.answer.capitalize(), verdict.reasons[0])
    blocks: list[Block] = [Note(text=answer, tone=TONES[verdict.answer])]
    if verdict.reasons[1:]:
        blocks.append(points("Further reasons:", verdict.reasons[1:]))
    if verdict.remedies:
        blocks.append(points("Recommended changes:", verdict.remedies))
    if verdict.margins:
        blocks.append(_margins(verdict.margins))
    if verdict.cautions:
        blocks.append(points("Notes:", verdict.cautions))
    blocks.append(_asked(result.goals))
    methods = (say("method"), *((say("carriage_method"),) if result.carried else ()))
    return Chapter("Verdict", "verdict", tuple(blocks), methods=methods)


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
    rows = []
    for own in margins:
        value, allowed = (quantity(one, own.unit, 3) for one in (own.value, own.allowed))
        rows.append((say("margin", name=own.name), value, allowed, min(own.value / own.allowed, 9.99)))
    return table("Margins.", "Figure | Value [] | Allowed []", rows, bars=("Used",))


def _asked(goals: Goals) -> Table:
    """Goals beside their values, of a carriage or a load."""
    travels, hung, inertia = goals.travel is not None, goals.hanging_mass, goals.load_inertia
    error, unit = (goals.carriage_error, "m") if travels else (goals.error, "rad")
    hanging = say("hung", goals=goals) if hung else "no hanging mass"
    load = "as in the file" if travels else "as found"
    if inertia is not None:
        load = f"{number(inertia[0], 4)} to {number(inertia[1], 4)} kg m²"
    kind = "carriage" if travels else "load"
    words = "" if travels else move_words(goals)
    rows = [
        (f"Error of the {kind}", quantity(error, unit, 3) if error else "no goal"),
        ("Each move", say(f"move_{kind}", goals=goals, words=words)),
        ("Pulses", f"{goals.pulses}, rises of order {goals.order}"),
        ("Largest torque", quantity(goals.torque, "N m", 3) if goals.torque else "the motor's limit"),
        *((("Below the carriage", hanging),) if travels else ()),
        ("Load pulley" if travels else "Load", load),
        ("Test", say(f"test_{kind}", goals=goals)),
    ]
    return table("Goals.", "Goal | Value", rows)


say_data = texts("study_data")


def data_chapter(result: StudyResult) -> Chapter:
    """The drive file and the logs."""
    found = result.check
    blocks: list[Block] = [derived_table(found.derived, say_data("datasheet"))]
    if result.drive.chain_of:
        blocks.append(_chain(result.drive.chain_of))
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
    return Chapter("Drive and data", "data", tuple(blocks), methods=(say_data("method"),))


def _chain(axis: Axis) -> Paragraph:
    """What "load pulley" and its angle stand for on an axis of a machine with routes."""
    motors = " and ".join(f"{'-' if sign < 0 else ''}{name}" for name, sign in axis.words["motors"].items())
    gain = f"{1e3 * abs(axis.gain):.4g} mm/rad" if axis.slides else f"{abs(axis.gain):.4g} rad/rad"
    return Paragraph(text=say_data("axis", axis=axis, motors=motors, gain=gain))


def _logs(logs: tuple[LogWords, ...]) -> Table:
    rows = []
    for log in logs:
        channels = ", ".join(name.replace("_", " ") for name in log.channels)
        rows.append((log.name, f"{log.rows}", f"{log.duration:.4g}", f"{log.sample_rate:.6g}", channels))
    return table("The logs.", "File | Rows [] | Length [s] | Rate [Hz] | Channels", rows)


say_known = texts("study_knowledge")
SOURCES = {LOG: "log", DATASHEET: "data sheet", GOAL: "goal", GUESS: "guess"}


def knowledge_chapter(result: StudyResult) -> Chapter:
    """Identified parameters, and parameters from the data sheet."""
    known = result.knowledge
    identified = sum(q.source == LOG for q in known.quantities.values())
    words = say_known("identified", count=identified, of=len(known.quantities), residual=known.residual)
    blocks: list[Block] = [Paragraph(text=words)]
    if known.undetermined:
        blocks.append(Note(text=listed(say_known("undetermined"), known.undetermined), tone="warning"))
    if known.findings:
        blocks.append(Note(text=listed(say_known("findings"), tuple(str(one) for one in known.findings))))
    blocks.append(_quantities(result))
    widths = {WORDS[name]: q.half_width / abs(q.value) for name, q in known.quantities.items() if q.value}
    picture = intervals_picture("intervals", known.quantities, _sheet(result))
    blocks.append(pictured(say_known, "intervals", picture, widths=widths))
    return Chapter("Parameters", "known", tuple(blocks), methods=(say_known("method", name=known.method),))


def _sheet(result: StudyResult) -> dict[str, Quantity]:
    """What stood in file and goals before any log."""
    if result.carried:
        plain = replace(result.goals, load_inertia=None)
        return know_carriage(result.drive, plain, plain.spreads, logged=False).quantities
    return by_datasheet(result.drive, result.goals.spreads)


def _quantities(result: StudyResult) -> Table:
    sheet = _sheet(result)
    rows = []
    for name, q in result.knowledge.quantities.items():
        stated = number(sheet[name].value, 4) if name in sheet else "none"
        found = (number(q.value, 5), number(q.low, 4), number(q.high, 4), unit_shown(q.unit))
        rows.append((named(name), stated, *found, SOURCES[q.source]))
    return table(
        say_known("table"),
        "Quantity | Data sheet [] | Value [] | Low [] | High [] | Unit | From",
        rows,
        note=say_known("table_note"),
    )


def named(name: str) -> str:
    """A quantity at the head of a row."""
    return WORDS[name][:1].upper() + WORDS[name][1:]


def unit_shown(unit: str) -> str:
    """A unit in its column; nothing for a plain number."""
    return "" if unit == "1" else unit.replace("^2", "²")
