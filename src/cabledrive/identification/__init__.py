"""From logs to parameters with intervals: logs, excitation, regression, responses, cameras, tensions.

What are inertia and friction, how stiff is the cable, what is its tension, and how sure is each number?
Begin with `read_log` and `identify`.
"""

from typing import TYPE_CHECKING

from cabledrive.parameters.on_demand import on_demand

if TYPE_CHECKING:
    from cabledrive.identification.axis.answer import IdentifyOptions
    from cabledrive.identification.log_response import response
    from cabledrive.identification.logs.reading import read_log
    from cabledrive.identification.one_log import identify
    from cabledrive.identification.printer import shaper
    from cabledrive.identification.response_models import choose_model
    from cabledrive.identification.tension.both import tensions_from_load_cell

__getattr__ = on_demand(
    __name__,
    {
        "IdentifyOptions": "axis.answer",
        "choose_model": "response_models",
        "identify": "one_log",
        "read_log": "logs.reading",
        "response": "log_response",
        "shaper": "printer",
        "tensions_from_load_cell": "tension.both",
    },
)

__all__ = [
    "IdentifyOptions",
    "choose_model",
    "identify",
    "read_log",
    "response",
    "shaper",
    "tensions_from_load_cell",
]
