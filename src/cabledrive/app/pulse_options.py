"""Options of the pulses that a command follows, and of a load that changes meanwhile."""

from collections.abc import Callable
from typing import Any

from cabledrive.app.options import ANGLE, option


def pulse_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--angle`, `--rise` and `--dwell` to a command that takes them by these names [deg, s, s]."""
    for add in (  # the last one added stands first in the help
        option("--dwell", "s", "Rest after a move.", 0.5),
        option("--rise", "s", "Rise time.", 0.5),
        option("--angle", ANGLE, "Of each pulse.", 45.0, metavar="DEG"),
    ):
        function = add(function)
    return function


def payload_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add `--payload`, `--payload-range` and `--load-change` to a command that takes them by these names."""
    for add in (  # the last one added stands first in the help
        option("--load-change", "FACTOR:START", "The plant's load from a time on, as 3:0.7s."),
        option(
            "--payload-range",
            "LOW:HIGH",
            "Loads that lqi-scheduled is designed for; default: 0.5:3 times the drive's.",
        ),
        option(
            "--payload payloads",
            "FACTOR:START",
            "Load announced to lqi-scheduled (gain scheduling), as 3:0.7s; repeatable.",
            multiple=True,
        ),
    ):
        function = add(function)
    return function
