"""`cabledrive track`: a control law follows pulses on the virtual rig."""

from typing import Any

import click

from cabledrive.app.options import NewFile, NewFileType, Subcommand, answering, drive_argument, saves_answer
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import Drive, load_drive

METHOD = "hybrid simulation: exact between samples, stick-slip events on the exact motion"


@click.command(
    cls=Subcommand,
    example="cabledrive track dissertation-3 --controller darc-4 --seed 7",
    short_help="Follow pulses with a control law on the virtual rig.",
)
@answering
@saves_answer
@drive_argument
@click.option(
    "--controller", metavar="NAME", help="Control law; by default what the drive's joint calls for."
)
@click.option("--bandwidth", type=float, metavar="HZ", help="lambda/(2 pi) instead of the printed one.")
@click.option("--gains", type=click.Choice(["printed", "best"]), default="printed", show_default=True)
@click.option("--plant", metavar="NAME", help="model-1 to model-4; by default the highest the data allow.")
@click.option("--angle", type=float, default=45.0, show_default=True, metavar="DEG", help="Of each pulse.")
@click.option("--rise", type=float, default=0.5, show_default=True, metavar="S", help="Rise time.")
@click.option("--dwell", type=float, default=0.5, show_default=True, metavar="S", help="Rest after a move.")
@click.option("--pulses", type=int, default=1, show_default=True, metavar="N")
@click.option("--order", type=int, default=9, show_default=True, metavar="N", help="Odd order of the rise.")
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of the encoder phases.")
@click.option("--observer", type=click.Choice(["kalman", "difference"]), default="kalman", show_default=True)
@click.option(
    "--feedback",
    type=click.Choice(["motor", "drive"]),
    default="motor",
    show_default=True,
    help="Encoder that stands for theta_1.",
)
@click.option(
    "--encoder-phase", type=click.Choice(["random", "centred"]), default="random", show_default=True
)
@click.option("--ideal-sensors", is_flag=True, help="The law sees true angles and speeds.")
@click.option("--smooth-friction", is_flag=True, help="c tanh(50 w) in the plant instead of stick-slip.")
@click.option("--no-adaptation", is_flag=True, help="Estimates stay where they start.")
@click.option("--tension-only", is_flag=True, help="Go on where a span would go slack.")
@click.option(
    "--plant-set", "plant_settings", multiple=True, metavar="KEY=VALUE", help="As --set, of the plant only."
)
@click.option("--draws", type=int, default=0, metavar="N", help="Plants to draw from the bounds as well.")
@click.option(
    "--log",
    "log_file",
    type=NewFileType(".csv"),
    metavar="FILE",
    help="Write what the encoders saw to FILE.csv.",
)
def command(drive: Drive, log_file: NewFile | None, plant_settings: tuple[str, ...], **wish: Any) -> Answer:
    """Let a control law follow pulses of the load pulley of DRIVE, on a rig with encoders and friction."""
    from cabledrive.rig import Motion, RigOptions, track
    from cabledrive.rig.log_file import log_text

    given = click.get_current_context().params
    actual = None
    if plant_settings:
        actual = load_drive(given["drive"], overrides=(*given["settings"], *plant_settings))
    found = track(
        drive,
        controller=wish["controller"],
        bandwidth=wish["bandwidth"],
        gains=wish["gains"],
        plant=wish["plant"],
        motion=Motion(**{name: wish[name] for name in ("angle", "rise", "dwell", "pulses", "order")}),
        options=RigOptions(
            observer=wish["observer"],
            feedback=wish["feedback"],
            encoder_phase=wish["encoder_phase"],
            ideal_sensors=wish["ideal_sensors"],
            smooth_friction=wish["smooth_friction"],
            forbid_slack=not wish["tension_only"],
        ),
        plant_drive=actual,
        seed=wish["seed"],
        adapt=not wish["no_adaptation"],
        draws=wish["draws"],
    )
    if log_file is not None:
        log_file.write(log_text(found))
    said = found.summary
    return Answer(
        data=said,
        text=_text(drive, said),
        provenance=provenance(drive, method=METHOD, step=said["internal_step"], seed=wish["seed"]),
        incomplete=found.incomplete,
    )


def _text(drive: Drive, said: dict[str, Any]) -> str:
    lines = [
        f"{drive.title or drive.name}: {said['controller']} on {said['plant']}, {said['observer']}",
        "",
        f"  peak error      {said['peak_error_deg']:9.4f} deg",
        f"   by its encoder {said['encoder_error_deg']:9.4f} deg",
        f"  rms error       {said['rms_error_deg']:9.4f} deg",
        f"  peak torque     {said['peak_torque']:9.4f} N m",
        f"  at its limit    {100 * said['saturated_fraction']:9.1f} % of the samples",
    ]
    if said["theory_bound_deg"] is not None:
        lines.append(f"  bound           {said['theory_bound_deg']:9.4f} deg")
    if said["broken_assumptions"]:
        lines.append("  the theorem's assumptions do not hold: " + "; ".join(said["broken_assumptions"]))
    if "over_draws" in said:
        over = said["over_draws"]
        lines.append(
            f"  over {over['draws']} draws   median {over['median_peak_error_deg']:.4f}, "
            f"worst {over['worst_peak_error_deg']:.4f} deg"
        )
    return "\n".join(lines)
