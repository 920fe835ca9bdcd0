"""A loop with another plant, such as a drawn one."""

from dataclasses import replace

import numpy as np

from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.cable_plant import cable_plant, drive_like
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_plants import plant_parts
from cabledrive.rig.setting import RigOptions


def with_plant(loop: Loop, chain: LumpedChain, options: RigOptions) -> Loop:
    """The same law and filter on another row of inertias, or on the distributed cable like it.

    Parameters
    ----------
    loop : Loop
    chain : LumpedChain
        At the first shaft.
    options : RigOptions

    Returns
    -------
    Loop
    """
    interval, rate = loop.rig.interval, float(loop.plant.scalars[6])
    slack = loop.slack
    if np.isfinite(slack):
        slack *= loop.chain.stiffness[-1] / chain.stiffness[-1]
    parts = plant_parts(chain, interval, rate, options, 2.0 * loop.kinks.play, slack)
    cable = loop.cable
    if cable is not None:
        cable = cable_plant(drive_like(cable.drive, chain), chain, interval, options, measured=False)
    return replace(loop, cable=cable, **parts)
