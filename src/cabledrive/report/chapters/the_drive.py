"""Chapter "The drive": what each machine is, a drawing of it, its data, what follows from them."""

import re
from dataclasses import fields
from typing import Any

from markupsafe import Markup

from cabledrive.mechanics import practitioner_warnings
from cabledrive.modal.lowest import derived_with_lowest
from cabledrive.parameters import Drive
from cabledrive.report.blocks import (
    Beside,
    Block,
    Chapter,
    Column,
    Details,
    Figure,
    Note,
    Paragraph,
    RowGroup,
    Section,
    Table,
)
from cabledrive.report.context import ReportContext
from cabledrive.report.datasheet_words import DATASHEET
from cabledrive.report.figures.machine import machine_picture
from cabledrive.report.numbers import quantity

PLACE = 100
MOST_CARRIAGES = 4
NOTHING = 1e-12  # in SI; what round-off leaves of a weight across a vertical cable
_QUANTITY = (Column(title="Quantity"), Column(title="Value", numeric=True))


def chapter(context: ReportContext) -> Chapter:
    """What the machines of the report are made of."""
    parts = zip(context.drives, context.anchors, context.hashes, strict=True)
    return Chapter(
        title="The drive" if len(context.drives) == 1 else "The drives",
        anchor="the-drive",
        blocks=(
            Paragraph(
                text="The quantities of each drive file as used in the computation. Lengths, densities and "
                "positions refer to the unstretched cable unless stated otherwise. The second table of "
                "each machine lists quantities derived by closed formulas."
            ),
            Paragraph(
                text="In the drawings, spans and positions of carriages are to scale; motor, rails and "
                "boxes are symbols. Arrows on the spans show the positive direction of positions and "
                "displacements."
            ),
        ),
        sections=tuple(
            Section(title=drive.name, anchor=f"drive-{name}", blocks=_about(drive, name, digest))
            for drive, name, digest in parts
        ),
        methods=("Derived quantities and warnings: closed formulas, no computation of modes.",),
    )


def _about(drive: Drive, name: str, digest: str) -> tuple[Block, ...]:
    blocks: list[Block] = []
    if drive.title:
        blocks.append(Paragraph(text=f"{drive.title.rstrip('.')}."))
    blocks += [_drawing(drive, name), *_warnings(drive), Beside(blocks=(_data(drive), _derived(drive)))]
    if drive.source:
        blocks.append(Details(summary="Sources of these figures", paragraphs=_paragraphs(drive.source)))
    hashed = Markup('Content hash <code title="{}">{}…</code>').format(digest, digest[:16])
    return (*blocks, Paragraph(text=hashed))


def _paragraphs(source: str) -> tuple[str, ...]:
    """A text of many lines, cut where a line begins with a heading in capitals."""
    parts = re.split(r"\n(?=[A-Z]{3,}[A-Z ]*[:\s(])", source.strip())
    return tuple(" ".join(part.split()) for part in parts)


def _drawing(drive: Drive, name: str) -> Figure:
    picture = machine_picture(drive)
    return Figure(
        name=f"machine-{name}",
        alt=_seen(drive),
        caption=f"{drive.name}, spans and positions of carriages to scale.",
        wide=picture.wide,
        narrow=picture.narrow,
    )


def _seen(drive: Drive) -> str:
    """The drawing in words."""
    what = "A cable loop round two pulleys" if drive.kind == "loop" else "A cable between two drums"
    parts = [f"{what}, {quantity(drive.span_length, 'm')} apart"]
    parts += [
        f"the {side} one fixed" for side, p in zip(("drive", "load"), drive.pulley, strict=True) if p.fixed
    ]
    if drive.motor is not None:
        joint = "a flexible joint" if drive.motor.joint_stiffness is not None else "a rigid joint"
        parts.append(f"a motor on the drive pulley behind {joint}")
    for span in drive.spans:
        count = len(drive.carriages_on(span))
        if count:
            parts.append(f"{count} {'carriage' if count == 1 else 'carriages'} on the {span} span")
    if drive.layout.inclination:
        parts.append(f"inclined by {quantity(drive.layout.inclination, 'rad')}")
    return "; ".join(parts) + "."


