"""Chapter "Summary": the answer before the reasons."""

from markupsafe import Markup

from cabledrive.mechanics import practitioner_warnings
from cabledrive.modal import Modes
from cabledrive.parameters import Drive
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Paragraph, RowGroup, Table
from cabledrive.report.certificate_words import count_words
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.overview import overview_picture
from cabledrive.report.numbers import number
from cabledrive.report.style import short_family

PLACE = 0


def chapter(context: ReportContext) -> Chapter:
    """The lowest frequencies of every machine, and whether its list of modes is complete."""
    blocks: list[Block] = [Paragraph(text=_verdict(context.modes))]
    if len(context.drives) > 1:
        blocks.append(_overview(context))
    return Chapter(title="Summary", anchor="in-short", blocks=(*blocks, _table(context)))


def _verdict(all_modes: tuple[Modes, ...]) -> Markup:
    listed = sum(modes.certificate.count for modes in all_modes)
    open_lists = sum(not modes.certified for modes in all_modes)
    machines = "this machine" if len(all_modes) == 1 else f"these {count_words(len(all_modes), 'machine')}"
    head = f"{listed} natural modes of {machines} were computed, longitudinal and transverse."
    if not open_lists:
        return Markup("{} <strong>All lists are certified complete.</strong>").format(head)
    return Markup("{} <strong>{} not certified; see below.</strong>").format(
        head, count_words(open_lists, "list") + (" is" if open_lists == 1 else " are")
    )


def _overview(context: ReportContext) -> Figure:
    names = [drive.name for drive in context.drives]
    picture = overview_picture("overview", names, context.modes)
    return Figure(
        name="overview",
        alt="Lowest longitudinal and transverse frequency of each machine on a logarithmic axis; the "
        "numbers are in the table below.",
        caption="The lowest longitudinal and the lowest transverse mode. Where the second is near half the "
        "first, longitudinal motion can excite transverse motion parametrically.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _table(context: ReportContext) -> Table:
    parts = zip(context.drives, context.anchors, context.modes, strict=True)
    return Table(
        caption="Lowest natural frequencies; each name links to the modes of the machine.",
        columns=(
            Column(title="Machine"),
            Column(title="Along", unit="Hz", numeric=True),
            Column(title="Mode"),
            Column(title="Across", unit="Hz", numeric=True),
            Column(title="Complete to", unit="Hz", numeric=True),
            Column(title="Modes", numeric=True),
            Column(title="Remarks", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(_row(drive, name, modes) for drive, name, modes in parts)),),
        note="Transverse: lowest mode of all spans. Modes: longitudinal and transverse, both planes. "
        "Warnings: listed with the data of each machine.",
    )


def _row(drive: Drive, name: str, modes: Modes) -> tuple[Cell, ...]:
    along = modes.longitudinal[0] if modes.longitudinal else None
    remarks = len(practitioner_warnings(drive))
    return (
        Markup('<a href="#modes-{}">{}</a>').format(name, drive.name),
        number(along.frequency) if along else None,
        short_family(along.family) if along else None,
        number(modes.transverse[0].frequency) if modes.transverse else None,
        number(modes.certificate.below, 6),
        f"{modes.certificate.count}",
        Markup('<a href="#drive-{}">{}</a>').format(name, remarks) if remarks else "none",
    )
