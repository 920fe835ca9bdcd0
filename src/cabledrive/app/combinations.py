"""Options that have no effect beside others: refused or reported, never ignored."""

from collections.abc import Iterator
from typing import Any

import click
from click.core import ParameterSource

from cabledrive.app.messages import note
from cabledrive.parameters import InputRefused


def refuse_given(*names: str, why: str) -> None:
    """Refuse the first of options on the command line that have no effect here, with why and the remedy."""
    for option in _given(names):
        raise InputRefused(f"{option} {why}")


class OptionOf(click.Option):
    """An option with the kinds of input it is of, in the command's words; `refuse_not_of` refuses others."""

    def __init__(self, *args: Any, of: tuple[str, ...], **options: Any) -> None:
        super().__init__(*args, **options)
        self.of = of


def refuse_not_of(kind: str, why: str) -> None:
    """Refuse the options that are not declared for a kind of input; ``why``: as of `refuse_given`."""
    for option in click.get_current_context().command.params:
        if isinstance(option, OptionOf) and kind not in option.of:
            refuse_given(option.name or "", why=why)


def tell_given(*names: str, why: str) -> None:
    """Say why options that were given have no effect here."""
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
