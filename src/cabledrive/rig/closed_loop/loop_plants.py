"""The lumped chain that is the plant of a loop, with its backlash and slack."""

from typing import Any

from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.plant import piecewise_numbers, plant_numbers
from cabledrive.rig.setting import RigOptions

PIECEWISE_SUBSTEPS = 10


def plant_parts(
    chain: LumpedChain, interval: float, rate: float, options: RigOptions, play: float, slack: float
) -> dict[str, Any]:
    """What of a loop depends on the lumped chain that is the plant.

    ``interval``: sample time [s]; ``rate``: bandwidth of the torque loop [rad/s]; 0: none; ``play``:
    backlash of the joint [rad]; ``slack``: twist of the cable at which a span goes slack [rad].
    Returns fields of `Loop`. With backlash, or spans that may go slack, at least ten internal steps per
    sample.
    """
    limit = slack if options.forbid_slack else float("inf")
    softens = float("inf") if options.forbid_slack else slack
    nonlinear = play > 0.0 or softens < float("inf")
    substeps = max(options.substeps, PIECEWISE_SUBSTEPS) if nonlinear else options.substeps
    numbers = plant_numbers(
        chain, interval, current_rate=rate, substeps=substeps, smooth=options.smooth_friction
    )
    piecewise = piecewise_numbers(chain, interval / substeps, current_rate=rate, play=play, slack=softens)
    return {"plant": numbers, "chain": chain, "piecewise": piecewise, "twist_limit": limit, "slack": slack}
