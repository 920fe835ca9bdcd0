"""The drive as a laboratory sees it: sampled, counted, delayed, limited, with friction that sticks."""

from cabledrive.rig.bench.virtual_camera import VirtualCamera, filmed
from cabledrive.rig.carriage.carriage_move import CarriageMove, CarriageRun
from cabledrive.rig.carriage.transporter import move_carriage
from cabledrive.rig.closed_loop.own_plant import OwnPlant, PlantProtocol
from cabledrive.rig.setting import Disturbance, Motion, RigOptions
from cabledrive.rig.tracking import Tracking
from cabledrive.rig.trial import track

__all__ = [
    "CarriageMove",
    "CarriageRun",
    "Disturbance",
    "Motion",
    "OwnPlant",
    "PlantProtocol",
    "RigOptions",
    "Tracking",
    "VirtualCamera",
    "filmed",
    "move_carriage",
    "track",
]
