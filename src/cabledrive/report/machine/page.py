"""The page of one machine, a loop or one with routes, and the card that leads to it."""

from cabledrive.answers.figures import number
from cabledrive.mechanics import drive_warnings
from cabledrive.modal.lowest import derived_with_lowest, how_held, lowest_frequencies
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.blocks import Block, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.moving_machine import sketch
from cabledrive.report.machine.card import (
    across_table,
    along_table,
    facts_of,
    ladder,
    resonance_words,
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
from cabledrive.report.machine.rest import rest_blocks
from cabledrive.report.page import MACHINES, Badge, Card, View
from cabledrive.report.words import certificate_line, rigid_words

HANGING = (
    "Weights change the tension along the cable, and with it the transverse frequencies; each stretch "
    "vibrates under the tension it has here."
)
ROUTE_METHODS: tuple[str, ...] = (
    "Machines with routes: exact dynamic stiffness of every span, count of the network by the signs of that "
    "stiffness, roots enclosed between two counts; tensions by balance of bodies and lengths of ropes.",
)
METHODS: tuple[str, ...] = (
    "Natural modes: exact dynamic stiffness of every span; roots isolated by Wittrick-Williams "
    "counts and refined by inverse iteration, each enclosed between two counts. They are about the "
    "state of rest, along and across together where a span sags. Friction and damping do not enter.",
    "Tension at rest and sag: elastic catenary between pulleys and carriages. Other derived quantities and "
    "warnings: closed formulas.",
)


def machine_view(context: ReportContext, place: int) -> View:
    """Page and card of one machine of a report; ``place``: its number."""
    drive, name, modes = context.machines[place], context.anchors[place], context.modes[place]
    context.progress(f"resonance and travel: {drive.name}")
    badge, reasons, pairs = resonance_words(drive)
    if isinstance(drive, RoutedDrive):
        sections, methods = _of_routes(drive, name, pairs), ROUTE_METHODS
        steps = None
    else:
        sections, methods = _of_a_loop(drive, name), METHODS
        steps = ladder(drive, name, modes)
    warnings = tuple(dict.fromkeys(line.rstrip(".") for line in (*drive_warnings(drive), *modes.warnings)))
    shown = {
        "drawing": drawing(drive, name),
        "along": along_table(modes),
        "across": across_table(modes),
        "shapes": shapes(drive, name, modes),
    }
    first, last = (
        [block for one in sections if one.folded is side for block in one.blocks] for side in (False, True)
    )
    blocks = (*shown.values(), *first, steps, *last)  # in the order of the page
    content = shown | {
        "name": name,  # part of every anchor of the page
        "drive": drive,
        "digest": content_hash(drive),
        "modes": modes,
        "certificate": " ".join([certificate_line(modes), *rigid_words(modes)]),
        "held": f"{lowest_frequencies(drive).line} {how_held(modes)}",
        "badge": badge,  # verdict on the internal resonance, and its reasons
        "reasons": reasons,
        "warnings": warnings,
        "sources": source_paragraphs(drive.source),
        "ladder": steps,
        "sections": sections,
    }
    certificate = modes.certificate
    sound, below = modes.certified and certificate.count, f"{number(certificate.below, 4)} Hz"
    complete = Badge(f"Modes complete up to {below}", "good")
    doubtful = Badge(f"Modes up to {below} not certified", "warning")
    card = Card(
        text=drive.title,
        picture=sketch(drive),
        badges=(complete if sound else doubtful, badge),
        facts=(*facts_of(modes), *([("Warnings", f"{len(warnings)}")] if warnings else [])),
    )
    return View(
        anchor=f"machine-{name}",
        title=drive.name,
        group=MACHINES,
        card=card,
        template="machine.html",
        content=content,
        blocks=tuple(block for block in blocks if block is not None),
        methods=methods,
    )


def _of_a_loop(drive: Drive, name: str) -> tuple[Section, ...]:
    """Sections of the page of a loop or a line."""
    hanging = rest_blocks(drive, name)
    return (
        *([Section("At rest, under gravity", "rest", hanging, text=HANGING)] if hanging else []),
        Section("What simpler formulas give", "simple", (simple_models_table(drive),), folded=True),
        Section(
            "Data and derived quantities",
            "data",
            (data_table(drive), derived_table(derived_with_lowest(drive))),
            text="Lengths, densities and positions are of the unstretched cable unless stated otherwise.",
            folded=True,
        ),
    )


def _of_routes(drive: RoutedDrive, name: str, pairs: Table | None) -> tuple[Section, ...]:
    """Sections of the page of a machine with routes."""
    parts: tuple[tuple[str, str, tuple[Block | None, ...]], ...] = (
        ("Over the travel", "travel", tuple(travel_figures(drive, name))),
        ("Pairs near internal resonance", "pairs", (pairs,)),
        ("Spans and pulleys", "spans", (spans_table(drive), pulleys_table(drive))),
    )
    made = (Section(title, anchor, tuple(filter(None, own))) for title, anchor, own in parts)
    return tuple(section for section in made if section.blocks)
