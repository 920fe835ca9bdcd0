"""Options that have no effect beside others: refused or reported, never ignored."""

from collections.abc import Iterator

import click
from click.core import ParameterSource

from cabledrive.app.messages import note
from cabledrive.parameters import InputRefused


def refuse_given(*names: str, why: str) -> None:
    """Refuse options that were given although they have no effect here.

    ``*names``: of the command's parameters; ``why``: what they lack, and the remedy: written behind the
    option.
    Raises `InputRefused` for the first of them that stands on the command line.
    """
    for option in _given(names):
        raise InputRefused(f"{option} {why}")


def tell_given(*names: str, why: str) -> None:
    """Say of options that were given that they have no effect here.

    ``*names``: of the command's parameters; ``why``: written behind the option.
    """
    for option in _given(names):
        note(f"{option} {why}")


def was_given(name: str) -> bool:
    """Whether a parameter stands on the command line."""
    return any(_given((name,)))


def _given(names: tuple[str, ...]) -> Iterator[str]:
    """The options among these parameters that stand on the command line."""
    context = click.get_current_context()
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in names and source is ParameterSource.COMMANDLINE:
            yield max(parameter.opts, key=len)
