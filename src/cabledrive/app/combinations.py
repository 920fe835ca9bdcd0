"""Options that have no effect beside others: refused or reported, never ignored."""

from collections.abc import Iterator
from typing import Any

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


class OptionOf(click.Option):
    """An option that says of which kinds of input it is; `refuse_not_of` refuses it with others.

    ``of`` names the kinds by the words of the command.
    """

    def __init__(self, *args: Any, of: tuple[str, ...], **options: Any) -> None:
        super().__init__(*args, **options)
        self.of = of


def refuse_not_of(kind: str, why: str) -> None:
    """Refuse the options that are not declared for a kind of input; ``why``: as of `refuse_given`."""
    for option in click.get_current_context().command.params:
        if isinstance(option, OptionOf) and kind not in option.of:
            refuse_given(option.name or "", why=why)


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
