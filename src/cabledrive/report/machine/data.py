"""What a machine is: a drawing of it, its data, what follows from them."""

import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from math import degrees
from typing import Any, NamedTuple

import numpy as np

from cabledrive.answers.figures import MOST_PARTS, Row, fields_by_key, given, number, shown
from cabledrive.mechanics.datasheet import drive_warnings, goal_warnings
from cabledrive.mechanics.network import Statics, statics_of
from cabledrive.mechanics.network.span_table import pulley_rows, span_rows
from cabledrive.mechanics.rest import sag_of
from cabledrive.modal.lowest import derived_with_lowest
from cabledrive.modal.natural import spectrum_of
from cabledrive.parameters import Cable, Drive, InputRefused, Machine, NotComputed
from cabledrive.reduction.network_axis import as_axis
from cabledrive.report.blocks import Figure, RowGroup, Table, Text, listed, table
from cabledrive.report.figures.moving_machine import coordinates, moving_machine
from cabledrive.report.typesetting import capital
from cabledrive.report.words import DATASHEET

NOTHING = 1e-12  # in SI; what round-off leaves of a weight across a vertical cable
_HEADS = "Quantity | Value []"


def source_paragraphs(source: str) -> tuple[str, ...]:
    """A text of many lines, cut where a line begins with a heading in capitals."""
    parts = re.split(r"\n(?=[A-Z]{3,}[A-Z ]*[:\s(])", source.strip()) if source.strip() else []
    return tuple(" ".join(part.split()) for part in parts)


SEEN = (
    "The machine from its coordinates; the colour of a span is its tension at rest. Bands are bodies with "
    "what they carry, dots anchors, boxes carriages; sag is to the scale of its span."
)


def drawing(drive: Machine, name: str) -> Figure:
    """The machine from its coordinates, spans coloured by tension."""
    machine = coordinates(drive)
    ropes = f"{len(machine.route)} {'rope' if len(machine.route) == 1 else 'ropes'}"
    held = f"{len(machine.pulley)} pulleys, {len(machine.body)} bodies, {len(machine.motor)} motors"
    alt = f"The machine from its coordinates: {ropes}, {held}, {len(machine.carriage)} carriages."
    return Figure(name=f"drawing-{name}", alt=alt, caption=SEEN, drawing=moving_machine(drive, None))


def data_table(drive: Machine) -> Table:
    """The values of the drive file, part by part; of many of a kind the first."""
    groups, left = [], []
    for own in fields(drive):
        value = getattr(drive, own.name)
        parts = [part for part in (value if isinstance(value, tuple) else (value,)) if is_dataclass(part)]
        for number_, part in enumerate(parts[:MOST_PARTS]):
            name = getattr(part, "name", "") or (str(number_) if len(parts) > 1 else "")
            if rows := _rows(part):
                groups.append(RowGroup(title=f"{own.name.capitalize()} {name}".rstrip(), rows=rows))
        left += [f"{len(parts) - MOST_PARTS} more of {own.name}"] if len(parts) > MOST_PARTS else []
    return table("Data of the drive file.", _HEADS, groups, note="; ".join(left))


def _rows(part: Any) -> tuple[tuple[str, str], ...]:
    """What is stated of one part, in words."""
    stated = fields_by_key(part.__class__).items()
    words = {key: capital(own.metadata["meaning"].partition(";")[0]) for key, own in stated}
    return tuple((words[key], value) for key, value in given(part) if key in words)


def derived_table(sheet: Mapping[str, Any], caption: Text = "Derived quantities.") -> Table:
    """What follows from the data. ``sheet``: in SI, by name."""
    seen = {key: 0.0 if isinstance(own, float) and abs(own) < NOTHING else own for key, own in sheet.items()}
    found = ((title, tuple(shown(rows, seen))) for title, rows in DATASHEET.items())
    groups = [RowGroup(title=title, rows=rows) for title, rows in found if rows]
    return table(caption, _HEADS, groups)


EVEN = 1e-6
"""Relative difference of two tensions below which they are one."""


def both(values: tuple[float, float]) -> str:
    """Two tensions, or one where they are the same."""
    low, high = (number(value) for value in values)
    same = abs(values[0] - values[1]) <= EVEN * abs(values[0]) or low == high
    return low if same else f"{low} to {high}"


SPANS = (
    Row("name", "Span", kind="text"),
    Row("length", "Length", "m", 6),
    Row("ends", "Tension", "N", both),
    Row("ropes", "Ropes", form="d"),
    Row("wrap", "Wrap at its end", "deg", 4, degrees(1.0)),
    Row("string_frequency_hz", "String", "Hz", 5),
    Row("safety_factor", "Safety", "", 3),
)
PULLEYS = (
    Row("name", "Pulley", kind="text"),
    Row("wrap", "Wrap", "deg", 4, degrees(1.0)),
    Row("needed_friction", "Friction needed at rest", "", 3, none="slips"),
    Row("capstan_friction", "Friction given", "", 3),
)


