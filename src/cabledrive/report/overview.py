"""The lowest frequencies of all machines in one picture."""

from cabledrive.report.blocks import Figure
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.overview import overview_picture


def overview_figure(context: ReportContext) -> Figure:
    """The lowest mode of each kind of every machine on one logarithmic axis."""
    names = [machine.name for machine in context.machines]
    picture = overview_picture("overview-modes", names, (*context.modes, *context.route_modes))
    return picture.figure(
        name="overview-modes",
        alt="Lowest longitudinal and transverse frequency of each machine on a logarithmic axis; the "
        "numbers are on the cards.",
        caption="The lowest longitudinal (along) and transverse (across) mode of each machine. Where the "
        "second is near half the first, longitudinal motion can excite transverse motion parametrically.",
    )
