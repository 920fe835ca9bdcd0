"""Options of the pulses that a command follows, and of a load that changes meanwhile."""

from collections.abc import Callable
from typing import Any

import click

from cabledrive.app.options import ANGLE, DURATION


def pulse_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--angle`, `--rise` and `--dwell` to a command that takes them by these names [deg, s, s]."""
    for option in (  # the last one added stands first in the help
        click.option(
            "--dwell", type=DURATION, default=0.5, show_default=True, metavar="S", help="Rest after a move."
        ),
        click.option("--rise", type=DURATION, default=0.5, show_default=True, metavar="S", help="Rise time."),
        click.option(
            "--angle", type=ANGLE, default=45.0, show_default=True, metavar="DEG", help="Of each pulse."
        ),
    ):
        function = option(function)
    return function


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
