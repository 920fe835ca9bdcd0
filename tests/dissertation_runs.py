"""`track` as the dissertation runs it: its gains and its pulse of order 9, unless a test gives others."""

from dataclasses import replace
from typing import Any

from cabledrive.parameters import Drive
from cabledrive.rig import Motion
from cabledrive.rig import track as track_anew
from cabledrive.rig.setting import DISSERTATION_ORDER
from cabledrive.rig.tracking import Tracking


def track(
    drive: Drive, *, motion: Motion | None = None, gains: str = "dissertation", **choices: Any
) -> Tracking:
    """Run a law with the gains and the pulse of the dissertation."""
    motion = motion or Motion()
    if motion.order is None:
        motion = replace(motion, order=DISSERTATION_ORDER)
    return track_anew(drive, motion=motion, gains=gains, **choices)
