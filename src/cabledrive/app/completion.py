"""What the shell is offered where a drive or a control law is named."""

import click
from click.shell_completion import CompletionItem

from cabledrive.parameters import packaged_drives


def complete_drive(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of packaged drives, then files, for the shell.

    Parameters
    ----------
    ctx : click.Context
    param : click.Parameter
    incomplete : str
        What has been typed.

    Returns
    -------
    list of CompletionItem
    """
    names = [CompletionItem(name) for name in packaged_drives() if name.startswith(incomplete)]
    return [*names, CompletionItem(incomplete, type="file")]


def complete_controller(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of control laws, for the shell.

    Parameters
    ----------
    ctx : click.Context
    param : click.Parameter
    incomplete : str
        What has been typed.

    Returns
    -------
    list of CompletionItem
    """
    from cabledrive.rig.laws.registry import CONTROLLERS

    return [CompletionItem(name) for name in sorted(CONTROLLERS) if name.startswith(incomplete)]
