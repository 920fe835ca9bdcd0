"""Options of a load that changes while the machine runs, and of its announcement to the law."""

from collections.abc import Callable
from typing import Any

import click


def payload_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--payload`, `--payload-range` and `--load-change` to a command that takes them by these names."""
    for option in (  # the last one added stands first in the help
        click.option(
            "--load-change", metavar="FACTOR:START", help="The plant's load from a time on, as 3:0.7s."
        ),
        click.option(
            "--payload-range",
            metavar="LOW:HIGH",
            help="Loads that lqi-scheduled is designed for; default: 0.5:3 times the drive's.",
        ),
        click.option(
            "--payload",
            "payloads",
            multiple=True,
            metavar="FACTOR:START",
            help="Load announced to lqi-scheduled (gain scheduling), as 3:0.7s; repeatable.",
        ),
    ):
        function = option(function)
    return function
