"""`cabledrive report`: everything about some drives, or a campaign, on one page."""

from pathlib import Path

import click

from cabledrive.answers.keys import Keys
from cabledrive.app.combinations import refuse_given
from cabledrive.app.failures import note
from cabledrive.app.options import argument, force_option, opt, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import InputRefused, content_hash, load_drive, packaged_drives

PAGE_OF_A_STORE = Keys("text: report store")
PAGE_OF_DRIVES = Keys("text: report rows: drives{text: name drive_hash}")


@subcommand("cabledrive report elevator ropeway -o report.html", (force_option,))
def command(
    drives: tuple[str, ...] = argument("[DRIVE]...", nargs=-1),
    goals: tuple[str, ...] = opt(
        "GOAL", 'Of a campaign: a limit such as "peak_error_deg < 0.05 deg"; repeatable.', multiple=True
    ),
    links: tuple[Path, ...] = opt(
        click.Path(path_type=Path),
        "Another page, such as that of a campaign, shown as a card; repeatable.",
        multiple=True,
        metavar="PAGE",
    ),
    output: NewFile = opt("page", "The HTML page, in one file.", required=True, flags="-o --output"),
) -> Answer:
    """Write one self-contained page about each DRIVE; without one, about the packaged drives.

    A store of a sweep, STORE.zarr, in place of DRIVE: yield, drivers of failure, scatter, worst machines.
    """
    if any((Path(name) / "zarr.json").is_file() for name in drives):
        from cabledrive.campaign.page import campaign_page

        refuse_given("links", why="is for the page of drives: leave it out")
        if len(drives) > 1:
            raise InputRefused(f"{drives[1]}: a page is about one campaign: name one store")
        output.write(campaign_page(drives[0], goals))
        data = {"report": str(output.path), "store": drives[0]}
        return Answer(data=data, text=f"written to {output.path}", provenance=provenance())
    refuse_given("goals", why="is for the store of a sweep: name one, or leave it out")
    names = drives or sorted(packaged_drives(), key=lambda name: name.startswith("dissertation"))
    loaded = [load_drive(name) for name in names]
    from cabledrive.report import write_report

    path = write_report(loaded, output.path, force=output.force, progress=note, links=links)
    rows = [{"name": drive.name, "drive_hash": content_hash(drive)} for drive in loaded]
    return Answer(
        data={"report": str(path), "drives": rows}, text=f"written to {path}", provenance=provenance()
    )
