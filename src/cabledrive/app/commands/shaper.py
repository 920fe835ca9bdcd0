"""`cabledrive shaper`: the input shaper of a printer's axis, from the logs of its resonance test."""

import click

from cabledrive.app.options import option, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import InputRefused, load_drive


@subcommand("cabledrive shaper resonances_x.csv --plot shaper_x.svg", (saves_answer,))
@click.argument("logs", nargs=-1, required=True, metavar="LOG...")
@option(
    "--axis",
    click.Choice(["x", "y", "z"], case_sensitive=False),
    "The axis that was excited: x, y or z; default: that in the name of LOG.",
    metavar="NAME",
)
@option("--damping", "1", "Damping ratio of the design; default 0.1.", 0.1)
@option("--corner-speed", "m/s", "Square-corner speed of the printer; default 5 mm/s.", 0.005)
@option("--max-smoothing", "m", 'Leave out shapers of a larger smoothing at 5 m/s^2, such as "0.2 mm".')
@option("--plot", "picture", "Draw spectrum and shapers into FILE, ending in .png, .svg or .pdf.")
@option(
    "--page",
    ".html",
    "One page of the printer, from the logs of all axes and both belts, distinguished by name.",
)
@option("--machine", "DRIVE", "With --page: whose computed frequencies stand beside the peaks.")
def command(
    logs: tuple[str, ...],
    axis: str | None,
    plot: NewFile | None,
    page: NewFile | None,
    machine: str | None,
    **design: float | None,
) -> Answer:
    """Choose an input shaper from the LOG of a resonance test: the peaks, what each shaper leaves, its cost.

    LOG is a file of Klipper: resonances_x_*.csv, calibration_data_x_*.csv, or accelerometer samples. Several
    logs of one axis are several places of the head; the worst counts.
    """
    from cabledrive.identification.printer import printer, shaper
    from cabledrive.report.printer_page import METHOD, printer_html, shaper_picture
    from cabledrive.report.printer_tables import printer_data, printer_text, shaper_data, shaper_text

    if page is not None:
        if axis is not None or plot is not None:
            raise InputRefused("--page sorts the logs by their names: leave --axis and --plot out")
        whole, drive = printer(logs, **design), None if machine is None else load_drive(machine)
        page.write(printer_html(whole, drive))
        about = provenance(method=METHOD)
        return Answer(data=printer_data(whole), text=printer_text(whole), provenance=about)
    if machine is not None:
        raise InputRefused("--machine is for --page: add it, or leave --machine out")
    found = shaper(logs, axis=axis, **design)  # type: ignore[arg-type]
    if plot is not None:
        plot.write(shaper_picture(found, plot.path.suffix[1:]))
    return Answer(data=shaper_data(found), text=shaper_text(found), provenance=provenance(method=METHOD))
