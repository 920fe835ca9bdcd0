"""The page of one machine, and the card that leads to it."""

from dataclasses import dataclass

from cabledrive.mechanics import drive_warnings
from cabledrive.modal import Mode, Modes
from cabledrive.modal.lowest import how_held, lowest_frequencies
from cabledrive.parameters import Drive
from cabledrive.report.blocks import Block, Figure, Table
from cabledrive.report.certificate_words import certificate_words
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.machine import machine_sketch
from cabledrive.report.machine.card import machine_card
from cabledrive.report.machine.data import data_table, derived_table, drawing, source_paragraphs
from cabledrive.report.machine.internal_resonance import ResonanceVerdict, resonance_verdict
from cabledrive.report.machine.modes import across_table, along_table, ladder, shapes
from cabledrive.report.machine.rest import rest_plot, rest_table
from cabledrive.report.numbers import number
from cabledrive.report.plot import Plot
from cabledrive.report.simple_models import simple_models_table
from cabledrive.report.style import short_family
from cabledrive.report.views import MACHINES, View

METHODS = (
    "Natural modes: exact dynamic stiffness of every span; roots isolated by Wittrick-Williams "
    "counts and refined by inverse iteration, each enclosed between two counts. Transverse modes "
    "about the rest: power series on strings of changing tension, shallow sag in the plane of "
    "gravity. Friction and damping do not enter; longitudinal modes are those of the taut cable.",
    "Tension at rest and sag: elastic catenary between pulleys and carriages. Derived quantities and "
    "warnings: closed formulas.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class MachinePage:
    """What the template of a machine is given."""

    name: str  # part of every anchor of the page
    drive: Drive
    digest: str  # content hash
    modes: Modes
    certificate: str  # what it says of the modes
    held: str  # how the motor was held
    resonance: ResonanceVerdict
    warnings: tuple[str, ...]
    sources: tuple[str, ...]
    drawing: Figure
    along: Table | None
    across: Table
    shapes: Figure
    ladder: Figure | None
    rest: Plot | None
    tensions: Table | None
    data: Table
    derived: Table
    simple: Table

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Figures and tables in the order of the page."""
        parts = (
            self.drawing, self.along, self.across, self.shapes, self.rest, self.tensions, self.ladder,
            self.simple, self.data, self.derived,
        )  # fmt: skip
        return tuple(part for part in parts if part is not None)


def machine_view(context: ReportContext, place: int) -> View:
    """Page and card of one machine of a report; ``place``: its number."""
    page = _page(context, place)
    return View(
        anchor=f"machine-{page.name}",
        title=page.drive.name,
        group=MACHINES,
        card=machine_card(page, machine_sketch(page.drive), _fact),
        template="machine.html",
        content=page,
        blocks=page.blocks,
        methods=METHODS if place == 0 else (),
    )


def _page(context: ReportContext, place: int) -> MachinePage:
    drive, name, modes = context.drives[place], context.anchors[place], context.modes[place]
    warnings = (*drive_warnings(drive), *(line for line in modes.warnings))
    return MachinePage(
        name=name,
        drive=drive,
        digest=context.hashes[place],
        modes=modes,
        certificate=certificate_words(modes),
        held=f"{lowest_frequencies(drive).line} {how_held(modes)}",
        resonance=resonance_verdict(drive),
        warnings=tuple(dict.fromkeys(line.rstrip(".") for line in warnings)),
        sources=source_paragraphs(drive.source),
        drawing=drawing(drive, name),
        along=along_table(modes) if modes.longitudinal else None,
        across=across_table(modes),
        shapes=shapes(drive, name, modes),
        ladder=ladder(drive, name, modes),
        rest=rest_plot(drive, name),
        tensions=rest_table(drive),
        data=data_table(drive),
        derived=derived_table(drive),
        simple=simple_models_table(drive),
    )


def _fact(what: str, modes: tuple[Mode, ...]) -> tuple[str, str]:
    if not modes:
        return what, "none found"
    first = modes[0]
    words = short_family(first.family) if first.span is None else f"{first.span} span"
    words = words.replace("both span", "both spans")
    return what, f"{number(first.frequency, 4)} Hz, {words}"
