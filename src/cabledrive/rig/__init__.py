"""The drive as a laboratory sees it: sampled, counted, delayed, limited, with friction that sticks."""

from cabledrive.rig.setting import Disturbance, Motion, RigOptions
from cabledrive.rig.tracking import Tracking
from cabledrive.rig.trial import track

__all__ = ["Disturbance", "Motion", "RigOptions", "Tracking", "track"]
