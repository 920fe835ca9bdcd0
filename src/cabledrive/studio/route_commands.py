"""Commands that the uses of a machine with routes need: travel, report, virtual log, pings, printers."""

import json
from pathlib import Path

from cabledrive.identification.printer_files import belt_of, is_printer_file
from cabledrive.parameters import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studio.asked import Asked, Form, drive_file, given
from cabledrive.studio.desk import Desk
from cabledrive.studio.state import State, arguments, drive_of


def travel(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """Natural frequencies over the travel, with the speeds that excite them."""
    options = given(form, vary1="--vary", vary2="--vary", order1="--order", order2="--order", speed="--speed")
    options += given(form, count="--count", motor="--motor")
    if not any(option.startswith("--vary") for option in options):
        raise InputRefused("write what varies, such as head.x=60mm:360mm:3")
    return Asked(
        f"Map of {state.drive} over its travel",
        arguments(desk.library, state, "map", *options, "--page=map.html", "-o", "map.nc"),
    )


def sheet(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """The report of the machine."""
    return Asked(f"Report of {state.drive}", ["report", drive_file(desk, state, folder), "-o", "report.html"])


def virtual_log(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """A log of the virtual rig."""
    options = given(form, axis="--axis", seed="--seed")
    return Asked(
        f"Virtual log of {state.drive}",
        arguments(desk.library, state, "experiment", *options, "-o", "log.csv"),
    )


def ping(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """Tension from the recording of a pluck; a second recording is compared with it."""
    recordings = [desk.logs.path(form.get("log", ""))]
    options = given(form, span="--span")
    if form.get("log2"):
        recordings.append(desk.logs.path(form["log2"]))
        options += given(form, span2="--span")
    source = drive_file(desk, state, folder)
    return Asked(
        f"Tension from {' and '.join(path.name for path in recordings)}",
        ["identify", f"--ping={source}", *options, *(str(path.absolute()) for path in recordings)],
    )


def shaper(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """The page of the printer from all logs here that are named after its tests; of another name, a plot."""
    path = desk.logs.path(form.get("log", ""))
    options = given(form, axis="--axis")
    if options or not is_printer_file(path.name):
        return Asked(
            f"Input shaper from {path.name}", ["shaper", *options, "--plot=shaper.svg", str(path.absolute())]
        )
    oldest_first = [desk.logs.path(log) for log, _ in reversed(desk.logs.listed())]
    paths = {one.name: one.absolute() for one in oldest_first if is_printer_file(one.name)}
    alone = len({belt_of(name) for name in paths} - {None}) == 1
    files = [str(one) for name, one in paths.items() if not (alone and belt_of(name))]
    machine = []
    if isinstance(drive_of(desk.library, state), RoutedDrive):
        machine = [f"--machine={drive_file(desk, state, folder)}"]
    return Asked(f"Printer page of {len(files)} logs", ["shaper", "--page=printer.html", *machine, *files])


def klipper(desk: Desk, state: State, form: Form, folder: Path) -> Asked:
    """The lines of a printer's configuration from a shaper that was found here."""
    job = desk.jobs.all.get(int(form["job"]) if form.get("job", "").isdecimal() else -1)
    if job is None or job.arguments[0] != "shaper" or not job.answer:
        raise InputRefused("no input shaper was found under this number: find one under Logs first")
    (folder / "shaper.json").write_text(json.dumps(job.answer), encoding="utf-8")
    return Asked(
        f"Printer lines of work {job.number}", ["export", "shaper.json", "--format=klipper", "-o", "klipper"]
    )
