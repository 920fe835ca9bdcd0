"""`cabledrive schema`: the drive file for editors."""

import json

from cabledrive.app.options import saves_answer, subcommand
from cabledrive.app.results import Answer
from cabledrive.parameters import drive_schema
from cabledrive.parameters.version import __version__


@subcommand("cabledrive schema -o drive.schema.json", (saves_answer,))
def command() -> Answer:
    """Print the JSON Schema of the drive file, for editors."""
    schema = {"$comment": f"cabledrive {__version__}"} | drive_schema()
    return Answer(data=schema, text=json.dumps(schema, indent=2), provenance=None)
