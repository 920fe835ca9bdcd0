"""What the shell is offered where a drive or a control law is named."""

import click
from click.shell_completion import CompletionItem

from cabledrive.parameters import packaged_drives


def complete_drive(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of packaged drives, then files, for the shell. ``incomplete``: what has been typed."""
    names = [CompletionItem(name) for name in packaged_drives() if name.startswith(incomplete)]
    return [*names, CompletionItem(incomplete, type="file")]


def complete_controller(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of control laws, for the shell. ``incomplete``: what has been typed."""
    names = sorted((*control_laws(), "best"))
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]


def control_laws() -> tuple[str, ...]:
    """Names of the control laws."""
    from cabledrive.rig.laws.registry import CONTROLLERS

    return tuple(CONTROLLERS)


def listed_laws() -> tuple[str, ...]:
    """The laws that help lists, and where the others stand."""
    from cabledrive.rig.laws.registry import CONTROLLERS, MAIN_LAWS

    return (*MAIN_LAWS, "best", f"and {len(CONTROLLERS) - len(MAIN_LAWS)} more in docs/control")
