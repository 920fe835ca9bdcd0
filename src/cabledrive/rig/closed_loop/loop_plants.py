"""The lumped chain that is the plant of a loop, with its backlash and slack."""

from typing import Any

import numpy as np

from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.disturbed_kernels import UNDISTURBED, DisturbedNumbers
from cabledrive.rig.closed_loop.plant import piecewise_numbers, plant_numbers
from cabledrive.rig.setting import RigOptions

PIECEWISE_SUBSTEPS = 10
STEP = 20e-6
"""Longest internal step of a plant with disturbances [s]; 0.01 deg at 4 rad/s is forty of them."""


def plant_parts(
    chain: LumpedChain,
    interval: float,
    rate: float,
    options: RigOptions,
    play: float,
    slack: float,
    field: tuple[float, float] | None = None,
) -> dict[str, Any]:
    """What of a loop depends on the lumped chain that is the plant.

    ``interval``: sample time [s]; ``rate``: bandwidth of the torque loop [rad/s]; 0: none; ``play``:
    backlash of the joint [rad]; ``slack``: twist of the cable at which a span goes slack [rad]; ``field``: of
    a stepper, see `Controller`.
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
    disturbed = None if field is None else plain_numbers(chain, rate, piecewise.play, slack, field)
    return {
        "plant": numbers,
        "chain": chain,
        "piecewise": piecewise,
        "twist_limit": limit,
        "slack": slack,
        "disturbed": disturbed,
    }


def plain_numbers(
    chain: LumpedChain, rate: float, play: float, slack: float, field: tuple[float, float] | None
) -> DisturbedNumbers:
    """A chain for the kernel of disturbed plants, without disturbances; ``play``: half the backlash [rad]."""
    torque, periods = field or (0.0, 0.0)
    return UNDISTURBED._replace(
        inertias=np.array(chain.inertias),
        viscous=np.array(chain.viscous),
        coulomb=np.array(chain.coulomb),
        offsets=np.array(chain.offsets),
        stiffness=np.array(chain.stiffness),
        damping=np.array(chain.damping),
        play=play,
        slack=slack,
        current_rate=rate,
        step=STEP,
        field=torque,
        field_periods=periods,
    )
