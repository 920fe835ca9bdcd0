"""`cabledrive check`: whether a drive file is valid, what follows from it, and what looks odd."""

from typing import Any

from cabledrive.app.options import machine_argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import content_hash
from cabledrive.parameters.route import Machine, RoutedDrive

OF_PULLEYS = "closed formulas of the datasheet; lowest frequencies by the exact dynamic stiffness"
OF_ROUTES = "tangents and balance of forces; lowest frequencies by the exact dynamic stiffness"


@subcommand('cabledrive check elevator --set cable.pretension="20 kN"', (saves_answer, machine_argument))
def command(
    drive: Machine,
    plot: NewFile | None = opt(
        "picture", "Draw the machine from its coordinates into FILE, ending in .png, .svg or .pdf."
    ),
    motion_file: str | None = opt(
        "path",
        "Check a planned motion as well: tensions with forces of inertia and vibration against slack and "
        "strength, slip on every pulley, torque of the motors. A CSV file with time [s], torque [N m] and, "
        "of loops and lines, load torque [N m]; of a machine with routes also torque NAME, of another "
        "motor's pulley, and places of bodies such as head.x [m], which make the torque unnecessary.",
        flags="--motion",
    ),
) -> Answer:
    """Validate DRIVE; print derived quantities and warnings; with --motion the margins along it."""
    if isinstance(drive, RoutedDrive):
        answer = _checked_route(drive)
    else:
        from cabledrive.modal.lowest import derived_with_lowest
        from cabledrive.report.blocks import table_text
        from cabledrive.report.machine.data import derived_table

        derived = derived_with_lowest(drive)
        sheet = table_text(derived_table(derived))
        answer = _answer(drive, {"derived": derived}, [sheet], OF_PULLEYS)
    if motion_file is not None:
        from cabledrive.app.checked import with_margins

        answer = with_margins(answer, drive, motion_file)
    if plot is not None:
        from cabledrive.report.machine_figure import machine_drawing

        plot.write(machine_drawing(drive, plot.path.suffix[1:]))
    return answer


def _checked_route(drive: RoutedDrive) -> Answer:
    from cabledrive.mechanics.network import network_of, statics_of
    from cabledrive.mechanics.network.span_table import (
        PULLEY_ROW,
        SPAN_ROW,
        pulley_rows,
        span_rows,
    )
    from cabledrive.modal.lowest import lowest_frequencies
    from cabledrive.modal.route_network import network_of_routes
    from cabledrive.modal.spectrum import Spectrum
    from cabledrive.report.blocks import table_text
    from cabledrive.report.machine.data import pulleys_table, spans_table

    statics, lowest = statics_of(drive), lowest_frequencies(drive)
    spans, pulleys = span_rows(drive, statics), pulley_rows(drive, statics)
    rigid = Spectrum(network_of_routes(network_of(drive))).rigid_body_modes
    ends = [row[end] for row in spans for end in ("tension_start", "tension_end")]
    derived = lowest.as_dict() | {
        "rigid_body_modes": rigid,
        "cable_length": sum(row["length"] * row["ropes"] for row in spans),
        "lowest_tension": min(ends),
        "highest_tension": max(ends),
        "spring_preload": statics.preload,
        "reasons": lowest.reasons,
    }
    tables = [table_text(one) for one in (spans_table(drive), pulleys_table(drive)) if one is not None]
    preload = [
        f"Spring of {name} at rest: {force:.4g} {'N m' if name.endswith('.turn') else 'N'}."
        for name, force in statics.preload.items()
    ]
    lines = "\n".join([lowest.line, f"Rigid-body modes: {rigid}.", *preload])
    data = {
        "derived": derived,
        "spans": [SPAN_ROW(row) for row in spans],
        "pulleys": [PULLEY_ROW(row) for row in pulleys],
    }
    return _answer(drive, data, [*tables, lines], OF_ROUTES)


def _answer(drive: Machine, data: dict[str, Any], parts: list[str], method: str) -> Answer:
    from cabledrive.mechanics.datasheet import drive_warnings

    warnings = drive_warnings(drive)
    head = f"{drive.title or drive.name}\nvalid; content hash {content_hash(drive)}"
    findings = "\n".join([f"Warning: {line}." for line in warnings] or ["No warnings."])
    return Answer(
        data={"valid": True, "drive_hash": content_hash(drive), **data, "warnings": warnings},
        text="\n\n".join([head, *parts, findings]),
        provenance=provenance(drive, method=method),
    )
