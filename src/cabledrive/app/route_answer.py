"""What `check` says of a machine with routes: spans, pulleys, springs, warnings."""

from collections.abc import Iterable, Sequence
from typing import Any

from cabledrive.app.results import Answer, known, provenance
from cabledrive.mechanics.network import statics_of
from cabledrive.mechanics.network.span_table import pulley_rows, route_warnings, span_rows
from cabledrive.modal.lowest import lowest_frequencies
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import content_hash
from cabledrive.parameters.route import RoutedDrive
from cabledrive.report.blocks import table_text
from cabledrive.report.machine.data import pulleys_table, spans_table

METHOD = "tangents and balance of forces; lowest frequencies by the exact dynamic stiffness"


def checked_route(drive: RoutedDrive) -> Answer:
    """The answer of `check`."""
    from cabledrive.mechanics.network import network_of

    spectrum = Spectrum(network_of_routes(network_of(drive)))
    statics = statics_of(drive)
    spans, pulleys = span_rows(drive, statics), pulley_rows(drive, statics)
    lowest = lowest_frequencies(drive)
    warnings = route_warnings(drive)
    derived = lowest.as_dict() | {
        "rigid_body_modes": spectrum.rigid_body_modes,
        "cable_length": sum(row["length"] * row["ropes"] for row in spans),
        "lowest_tension": min(min(row["tension_start"], row["tension_end"]) for row in spans),
        "highest_tension": max(max(row["tension_start"], row["tension_end"]) for row in spans),
        "spring_preload": statics.preload,
        "reasons": lowest.reasons,
    }
    return Answer(
        data={
            "valid": True,
            "drive_hash": content_hash(drive),
            "derived": derived,
            "spans": [
                row | {"safety_factor": known(row["safety_factor"], "no strength [N] in the file")}
                for row in spans
            ],
            "pulleys": pulleys,
            "warnings": warnings,
        },
        text="\n\n".join(_text(drive, derived, lowest.line, warnings)),
        provenance=provenance(drive, method=METHOD),
    )


def _text(drive: RoutedDrive, derived: dict[str, Any], line: str, warnings: Sequence[str]) -> Iterable[str]:
    yield f"{drive.title or drive.name}\nvalid; content hash {content_hash(drive)}"
    yield table_text(spans_table(drive))
    if (pulleys := pulleys_table(drive)) is not None:
        yield table_text(pulleys)
    preload = [
        f"Spring of {name} at rest: {force:.4g} {'N m' if name.endswith('.turn') else 'N'}."
        for name, force in derived["spring_preload"].items()
    ]
    yield "\n".join([line, f"Rigid-body modes: {derived['rigid_body_modes']}.", *preload])
    yield "\n".join([f"Warning: {line}." for line in warnings] or ["No warnings."])
