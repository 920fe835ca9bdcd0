"""From logs to parameters with intervals: logs, excitation, regression, responses, cameras, tensions."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cabledrive.identification.amplifier import identify_amplifier
    from cabledrive.identification.camera import marker_log, open_clip, track_marker
    from cabledrive.identification.log_response import response
    from cabledrive.identification.logs.reading import read_log
    from cabledrive.identification.one_log import identify
    from cabledrive.identification.planning import plan_test
    from cabledrive.identification.printer_shaper import shaper
    from cabledrive.identification.tension import read_ping, tension_from_ping, tensions_from_load_cell

# Loaded when first asked for: each brings libraries of its own.
_ON_DEMAND = {
    "identify": "one_log",
    "identify_amplifier": "amplifier",
    "marker_log": "camera",
    "open_clip": "camera",
    "plan_test": "planning",
    "read_log": "logs.reading",
    "read_ping": "tension",
    "response": "log_response",
    "shaper": "printer_shaper",
    "tension_from_ping": "tension",
    "tensions_from_load_cell": "tension",
    "track_marker": "camera",
}

__all__ = [
    "identify",
    "identify_amplifier",
    "marker_log",
    "open_clip",
    "plan_test",
    "read_log",
    "read_ping",
    "response",
    "shaper",
    "tension_from_ping",
    "tensions_from_load_cell",
    "track_marker",
]


def __getattr__(name: str) -> Any:
    if name in _ON_DEMAND:
        return getattr(import_module(f"{__name__}.{_ON_DEMAND[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
