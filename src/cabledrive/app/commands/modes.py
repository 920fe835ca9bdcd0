"""`cabledrive modes`: at which frequencies a drive rings, and that these are all."""

import click

from cabledrive.answers.keys import Keys
from cabledrive.app.options import machine_argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.mechanics.holding import CONDITIONS
from cabledrive.modal import Mode, Modes, modes
from cabledrive.modal.lowest import LOWEST, how_held, lowest_frequencies
from cabledrive.modal.mode import Certificate
from cabledrive.modal.ranges import INCOMPLETE
from cabledrive.parameters import Drive
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.report.words import certificate_line, modes_text

METHOD = "exact dynamic stiffness, Wittrick-Williams count, inverse iteration"
MODE = Keys(
    "frequency_hz=frequency kind family multiplicity kinetic_shares proven span? plane? section? model? "
    "clamped? strain_shares?",
    of=Mode,
)
PROOF = Keys(
    "below_hz=below longitudinal_below_hz=longitudinal_below transverse_below_hz=transverse_below count "
    "longitudinal transverse enclosure",
    of=Certificate,
)
MODES = Keys(
    "modes certified certified_reason? warnings certificate rigid_body_modes motor hold at_torque",
    parts={"modes": MODE, "certificate": PROOF},
    of=Modes,
)
LISTED = Keys("", also=(LOWEST, MODES))


@subcommand("cabledrive modes elevator --below 20 --plot modes.svg", (saves_answer, machine_argument))
def command(
    drive: Drive | RoutedDrive,
    below: float | None = opt("Hz", "Every mode below this frequency."),
    count: int | None = opt("count", "The first N frequencies of each kind instead; default: 10."),
    motor: str | None = opt(
        click.Choice(CONDITIONS),
        "How the rotor is held; default: holding with a motor.holding_stiffness, else free.",
    ),
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
    found = modes(drive, below=below, count=count, motor=motor, hold=hold, at_torque=at_torque)
    if plot is not None:
        from cabledrive.report.mode_figure import mode_picture

        plot.write(mode_picture(drive, found, plot.path.suffix[1:]))
    lowest = lowest_frequencies(drive)
    head = f"{drive.title or drive.name}\n{lowest.line}\n{how_held(found)}"
    return Answer(
        data=MODES(found) | lowest.as_dict() | {f"{key}_reason": why for key, why in lowest.reasons.items()},
        text=f"{head}\n\n{modes_text(found)}",
        provenance=provenance(drive, method=METHOD, tolerances={"enclosure": found.certificate.enclosure}),
        incomplete=certificate_line(found) if found.certified_reason == INCOMPLETE else None,
    )
