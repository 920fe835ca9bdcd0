"""`cabledrive drives`: the drives that come with the package, and the file of each to start from."""

from cabledrive.answers.keys import Keys
from cabledrive.app.options import argument, complete_drive, force_option, opt, subcommand
from cabledrive.app.results import Answer, NewFile, NewFileType, json_text, provenance
from cabledrive.parameters import InputRefused, content_hash, load_drive, packaged_drives, packaged_text

ONE = Keys("text: name title source file")
LIST = Keys("rows: drives{text: name title source kind drive_hash}")
_NEW = NewFileType(".toml", ".json", "")


@subcommand("cabledrive drives printer-belt -o my-printer.toml", (force_option,))
def command(
    name: str | None = argument(None, required=False, shell_complete=complete_drive),
    output: NewFile | None = opt(
        _NEW,
        "With NAME: write the drive file to FILE. Without: write the JSON object.",
        metavar="FILE",
        flags="-o --output",
    ),
) -> Answer:
    """List the packaged drives; with NAME, print the file of that drive, to start from."""
    wrong = ".toml" if name is None else ".json"
    if output is not None and output.path.suffix.lower() == wrong:
        content = "the list is a JSON object" if name is None else "a drive file is TOML"
        raise InputRefused(f"{output.path}: ends in {wrong}, but {content}: rename it")
    if name is None:
        drives = {own: load_drive(own) for own in packaged_drives()}
        rows = [
            {
                "name": own,
                "title": drive.title,
                "source": drive.source.strip(),
                "kind": drive.kind,
                "drive_hash": content_hash(drive),
            }
            for own, drive in drives.items()
        ]
        width = max(map(len, drives))
        lines = (f"{own:<{width}}  {drive.kind:<5}  {drive.title}" for own, drive in drives.items())
        answer = Answer(data={"drives": rows}, text="\n".join(lines), provenance=provenance())
        if output is not None:
            output.write(json_text(answer) + "\n")
        return answer
    text = packaged_text(name)
    if output is not None:
        output.write(text)
    drive = load_drive(name)
    row = {"name": name, "title": drive.title, "source": drive.source.strip(), "file": text}
    return Answer(
        data=row, text="" if output is not None else text.rstrip("\n"), provenance=provenance(drive)
    )
