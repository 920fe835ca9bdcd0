"""What `check` says of a machine with routes: spans, pulleys, springs, warnings."""

from collections.abc import Iterable, Sequence
from math import degrees
from typing import Any

from cabledrive.app.results import Answer, provenance, side_by_side
from cabledrive.mechanics.network import statics_of
from cabledrive.mechanics.network.span_table import pulley_rows, route_warnings, span_rows
from cabledrive.modal.lowest import lowest_frequencies
from cabledrive.modal.route_network import network_of_routes
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters import content_hash
from cabledrive.parameters.route import RoutedDrive

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
            "spans": [_told(row, "no strength [N] in the file") for row in spans],
            "pulleys": pulleys,
            "warnings": warnings,
        },
        text="\n\n".join(_text(drive, spans, pulleys, derived, [lowest.line], warnings)),
        provenance=provenance(drive, method=METHOD),
    )


def _told(row: dict[str, Any], reason: str) -> dict[str, Any]:
    """A row with the reason for a safety factor that does not exist."""
    return row if row["safety_factor"] is not None else row | {"safety_factor_reason": reason}


def _text(
    drive: RoutedDrive,
    spans: Sequence[dict[str, Any]],
    pulleys: Sequence[dict[str, Any]],
    derived: dict[str, Any],
    lines: Sequence[str],
    warnings: Sequence[str],
) -> Iterable[str]:
    yield f"{drive.title or drive.name}\nvalid; content hash {content_hash(drive)}"
    head: tuple[str, ...] = (
        "span",
        "length [m]",
        "tension [N]",
        "ropes",
        "wrap at its end [deg]",
        "string [Hz]",
        "safety",
    )
    yield side_by_side(
        head,
        [
            (
                row["name"],
                f"{row['length']:.6g}",
                _range(row["tension_start"], row["tension_end"]),
                str(row["ropes"]),
                "" if row["wrap"] is None else f"{degrees(row['wrap']):.4g}",
                f"{row['string_frequency_hz']:.5g}",
                "" if row["safety_factor"] is None else f"{row['safety_factor']:.3g}",
            )
            for row in spans
        ],
    )
    if pulleys:
        head = ("pulley", "wrap [deg]", "needed friction", "given")
        yield side_by_side(
            head,
            [
                (
                    row["name"],
                    f"{degrees(row['wrap']):.4g}",
                    "slips" if row["needed_friction"] is None else f"{row['needed_friction']:.3g}",
                    "" if row["capstan_friction"] is None else f"{row['capstan_friction']:.3g}",
                )
                for row in pulleys
            ],
        )
    preload = [
        f"Spring of {name} at rest: {force:.4g} {'N m' if name.endswith('.turn') else 'N'}."
        for name, force in derived["spring_preload"].items()
    ]
    yield "\n".join([*lines, f"Rigid-body modes: {derived['rigid_body_modes']}.", *preload])
    yield "\n".join([f"Warning: {line}." for line in warnings] or ["No warnings."])


def _range(first: float, last: float) -> str:
    return f"{first:.5g}" if abs(first - last) <= 1e-6 * abs(first) else f"{first:.5g} to {last:.5g}"
