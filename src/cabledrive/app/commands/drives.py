"""`cabledrive drives`: the drives that come with the package."""

import click

from cabledrive.app.options import Subcommand, answering, saves_answer
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import content_hash, load_drive, packaged_drives


@click.command(cls=Subcommand, example="cabledrive drives")
@answering
@saves_answer
def command() -> Answer:
    """List the packaged drives, each with what it is and where its figures come from."""
    drives = {name: load_drive(name) for name in packaged_drives()}
    rows = [
        {
            "name": name,
            "title": drive.title,
            "source": drive.source.strip(),
            "kind": drive.kind,
            "drive_hash": content_hash(drive),
        }
        for name, drive in drives.items()
    ]
    width = max(map(len, drives))
    text = "\n".join(f"{name:<{width}}  {drive.title}" for name, drive in drives.items())
    return Answer(data={"drives": rows}, text=text, provenance=provenance())
