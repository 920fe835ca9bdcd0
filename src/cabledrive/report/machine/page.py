"""The page of one machine, and the card that leads to it."""

from collections.abc import Iterator, Sequence

from cabledrive.answers.figures import number
from cabledrive.modal.lowest import how_held, lowest_frequencies
from cabledrive.parameters import Machine, content_hash
from cabledrive.report.blocks import Block, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.moving_machine import sketch
from cabledrive.report.machine.card import (
    facts_of,
    ladder,
    resonance_words,
    shapes,
    travel_figures,
)
from cabledrive.report.machine.data import (
    data_sheet,
    data_table,
    derived_table,
    drawing,
    machine_warnings,
    source_paragraphs,
)
from cabledrive.report.machine.rest import rest_blocks
from cabledrive.report.page import MACHINES, Badge, Card, View
from cabledrive.report.words import certificate_line, modes_table, rigid_words

HANGING = (
    "Weights change the tension along the cable, and with it the transverse frequencies; each stretch "
    "vibrates under the tension it has here."
)
UNSTRETCHED = "Lengths, densities and positions are of the unstretched rope unless stated otherwise."
FOLDED, SHOWN_ACROSS = ("simple", "data"), 6
METHODS = (
    "Natural modes: exact dynamic stiffness of every span; roots isolated by Wittrick-Williams "
    "counts and refined by inverse iteration, each enclosed between two counts. They are about the "
    "state of rest, along and across together where a span sags. Friction and damping do not enter.",
    "Tension at rest and sag: balance of bodies, lengths of ropes, elastic catenaries. Other derived "
    "quantities and warnings: closed formulas.",
)


def machine_view(context: ReportContext, place: int) -> View:
    """Page and card of one machine of a report; ``place``: its number."""
    drive, name, modes = context.machines[place], context.anchors[place], context.modes[place]
    context.progress(f"resonance and travel: {drive.name}")
    badge, reasons, pairs = resonance_words(drive)
    sections = tuple(_sections(drive, name, pairs))
    steps = ladder(drive, name, modes)
    warnings = tuple(dict.fromkeys(line.rstrip(".") for line in (*machine_warnings(drive), *modes.warnings)))
    shown: dict[str, Block] = {
        "drawing": drawing(drive, name),
        "table": modes_table(modes, SHOWN_ACROSS),
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
        methods=METHODS,
    )


def _sections(drive: Machine, name: str, pairs: Table | None) -> Iterator[Section]:
    """What applies to a machine."""
    sheet = data_sheet(drive)
    parts: tuple[tuple[str, str, Sequence[Block | None], str], ...] = (
        ("At rest, under gravity", "rest", rest_blocks(drive, name), HANGING),
        ("Over the travel", "travel", tuple(travel_figures(drive, name)), ""),
        ("Pairs near internal resonance", "pairs", (pairs,), ""),
        ("Spans and pulleys", "spans", sheet.tables, ""),
        (
            "Data and derived quantities",
            "data",
            (data_table(drive), derived_table(sheet.derived)),
            UNSTRETCHED,
        ),
    )
    for title, anchor, own, text in parts:
        if blocks := tuple(block for block in own if block is not None):
            yield Section(title, anchor, blocks, text=text, folded=anchor in FOLDED)
