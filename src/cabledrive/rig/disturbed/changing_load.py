"""A run whose load changes, with a law that is told of it or not."""

from dataclasses import replace

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.disturbed.disturbances_file import Disturbances
from cabledrive.rig.disturbed.disturbed_plants import ANNOUNCED, disturbed_numbers
from cabledrive.rig.laws.scheduled import NAME
from cabledrive.rig.setting import Motion, RigOptions


def loop_with_loads(loop: Loop, motion: Motion, options: RigOptions) -> Loop:
    """A loop whose plant's load changes as the options say.

    Raises `InputRefused` if a load is announced to a law that takes none or after the end of the run, changes
    after it, or the plant is no lumped chain.
    """
    if motion.payload and loop.controller.schedule is None:
        raise InputRefused(
            f"payload = {motion.payload[0].factor:.4g} is announced, and {loop.controller.name} takes no "
            f"announcement: take {NAME}, or leave payload out"
        )
    end = (len(loop.controller.reference) - 1) * loop.rig.interval
    for one in motion.payload:
        if one.start > end:
            raise InputRefused(
                f"payload from {one.start:.4g} s on: the run ends at {end:.4g} s: name a time in it"
            )
    if options.load_change is None:
        return loop
    if options.load_change[0] > end:
        raise InputRefused(
            f"load_change at {options.load_change[0]:.4g} s: the run ends at {end:.4g} s: name a time in it"
        )
    if options.load_change[1] == 1.0:
        return loop  # no change: the plant's own kernel, of another order than that of a changing load
    if loop.cable is not None or loop.own_plant is not None:
        raise InputRefused("load_change is of a lumped chain: leave the plant or --load-change out")
    none = Disturbances()
    names = [name for name in Disturbances.__dataclass_fields__ if name not in ANNOUNCED]
    drawn = {name: getattr(none, name)[0] for name in names}
    drawn["load_time"], drawn["load_factor"] = options.load_change
    return replace(loop, disturbed=disturbed_numbers(loop, loop.chain, drawn, np.zeros(3)))
