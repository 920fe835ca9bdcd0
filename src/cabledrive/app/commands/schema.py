"""`cabledrive schema`: the drive file for editors, and what a command answers for programs."""

import json

from cabledrive.app.options import opt, saves_answer, subcommand
from cabledrive.app.results import Answer
from cabledrive.parameters import drive_schema
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.version import __version__


@subcommand("cabledrive schema -o drive.schema.json", (saves_answer,))
def command(of: str | None = opt("COMMAND", "Of the JSON object that this command prints.")) -> Answer:
    """Print the JSON Schema of the drive file, for editors, or of what a command answers with --json."""
    found = drive_schema()
    if of is not None:
        from cabledrive.app.schemas import ANSWERS, answer_schema

        require_known(of, ANSWERS, f'--of: "{of[:60]}" is no command that prints an object')
        found = answer_schema(of)
    schema = {"$comment": f"cabledrive {__version__}"} | found
    return Answer(data=schema, text=json.dumps(schema, indent=2), provenance=None)
