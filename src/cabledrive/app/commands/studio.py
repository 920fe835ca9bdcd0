"""`cabledrive studio`: the drive on the screen, in the browser, on this machine alone."""

import click

from cabledrive.app.options import Subcommand, complete_drive, option


@click.command(
    cls=Subcommand,
    example="cabledrive studio dissertation-3 --folder my-studio",
    short_help="Open a drive in the browser: sliders, modes, resonance, logs, controllers.",
)
@click.argument("drive", metavar="[DRIVE]", required=False, shell_complete=complete_drive)
@option("--port", click.IntRange(0, 65535), "Port of 127.0.0.1; default: a free one.", 0, metavar="N")
@option("--no-browser", "flag", "Print the address only.")
@option("--folder", "path", "Where drives, logs and results are kept.", "cabledrive-studio", metavar="DIR")
def command(drive: str | None, port: int, no_browser: bool, folder: str) -> None:
    """Open DRIVE in the browser: the first line printed is the address, with a token that works once.

    The page is served on 127.0.0.1 alone. Nothing is written outside DIR. Ctrl-C ends it.
    """
    from cabledrive.studio import open_studio

    try:
        open_studio(drive, port=port, browser=not no_browser, folder=folder)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"what was made is kept in {folder}") from None
