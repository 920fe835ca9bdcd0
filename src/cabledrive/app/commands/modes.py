"""`cabledrive modes`: at which frequencies a drive rings, and that these are all."""

from cabledrive.app.options import HOW_HELD, machine_argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import Machine

METHOD = "exact dynamic stiffness, Wittrick-Williams count, inverse iteration"


@subcommand("cabledrive modes elevator --below 20 --plot modes.svg", (saves_answer, machine_argument))
def command(
    drive: Machine,
    below: float | None = opt("Hz", "Every mode below this frequency."),
    count: int | None = opt("count", "The first N frequencies of each kind instead; default: 10."),
    motor: str | None = HOW_HELD,
    hold: tuple[str, ...] = opt(
        "NAME",
        'Hold a part as well: "drive pulley", "load pulley", "carriage 0", or a name of the file.',
        multiple=True,
    ),
    at_torque: float = opt(
        "N m",
        "Steady torque on the drive pulley, taken up at the load pulley; loads the spans unequally.",
        0.0,
    ),
    plot: NewFile | None = opt(
        "picture", "Draw frequencies and shapes into FILE, ending in .png, .svg or .pdf."
    ),
) -> Answer:
    """List all natural modes of DRIVE, both kinds, with a certificate of completeness."""
    from cabledrive.modal import modes
    from cabledrive.modal.lowest import how_held, lowest_frequencies
    from cabledrive.modal.ranges import INCOMPLETE
    from cabledrive.report.words import OF_MODES, certificate_line, modes_text

    found = modes(drive, below=below, count=count, motor=motor, hold=hold, at_torque=at_torque)
    if plot is not None:
        from cabledrive.report.mode_figure import mode_picture

        plot.write(mode_picture(drive, found, plot.path.suffix[1:]))
    lowest = lowest_frequencies(drive)
    head = f"{drive.title or drive.name}\n{lowest.line}\n{how_held(found)}"
    return Answer(
        data=OF_MODES(found)
        | lowest.as_dict()
        | {f"{key}_reason": why for key, why in lowest.reasons.items()},
        text=f"{head}\n\n{modes_text(found)}",
        provenance=provenance(drive, method=METHOD, tolerances={"enclosure": found.certificate.enclosure}),
        incomplete=certificate_line(found) if found.certified_reason == INCOMPLETE else None,
    )
