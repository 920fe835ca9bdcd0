"""Chapter "Drive and data": what the file and the logs hold, and what is odd about them."""

from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Note, Paragraph, RowGroup, Table
from cabledrive.report.datasheet_words import DATASHEET
from cabledrive.report.numbers import quantity
from cabledrive.report.study.verdict import listed, points
from cabledrive.report.wording import texts
from cabledrive.studies.study import StudyResult
from cabledrive.studies.study.check_stage import LogWords

say = texts("study_data")


def data_chapter(result: StudyResult) -> Chapter:
    """The drive file and the logs."""
    found = result.check
    blocks: list[Block] = [_datasheet(found.derived)]
    if isinstance(result.drive, AxisDrive):
        blocks.append(_chain(result.drive))
    if found.missing:
        blocks.insert(0, Note(text=listed(say("missing"), found.missing), tone="warning"))
    if found.warnings:
        blocks.append(Note(text=listed("Warnings:", found.warnings), tone="warning"))
    if found.logs:
        blocks.append(_logs(found.logs))
        said = tuple(f"{log.name}: {words}" for log in found.logs for words in (*log.repaired, *log.findings))
        blocks += [points("In the logs:", said)] if said else []
    else:
        blocks.append(Paragraph(text=say("no_log")))
    return Chapter(
        title="Drive and data",
        anchor="data",
        blocks=tuple(blocks),
        methods=(say("method"),),
    )


def _datasheet(derived: dict[str, float | None]) -> Table:
    groups = []
    for title, lines in DATASHEET.items():
        rows: list[tuple[Cell, ...]] = []
        for name, words, unit in lines:
            value = derived.get(name)
            if value is not None:
                rows.append((words, quantity(value, unit)))
        if rows:
            groups.append(RowGroup(title=title, rows=tuple(rows)))
    return Table(
        caption=say("datasheet"),
        columns=(Column(title="Quantity"), Column(title="Value", numeric=True)),
        groups=tuple(groups),
    )


def _chain(drive: AxisDrive) -> Paragraph:
    """What "load pulley" and its angle stand for on an axis of a machine with routes."""
    motors = " and ".join(f"{'-' if sign < 0 else ''}{name}" for name, sign in drive.words["motors"].items())
    gain = f"{1e3 * abs(drive.gain):.4g} mm/rad" if drive.slides else f"{abs(drive.gain):.4g} rad/rad"
    return Paragraph(text=say("axis", drive=drive, motors=motors, gain=gain))


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
    return Table(
        caption="The logs.",
        columns=(
            Column(title="File"),
            Column(title="Rows", numeric=True),
            Column(title="Length", unit="s", numeric=True),
            Column(title="Rate", unit="Hz", numeric=True),
            Column(title="Channels"),
        ),
        groups=(RowGroup(rows=rows),),
    )
