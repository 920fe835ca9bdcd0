"""A loop with another plant, such as a drawn one."""

from dataclasses import replace

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.cable_plant import cable_plant, drive_like
from cabledrive.rig.closed_loop.loop import Loop, lumped_plant
from cabledrive.rig.setting import RigOptions


def with_plant(loop: Loop, chain: LumpedChain, options: RigOptions, play: float | None = None) -> Loop:
    """The same law and filter on another lumped chain, or on the distributed cable like it.

    ``chain``: at the first shaft; ``play``: backlash of the first link [rad]; default: that of the loop. The
    distributed cable has none.
    Raises `InputRefused` if the plant is the user's own.
    """
    check_drawable(loop)
    interval, rate = loop.rig.interval, loop.plant.current_rate
    slack = loop.slack
    if np.isfinite(slack):
        slack *= loop.chain.stiffness[-1] / chain.stiffness[-1]
    play = loop.backlash if play is None else play
    plant = lumped_plant(chain, interval, rate, options, play, slack, loop.controller.field)
    cable = loop.cable
    if cable is not None:
        cable = cable_plant(drive_like(cable.drive, chain), chain, interval, options, measured=False)
    return replace(loop, cable=cable, chain=chain, plant=plant, slack=slack)


def check_drawable(loop: Loop) -> None:
    """Refuse to vary a plant whose parameters are not known.

    Raises `InputRefused` if the plant is the user's own, or was drawn with disturbances.
    """
    if loop.own_plant is not None:
        raise InputRefused(
            f'plant "{loop.own_plant.name}" is your own, and its parameters are not known: draws take the '
            "drive's models, lumped chains and the cable"
        )
    if loop.disturbed:
        raise InputRefused("the plant carries disturbances already: draw from the loop without them")
