"""`cabledrive map`: natural frequencies over figures of a machine, with the speeds that excite them."""

import os
import tempfile
from pathlib import Path

from cabledrive.app.combinations import refuse_given
from cabledrive.app.options import HOW_HELD, force_option, machine_argument, opt, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import Machine

METHOD = "exact dynamic stiffness at every point, modes isolated by counting"
WORKERS = 2


@subcommand(
    "cabledrive map corexy --vary head.x=60mm:360mm:3 --vary beam.y=50mm:330mm:3 -o map.nc",
    (force_option, machine_argument),
)
def command(
    drive: Machine,
    texts: tuple[str, ...] = opt(
        "KEY=FROM:TO[:N]",
        "A key of the drive file, or a move such as head.x, with its range; repeatable. Keys joined "
        "by a comma move together: car.y=5m:35m,counterweight.y=35m:5m.",
        multiple=True,
        required=True,
        flags="--vary",
    ),
    count: int = opt("count", "Modes of each kind; default: 6.", 6),
    motor: str | None = HOW_HELD,
    hold: tuple[str, ...] = opt("NAME", "Hold a part as well; repeatable.", multiple=True),
    orders: tuple[str, ...] = opt(
        "NAME=PART",
        "Excitation that follows the speed: NAME=PULLEY (once a turn), NAME=PULLEY*N, NAME=KEY/LENGTH (rail "
        "joints); needs --speed; default: those of [excitation].",
        multiple=True,
    ),
    speed: str | None = opt("KEY=FROM:TO", "A coordinate with the range of its speed: car.y=0.1m/s:1m/s."),
    margin: float = opt(float, "Share of a frequency that is too near; default: 0.05.", 0.05),
    output: NewFile | None = opt(".nc", "Write the map to FILE, NetCDF.", flags="-o --output"),
    plot: NewFile | None = opt("picture", "Draw the map into FILE."),
    page: NewFile | None = opt("page", "Write an interactive page to FILE."),
) -> Answer:
    """Natural frequencies of DRIVE over a grid of its figures, and speeds at which it would be excited."""
    from cabledrive.app.maps import map_answer, vary_of
    from cabledrive.parameters.drive_parts import order_of, speed_range
    from cabledrive.studies.excitation_orders import excitation
    from cabledrive.studies.mode_map import Grid, map_modes

    if bool(orders) != (speed is not None):
        refuse_given("orders", "speed", why="needs both --order and --speed: add the other, or leave it out")
    stated = drive.excitation
    asked = [order_of(text) for text in orders] or (list(stated.listed) if stated is not None else [])
    if not asked:
        refuse_given("margin", why="belongs to --order and --speed: add those, or leave it out")
    workers = min(WORKERS, os.cpu_count() or 1)
    vary = vary_of(drive, texts)
    found = map_modes(drive, vary, count=count, motor=motor, hold=hold, workers=workers)
    excited = None
    if asked:
        reach = stated.range if speed is None and stated is not None else speed_range(speed or "")
        excited = excitation(Grid(drive, vary, motor, hold, workers), asked, reach, margin=margin)
    data, text = map_answer(drive, found, excited)
    if output is not None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "map.nc"
            found.to_netcdf(file, engine="h5netcdf")
            output.write(file.read_bytes())
    if plot is not None:
        from cabledrive.report.mode_figure import campbell_drawing, map_drawing

        form = plot.path.suffix[1:]
        plot.write(map_drawing(found, form) if excited is None else campbell_drawing(excited, form))
    if page is not None:
        from cabledrive.report.map_page import map_html

        page.write(map_html(drive, found, excited))
    return Answer(data=data, text=text, provenance=provenance(drive, method=METHOD))
