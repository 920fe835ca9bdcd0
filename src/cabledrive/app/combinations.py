"""Options that have no effect beside others, and those of every command that reads a log."""

import functools
from collections.abc import Callable, Iterator
from typing import Any

import click
from click.core import ParameterSource

from cabledrive.app.failures import note
from cabledrive.app.options import Declared, OptionOf, option
from cabledrive.parameters import InputRefused


def refuse_given(*names: str, why: str) -> None:
    """Refuse the first of options on the command line that have no effect here, with why and the remedy."""
    for given in _given(names):
        raise InputRefused(f"{given} {why}")


def refuse_not_of(kind: str, why: str) -> None:
    """Refuse the options that are not declared for a kind of input; ``why``: as of `refuse_given`."""
    for own in click.get_current_context().command.params:
        if isinstance(own, OptionOf) and kind not in own.of:
            refuse_given(own.name or "", why=why)


def tell_given(*names: str, why: str) -> None:
    """Say why options that were given have no effect here."""
    for given in _given(names):
        note(f"{given} {why}")


def _given(names: tuple[str, ...]) -> Iterator[str]:
    """The options among these parameters that stand on the command line."""
    context = click.get_current_context()
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in names and source is ParameterSource.COMMANDLINE:
            yield max(parameter.opts, key=len)


Chooser = Callable[[Any], Any]
"""From the `ColumnMap` of a configuration to that of the command line."""


EVERY_LOG = ("log", "axis", "ping", "split")


def reading_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command, which takes a `Chooser`, the options ``--column``, ``--skip-rows``, ``--resample``."""

    @option(
        "--column columns",
        "CHANNEL=COLUMN:UNIT",
        "Which column is a channel, as torque=tau:N mm; repeatable.",
        of=EVERY_LOG,
        multiple=True,
    )
    @option(
        "--skip-rows",
        click.IntRange(0),
        "Lines at the top of a text log to skip; default: metadata is recognised.",
        of=EVERY_LOG,
        metavar="N",
    )
    @option("--resample", "flag", "Put uneven samples, or several topics, onto one even grid.", of=EVERY_LOG)
    @functools.wraps(function)
    def _reading(*, columns: tuple[str, ...], skip_rows: int | None, resample: bool, **options: Any) -> Any:
        def choose(base: Any) -> Any:
            from cabledrive.identification.logs.log import with_choices

            return with_choices(base, columns, skip_rows=skip_rows, resample=resample)

        return function(choose=choose, **options)

    return _reading


HOW_READ: Any = Declared(lambda name: reading_options)
"""The default of the parameter that takes the `Chooser`."""
