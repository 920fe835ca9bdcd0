"""`cabledrive check`: whether a drive file is valid, what follows from it, and what looks odd."""

from typing import Any

import click

from cabledrive.app.options import Subcommand, answering, machine_argument, option, saves_answer
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.app.route_answer import checked_route
from cabledrive.mechanics.warnings import drive_warnings
from cabledrive.modal.lowest import derived_with_lowest
from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.route import RoutedDrive

METHOD = "closed formulas of the datasheet; lowest frequencies by the exact dynamic stiffness"


@click.command(cls=Subcommand, example='cabledrive check elevator --set cable.pretension="20 kN"')
@answering
@saves_answer
@machine_argument
@option("--plot", "picture", "Draw the machine from its coordinates into FILE, ending in .png, .svg or .pdf.")
@option(
    "--motion motion_file",
    "path",
    "Check a planned motion as well: tensions with forces of inertia and vibration against slack and "
    "strength, slip on every pulley, torque of the motors. A CSV file with time [s], torque [N m] and, of "
    "loops and lines, load torque [N m]; of a machine with routes also torque NAME, of another "
    "motor's pulley, and "
    "places of bodies such as head.x [m], which make the torque unnecessary.",
)
def command(drive: Drive | RoutedDrive, plot: NewFile | None, motion_file: str | None) -> Answer:
    """Validate DRIVE; print derived quantities and warnings; with --motion the margins along it."""
    answer = checked_route(drive) if isinstance(drive, RoutedDrive) else _checked(drive)
    if motion_file is not None:
        from cabledrive.app.motion_answers import with_margins

        answer = with_margins(answer, drive, motion_file)
    if plot is not None:
        from cabledrive.report.machine_figure import machine_drawing

        plot.write(machine_drawing(drive, plot.path.suffix[1:]))
    return answer


def _checked(drive: Drive) -> Answer:
    derived = derived_with_lowest(drive)
    warnings = drive_warnings(drive)
    return Answer(
        data={
            "valid": True,
            "drive_hash": content_hash(drive),
            "derived": derived,
            "warnings": warnings,
        },
        text=_text(drive, derived, warnings),
        provenance=provenance(drive, method=METHOD),
    )


def _text(drive: Drive, derived: dict[str, Any], warnings: tuple[str, ...]) -> str:
    from cabledrive.report.blocks import table_text
    from cabledrive.report.machine.data import derived_table

    head = f"{drive.title or drive.name}\nvalid; content hash {content_hash(drive)}"
    findings = [f"Warning: {line}." for line in warnings] or ["No warnings."]
    return "\n\n".join([head, table_text(derived_table(derived)), "\n".join(findings)])
