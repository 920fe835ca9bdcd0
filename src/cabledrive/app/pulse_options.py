"""Options of the pulses that a command follows: angle, rise and dwell, each with a unit."""

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
