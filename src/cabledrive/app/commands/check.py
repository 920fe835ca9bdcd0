"""`cabledrive check`: whether a drive file is valid, what follows from it, and what looks odd."""

from cabledrive.app.options import machine_argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile
from cabledrive.parameters import Machine


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
    from cabledrive.app.checked import checked, with_margins

    answer = checked(drive)
    if motion_file is not None:
        answer = with_margins(answer, drive, motion_file)
    if plot is not None:
        from cabledrive.report.machine_figure import machine_drawing

        plot.write(machine_drawing(drive, plot.path.suffix[1:]))
    return answer
