"""`cabledrive report`: everything about some drives on one page."""

import click

from cabledrive.app.messages import note
from cabledrive.app.new_file import PAGE, NewFile, NewFileType
from cabledrive.app.options import Subcommand, answering, force_option
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import content_hash, load_drive, packaged_drives


@click.command(cls=Subcommand, example="cabledrive report elevator ropeway -o report.html")
@answering
@force_option
@click.argument("drives", nargs=-1, metavar="[DRIVE]...")
@click.option(
    "-o",
    "--output",
    type=NewFileType(*PAGE),
    required=True,
    metavar="FILE",
    help="The HTML page, in one file.",
)
def command(drives: tuple[str, ...], output: NewFile) -> Answer:
    """Write one self-contained page about each DRIVE; without one, about the packaged drives."""
    loaded = [load_drive(name) for name in drives or packaged_drives()]
    from cabledrive.report import write_report

    path = write_report(loaded, output.path, force=output.force, progress=note)
    rows = [{"name": drive.name, "drive_hash": content_hash(drive)} for drive in loaded]
    return Answer(
        data={"report": str(path), "drives": rows}, text=f"written to {path}", provenance=provenance()
    )
