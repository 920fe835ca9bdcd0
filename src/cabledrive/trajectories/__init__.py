"""Reference motions, smooth to a stated order, with every derivative a control law asks for."""

from cabledrive.trajectories.input_shaping import (
    InputShaper,
    highest_acceleration,
    input_shaper,
    residual_vibration,
    smoothing,
)
from cabledrive.trajectories.limits import MoveLimits, move_limits, shortest_rise
from cabledrive.trajectories.segments import Move, Trajectory, pulse, waypoints

__all__ = [
    "InputShaper",
    "Move",
    "MoveLimits",
    "Trajectory",
    "highest_acceleration",
    "input_shaper",
    "move_limits",
    "pulse",
    "residual_vibration",
    "shortest_rise",
    "smoothing",
    "waypoints",
]