def _warnings(drive: Drive) -> list[Note]:
    lines = practitioner_warnings(drive)
    if not lines:
        return []
    items = Markup("").join(Markup("<li>{}.</li>").format(_capital(line.rstrip("."))) for line in lines)
    return [Note(text=Markup("<strong>Warnings</strong><ul>{}</ul>").format(items), tone="warning")]


def _data(drive: Drive) -> Table:
    parts: list[tuple[str, Any]] = [
        ("Cable", drive.cable),
        ("Layout", drive.layout),
        ("Drive pulley, without the motor" if drive.motor else "Drive pulley", drive.drive_pulley),
        ("Load pulley", drive.load_pulley),
        ("Motor", drive.motor),
        ("Measured stiffness and damping of one span", drive.lumped),
        ("Sensors", drive.sensors),
        ("Goal", drive.goal),
    ]
    groups = [
        RowGroup(title=title, rows=_rows(part)) for title, part in parts if part is not None and _rows(part)
    ]
    groups[4:4] = _carriages(drive)
    return Table(caption="Data of the drive file.", columns=_QUANTITY, groups=tuple(groups))


def _rows(table: Any) -> tuple[tuple[str, str], ...]:
    """What is stated of one part; what is not stated, or zero because nothing was stated, is left out."""
    rows = []
    for field in fields(table):
        value, unit = getattr(table, field.name), field.metadata.get("unit")
        if unit is not None and value is not None and not (value == 0.0 and field.default == 0.0):
            rows.append((_capital(field.metadata["meaning"].partition(";")[0]), _shown(value, unit)))
    return tuple(rows)


def _shown(value: float, unit: str) -> str:
    return f"{value:d}" if unit == "count" else quantity(value, unit)


def _capital(words: str) -> str:
    """A capital at the beginning, but not of a key such as motor.torque_limit."""
    first = words.partition(" ")[0]
    return words if "." in first or "_" in first else words[:1].upper() + words[1:]


def _carriages(drive: Drive) -> list[RowGroup]:
    if not drive.carriage:
        return []
    if len(drive.carriage) > MOST_CARRIAGES:
        return [RowGroup(title=f"{len(drive.carriage)} carriages", rows=_many(drive))]
    rows = []
    for number, carriage in enumerate(drive.carriage):
        held = "guided" if carriage.guided else "hanging"
        at = f"{quantity(carriage.mass, 'kg')} at {quantity(carriage.position, 'm')}"
        rows.append((f"Carriage {number}, {held} on the {carriage.span} span", at))
    return [RowGroup(title="Carriages", rows=tuple(rows))]


def _many(drive: Drive) -> tuple[tuple[str, str], ...]:
    masses = [carriage.mass for carriage in drive.carriage]
    least, most = quantity(min(masses), "kg"), quantity(max(masses), "kg")
    rows = [("Mass of each", least if least == most else f"{least} to {most}")]
    for span in drive.spans:
        places = [carriage.position for carriage in drive.carriages_on(span)]
        if places:
            between = f"{quantity(places[0], 'm')} to {quantity(places[-1], 'm')}"
            rows.append((f"{len(places)} on the {span} span, from", between))
    return tuple(rows)


def _derived(drive: Drive) -> Table:
    sheet = derived_with_lowest(drive)
    groups = []
    for title, lines in DATASHEET.items():
        known = [(words, sheet[name], unit) for name, words, unit in lines if sheet.get(name) is not None]
        rows = [
            (words, quantity(0.0 if abs(value) < NOTHING else value, unit)) for words, value, unit in known
        ]
        if rows:
            groups.append(RowGroup(title=title, rows=tuple(rows)))
    return Table(caption="Derived quantities.", columns=_QUANTITY, groups=tuple(groups))
