"""The command `cabledrive`: finds its subcommands, runs one, and turns how it ended into an exit status."""

import pkgutil
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import click

from cabledrive.app import commands
from cabledrive.app.failures import Interrupted, interrupted, run_to_its_end, status_of, watched_output
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.version import __version__

EPILOG = """\b
Example:
  cabledrive study dissertation-3 --quick -o study
\b
DRIVE is the path of a drive file or the name of a packaged drive.
Each command has an example of its own: cabledrive COMMAND --help.
Completion of commands, options and drives in bash (zsh: zsh_source):
  eval "$(_CABLEDRIVE_COMPLETE=bash_source cabledrive)"
"""

SECTIONS = {
    "The whole job": ("studio", "study", "report"),
    "The drive": ("drives", "check", "schema"),
    "Vibration": ("modes", "map", "resonance", "sway", "simulate"),
    "Measurement": ("experiment", "identify", "response", "shaper", "camera"),
    "Control": ("track", "compare", "export"),
    "Many drives": ("sweep", "sensitivity", "tolerance"),
}
"""Commands by what they are for; one that is in none stands under "More"."""


class Door(click.Group):
    """The group of subcommands; each is imported when it is called for, so that the command starts fast."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the subcommands in alphabetical order: modules in `cabledrive.app.commands`."""
        return sorted(module.name for module in pkgutil.iter_modules(commands.__path__))

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands by what they are for, each with its whole first sentence."""
        names = self.list_commands(ctx)
        sorted_in = {name for group in SECTIONS.values() for name in group}
        more = tuple(name for name in names if name not in sorted_in)
        for title, group in (*SECTIONS.items(), ("More", more)):
            found = ((name, self.get_command(ctx, name)) for name in group if name in names)
            rows = [(name, own.get_short_help_str(limit=200)) for name, own in found if own is not None]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a subcommand. Returns none if there is no such subcommand."""
        if cmd_name not in self.list_commands(ctx):
            return None
        command: click.Command = import_module(f"{commands.__name__}.{cmd_name}").command
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Name, subcommand and its arguments; an unknown name is refused."""
        known = self.list_commands(ctx)
        if args[0] not in known and not ctx.resilient_parsing:
            raise InputRefused(f'no such command "{args[0]}"{nearest(args[0], known)}; see cabledrive --help')
        return super().resolve_command(ctx, args)

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        """Read the arguments; ``--help`` and ``--version`` answer here. ``*args``, ``**extra``: for click."""
        with watched_output():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> None:
        """Run the subcommand."""
        try:
            super().invoke(ctx)
        except KeyboardInterrupt as end:
            raise Interrupted(str(end)) from end  # click would print an empty line
        except EOFError as error:  # which click takes for an interrupt, too
            raise RuntimeError(f"unexpected end of a file: {error}") from error
        with watched_output():
            pass

    def main(  # type: ignore[override]
        self, args: Sequence[str] | None = None, prog_name: str | None = None, **extra: Any
    ) -> None:
        """Run the command, on the process's arguments if none, and exit with its status."""
        options = {**extra, "standalone_mode": False}
        raise SystemExit(
            run_to_its_end(
                lambda: status_of(lambda: super(Door, self).main(args, prog_name, **options)), interrupted
            )
        )


@click.group(
    cls=Door,
    epilog=EPILOG,
    invoke_without_command=True,
    no_args_is_help=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(__version__, message="cabledrive %(version)s")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Vibration, identification and control of machines driven by flexible cables, belts and tendons."""
    if ctx.invoked_subcommand is None:
        with watched_output():
            click.echo(ctx.get_help())
