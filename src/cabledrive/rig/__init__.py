"""The drive as a laboratory sees it: sampled, counted, delayed, limited, with friction that sticks."""

from cabledrive.rig.carriage import CarriageMove, CarriageRun, move_carriage
from cabledrive.rig.closed_loop.own_plant import OwnPlant
from cabledrive.rig.front_door import track
from cabledrive.rig.setting import BodyMotion, Disturbance, Motion, Payload, RigOptions
from cabledrive.rig.tracking import Tracking

__all__ = [
    "BodyMotion",
    "CarriageMove",
    "CarriageRun",
    "Disturbance",
    "Motion",
    "OwnPlant",
    "Payload",
    "RigOptions",
    "Tracking",
    "move_carriage",
    "track",
]
