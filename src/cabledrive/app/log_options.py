"""Options of every command that reads a log: which columns, how many lines to skip, whether to resample."""

import functools
from collections.abc import Callable
from typing import Any

import click

from cabledrive.app.combinations import OptionOf

Chooser = Callable[[Any], Any]
"""From the `ColumnMap` of a configuration to that of the command line."""


def reading_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command, which takes a `Chooser`, the options ``--column``, ``--skip-rows``, ``--resample``."""

    @click.option(
        "--column",
        "columns",
        cls=OptionOf,
        of=("log",),
        multiple=True,
        metavar="CHANNEL=COLUMN:UNIT",
        help="Which column is a channel, as torque=tau:N mm; repeatable.",
    )
    @click.option(
        "--skip-rows",
        cls=OptionOf,
        of=("log",),
        type=click.IntRange(0),
        metavar="N",
        help="Lines at the top of a text log to skip; default: metadata is recognised.",
    )
    @click.option(
        "--resample",
        cls=OptionOf,
        of=("log",),
        is_flag=True,
        help="Put uneven samples, or several topics, onto one even grid.",
    )
    @functools.wraps(function)
    def _reading(*, columns: tuple[str, ...], skip_rows: int | None, resample: bool, **options: Any) -> Any:
        def choose(base: Any) -> Any:
            from cabledrive.identification.logs.column_map import with_choices

            return with_choices(base, columns, skip_rows=skip_rows, resample=resample)

        return function(choose=choose, **options)

    return _reading