class DataSheet(NamedTuple):
    """What follows from the data of a machine, in SI by name; spans and pulleys at rest."""

    derived: dict[str, Any]
    spans: list[dict[str, Any]]
    pulleys: list[dict[str, Any]]

    @property
    def tables(self) -> list[Table]:
        """That of spans, and of pulleys where ropes pass any."""
        ended = (row | {"ends": (row["tension_start"], row["tension_end"])} for row in self.spans)
        note = "Safety is the rope's strength over its largest tension at rest."
        found = [listed("Free spans at rest.", SPANS, ended, note=note)]
        return found + (
            [listed("Pulleys that a rope passes.", PULLEYS, self.pulleys)] if self.pulleys else []
        )


OF_ONE_ROPE = (
    *("axial_rigidity", "prestrain", "stretched_mass_per_length"),
    *("axial_wave_speed", "transverse_wave_speed"),
)


def _of_ropes(machine: Machine, statics: Statics) -> tuple[dict[str, Any], dict[str, str]]:
    """Of ropes and the first axis what a loop has in closed form, in SI by name; why it has not."""
    kinds = {(rope.axial_rigidity, rope.mass_per_length, rope.pretension) for rope in machine.ropes}
    found: dict[str, Any] = dict.fromkeys(OF_ONE_ROPE)
    why = dict.fromkeys(OF_ONE_ROPE, "ropes differ, or none states a pretension: see the spans")
    (rigidity, density, pretension), *others = kinds
    if pretension is not None and not others:
        cable = Cable(given_rigidity=rigidity, mass_per_length=density or 0.0, pretension=pretension)
        found, why = {name: getattr(cable, name) for name in OF_ONE_ROPE}, {}
    both = list(zip(machine.free_spans, statics.stretches, strict=True))
    masses = (machine.ropes[span.route].mass_per_length or 0.0 for span, _ in both)
    lengths = (machine.route[span.route].ropes * own[-1].end for span, own in both)
    found["cable_mass"] = sum(mass * length for mass, length in zip(masses, lengths, strict=True))
    found["static_sag"] = max(float(np.abs(sag_of(own)[1]).max()) for _, own in both)
    axis, reason = _first_axis(machine)
    found["slack_torque"] = axis and axis.axis.words["slack_torque"]
    return found, why if axis else why | {"slack_torque": reason}


@lru_cache(maxsize=8)  # the sheet of a machine and its warnings ask for the same
def _first_axis(drive: Machine) -> tuple[Drive | None, str]:
    """The first axis of a machine for control; else None, and why there is none."""
    try:
        return as_axis(drive), ""
    except (InputRefused, NotComputed) as refusal:
        return None, str(refusal)


def machine_warnings(drive: Machine) -> tuple[str, ...]:
    """What is likely to be a mistake or a limit, a line each; of routes also motors that slacken an axis."""
    found, (axis, _) = drive_warnings(drive), _first_axis(drive)
    if drive.two_pulleys is not None or axis is None or axis.motor is None:
        return found
    found = (*found, *goal_warnings(axis, max(axis.axis.words["frequencies_hz"])))
    limit, slack = axis.motor.torque_limit, axis.axis.words.get("slack_torque")
    if limit is None or slack is None or limit <= slack:
        return found
    return (
        *found,
        f"the torque limit leaves the motors of {axis.axis.load} {limit:.4g} N m in all, above {slack:.4g} N "
        "m, from which a rope of the held axis goes slack: limit the torque, or raise the pretension",
    )


def data_sheet(machine: Machine) -> DataSheet:
    """Derived quantities of a machine, and its spans by the names that modes have."""
    derived = derived_with_lowest(machine)
    statics = statics_of(machine, held=machine.turned)
    if "slack_torque" not in derived:
        found, why = _of_ropes(machine, statics)
        derived = found | derived | {"reasons": derived["reasons"] | why}
    spans, pulleys = span_rows(machine, statics), pulley_rows(machine, statics)
    ends = [row[end] for row in spans for end in ("tension_start", "tension_end")]
    derived |= {
        "rigid_body_modes": spectrum_of(machine)[0].rigid_body_modes,
        "cable_length": sum(row["length"] * row["ropes"] for row in spans),
        "lowest_tension": min(ends),
        "highest_tension": max(ends),
        "spring_preload": statics.preload,
    }
    return DataSheet(derived, spans, pulleys)
