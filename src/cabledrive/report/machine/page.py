"""The page of one machine, a loop or one with routes, and the card that leads to it."""

from dataclasses import dataclass
from typing import Any

from cabledrive.mechanics import drive_warnings
from cabledrive.mechanics.network.span_table import route_warnings
from cabledrive.modal import Modes
from cabledrive.modal.lowest import derived_with_lowest, how_held, lowest_frequencies
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.blocks import Block, Figure, Table, table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.moving_machine import moving_machine, sketch
from cabledrive.report.machine.card import (
    ResonanceVerdict,
    across_table,
    along_table,
    ladder,
    machine_card,
    pairs_of_route,
    resonance_verdict,
    shapes,
    simple_models_table,
    travel_figures,
)
from cabledrive.report.machine.data import (
    data_table,
    derived_table,
    drawing,
    pulleys_table,
    source_paragraphs,
    spans_table,
)
from cabledrive.report.machine.rest import rest_plot, rest_table
from cabledrive.report.page import MACHINES, View
from cabledrive.report.typesetting import number
from cabledrive.report.words import certificate_words

HANGING = (
    "Weights change the tension along the cable, and with it the transverse frequencies; each stretch "
    "vibrates under the tension it has here."
)
ROUTE_METHODS = (
    "Machines with routes: exact dynamic stiffness of every span, count of the network by the signs of that "
    "stiffness, roots enclosed between two counts; tensions by balance of bodies and lengths of ropes.",
)
METHODS = (
    "Natural modes: exact dynamic stiffness of every span; roots isolated by Wittrick-Williams "
    "counts and refined by inverse iteration, each enclosed between two counts. They are about the "
    "state of rest, along and across together where a span sags. Friction and damping do not enter.",
    "Tension at rest and sag: elastic catenary between pulleys and carriages. Other derived quantities and "
    "warnings: closed formulas.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A part of the page of a machine; ``folded``: opened by whoever wants it."""

    anchor: str
    title: str
    blocks: tuple[Block | None, ...]
    text: str = ""
    folded: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class MachinePage:
    """What the template of a machine is given."""

    name: str  # part of every anchor of the page
    drive: Drive | RoutedDrive
    digest: str  # content hash
    modes: Modes
    certificate: str  # what it says of the modes
    held: str  # how the motors were held
    resonance: ResonanceVerdict
    warnings: tuple[str, ...]
    sources: tuple[str, ...]
    drawing: Figure
    along: Table | None
    across: Table | None
    shapes: Figure
    ladder: Figure | None
    sections: tuple[Section, ...]  # those that stand open first

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Figures and tables in the order of the page."""
        open_, folded = (
            [block for one in self.sections if one.folded is side for block in one.blocks]
            for side in (False, True)
        )
        parts = (self.drawing, self.along, self.across, self.shapes, *open_, self.ladder, *folded)
        return tuple(part for part in parts if part is not None)


def machine_view(context: ReportContext, place: int) -> View:
    """Page and card of one machine of a report; ``place``: its number, loops and lines first."""
    drive, name, modes = context.machines[place], context.anchors[place], context.modes[place]
    context.progress(f"resonance and travel: {drive.name}")
    methods: tuple[str, ...] = METHODS
    if isinstance(drive, RoutedDrive):
        own, methods = _of_routes(drive, name, modes), ROUTE_METHODS
        warnings = route_warnings(drive)
    else:
        own, warnings = _of_a_loop(drive, name, modes), drive_warnings(drive)
    page = MachinePage(
        name=name,
        drive=drive,
        digest=content_hash(drive),
        modes=modes,
        certificate=certificate_words(modes),
        held=f"{lowest_frequencies(drive).line} {how_held(modes)}",
        warnings=tuple(dict.fromkeys(line.rstrip(".") for line in (*warnings, *modes.warnings))),
        sources=source_paragraphs(drive.source),
        across=across_table(modes) if modes.transverse else None,
        **own,
    )
    return View(
        anchor=f"machine-{name}",
        title=drive.name,
        group=MACHINES,
        card=machine_card(page, sketch(drive)),
        template="machine.html",
        content=page,
        blocks=page.blocks,
        methods=methods,
    )


def _of_a_loop(drive: Drive, name: str, modes: Modes) -> dict[str, Any]:
    """What the page of a loop or a line has of its own."""
    rest = rest_plot(drive, name)
    hanging = Section(
        anchor="rest", title="At rest, under gravity", text=HANGING, blocks=(rest, rest_table(drive))
    )
    return {
        "resonance": resonance_verdict(drive),
        "drawing": drawing(drive, name),
        "along": along_table(modes) if modes.longitudinal else None,
        "shapes": shapes(drive, name, modes),
        "ladder": ladder(drive, name, modes),
        "sections": (
            *(() if rest is None else (hanging,)),
            Section(
                anchor="simple",
                title="What simpler formulas give",
                blocks=(simple_models_table(drive),),
                folded=True,
            ),
            Section(
                anchor="data",
                title="Data and derived quantities",
                text="Lengths, densities and positions are of the unstretched cable unless stated otherwise.",
                blocks=(data_table(drive), derived_table(derived_with_lowest(drive))),
                folded=True,
            ),
        ),
    }


def _of_routes(drive: RoutedDrive, name: str, modes: Modes) -> dict[str, Any]:
    """What the page of a machine with routes has of its own."""
    verdict, pairs = pairs_of_route(drive)
    travels = tuple(travel_figures(drive, name))
    sections = (
        Section(anchor="travel", title="Over the travel", blocks=travels),
        Section(
            anchor="pairs", title="Pairs near internal resonance", blocks=() if pairs is None else (pairs,)
        ),
        Section(anchor="spans", title="Spans and pulleys", blocks=(spans_table(drive), pulleys_table(drive))),
    )
    return {
        "resonance": verdict,
        "drawing": _drawing(drive, name),
        "along": _along(modes) if modes.longitudinal else None,
        "shapes": shapes(drive, name, modes),
        "ladder": None,
        "sections": tuple(one for one in sections if one.blocks),
    }


def _drawing(drive: RoutedDrive, name: str) -> Figure:
    """The machine from its coordinates, spans coloured by tension."""
    parts = (
        f"{len(drive.route)} {'rope' if len(drive.route) == 1 else 'ropes'}, {len(drive.pulley)} pulleys, "
        f"{len(drive.body)} bodies, {len(drive.motor)} motors"
    )
    return Figure(
        name=f"drawing-{name}",
        alt=f"The machine from its coordinates: {parts}.",
        caption="The machine from the coordinates of its file; the colour of a span is its tension "
        "at rest. Bands are bodies with what they carry, dots anchors, boxes carriages.",
        drawing=moving_machine(drive, None),
    )


def _along(modes: Modes) -> Table:
    """Longitudinal modes and where their kinetic energy is."""
    rows = [
        (number(row.frequency, 6), str(row.count), row.family, row.where)
        for row in mode_rows(modes.longitudinal)
    ]
    return table(
        "Longitudinal modes and the parts that hold their kinetic energy.",
        "Frequency [Hz] | Modes [] | What moves | Kinetic energy",
        rows,
    )
