"""`cabledrive schema`: the drive file for editors."""

import json

import click

from cabledrive.app.options import Subcommand, answering, saves_answer
from cabledrive.app.results import Answer
from cabledrive.parameters import drive_schema
from cabledrive.parameters.version import __version__


@click.command(cls=Subcommand, example="cabledrive schema -o drive.schema.json")
@answering
@saves_answer
def command() -> Answer:
    """Print the JSON Schema of the drive file, for editors."""
    schema = {"$comment": f"cabledrive {__version__}"} | drive_schema()
    return Answer(data=schema, text=json.dumps(schema, indent=2), provenance=None)
