"""`cabledrive shaper`: the input shaper of a printer's axis, from the logs of its resonance test."""

import click

from cabledrive.app.new_file import NewFile, NewFileType
from cabledrive.app.options import Quantity, Subcommand, answering, saves_answer
from cabledrive.app.results import Answer, provenance

METHOD = (
    "types, remaining vibration and score as Klipper defines them; partial fractions of modes for damping"
)


@click.command(
    cls=Subcommand,
    example="cabledrive shaper resonances_x.csv --plot shaper_x.svg",
    short_help="Choose the input shaper of a printer's axis from its resonance test.",
)
@answering
@saves_answer
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@click.option(
    "--axis",
    metavar="NAME",
    type=click.Choice(["x", "y", "z"], case_sensitive=False),
    help="The axis that was excited: x, y or z; default: that in the name of LOG.",
)
@click.option("--damping", type=Quantity("1"), default=0.1, help="Damping ratio of the design; default 0.1.")
@click.option(
    "--corner-speed",
    type=Quantity("m/s"),
    default=0.005,
    metavar="M/S",
    help="Square-corner speed of the printer; default 5 mm/s.",
)
@click.option(
    "--max-smoothing",
    type=Quantity("m"),
    metavar="M",
    help='Leave out shapers of a larger smoothing at 5 m/s^2, such as "0.2 mm".',
)
@click.option(
    "--plot",
    type=NewFileType(".png", ".svg", ".pdf"),
    metavar="FILE",
    help="Draw spectrum and shapers into FILE, ending in .png, .svg or .pdf.",
)
def command(
    logs: tuple[str, ...],
    axis: str | None,
    damping: float,
    corner_speed: float,
    max_smoothing: float | None,
    plot: NewFile | None,
) -> Answer:
    """Choose an input shaper from the LOG of a resonance test: the peaks, what each shaper leaves, its cost.

    LOG is a file of Klipper: resonances_x_*.csv, calibration_data_x_*.csv, or accelerometer samples. Several
    logs of one axis are several places of the head; the worst counts.
    """
    from cabledrive.app.shaper_answer import shaper_data, shaper_text
    from cabledrive.identification.printer_shaper import shaper

    found = shaper(logs, axis=axis, damping=damping, corner_speed=corner_speed, max_smoothing=max_smoothing)
    if plot is not None:
        from cabledrive.report.shaper_figure import shaper_picture

        plot.write(shaper_picture(found, plot.path.suffix[1:]))
    return Answer(data=shaper_data(found), text=shaper_text(found), provenance=provenance(method=METHOD))
