"""From logs to parameters with intervals: logs, excitation, regression, responses, cameras, tensions.

What are inertia and friction, how stiff is the cable, what is its tension, and how sure is each number?
Begin with `read_log` and `identify`; `plan_test` predicts the standard errors of a test.
"""

from typing import TYPE_CHECKING

from cabledrive.parameters.on_demand import on_demand

if TYPE_CHECKING:
    from cabledrive.identification.amplifier import identify_amplifier
    from cabledrive.identification.camera.clip import open_clip
    from cabledrive.identification.camera.marker import marker_log, track_marker
    from cabledrive.identification.log_response import response
    from cabledrive.identification.logs.log import log_of
    from cabledrive.identification.logs.reading import read_log
    from cabledrive.identification.one_log import IdentifyOptions, identify
    from cabledrive.identification.planning import plan_test
    from cabledrive.identification.printer import shaper
    from cabledrive.identification.recipe import published_recipe
    from cabledrive.identification.response_models import choose_model
    from cabledrive.identification.tension.load_cell import tensions_from_load_cell
    from cabledrive.identification.tension.recording import read_ping
    from cabledrive.identification.tension.strings import tension_from_ping

__getattr__ = on_demand(
    __name__,
    {
        "IdentifyOptions": "one_log",
        "choose_model": "response_models",
        "identify": "one_log",
        "identify_amplifier": "amplifier",
        "log_of": "logs.log",
        "marker_log": "camera.marker",
        "open_clip": "camera.clip",
        "plan_test": "planning",
        "published_recipe": "recipe",
        "read_log": "logs.reading",
        "read_ping": "tension.recording",
        "response": "log_response",
        "shaper": "printer",
        "tension_from_ping": "tension.strings",
        "tensions_from_load_cell": "tension.load_cell",
        "track_marker": "camera.marker",
    },
)

__all__ = [
    "IdentifyOptions",
    "choose_model",
    "identify",
    "identify_amplifier",
    "log_of",
    "marker_log",
    "open_clip",
    "plan_test",
    "published_recipe",
    "read_log",
    "read_ping",
    "response",
    "shaper",
    "tension_from_ping",
    "tensions_from_load_cell",
    "track_marker",
]
