"""Runs with the dissertation's gains and its pulse of order 9, unless a test gives others; loops."""

from dataclasses import replace

import numpy as np

from cabledrive.rig import Motion, RigOptions
from cabledrive.rig import track as track_anew
from cabledrive.rig.closed_loop.loop import close_loop
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.setting import DISSERTATION_ORDER
from cabledrive.rig.tuning import design


def track(drive, *, motion=None, gains="dissertation", **choices):
    """Run a law with the gains and the pulse of the dissertation."""
    motion = motion or Motion()
    if motion.order is None:
        motion = replace(motion, order=DISSERTATION_ORDER)
    return track_anew(drive, motion=motion, gains=gains, **choices)


def loop_of(law, drive, motion, options=None, plant=None, **choices):
    """A loop around a law, given or designed by its name without a word of the rig's options."""
    made = design(law, DesignSpec(drive, motion, **choices)) if isinstance(law, str) else law
    spec = DesignSpec(drive, motion, options=options or RigOptions())
    return close_loop(spec, made, np.random.default_rng(0), plant)
