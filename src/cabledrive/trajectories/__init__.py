"""Reference motions, smooth to a stated order, with every derivative a control law asks for."""

from cabledrive.trajectories.input_shaping import (
    InputShaper,
    highest_acceleration,
    input_shaper,
    residual_vibration,
    smoothing,
)
from cabledrive.trajectories.limits import (
    MoveLimits,
    derivative_jump,
    move_limits,
    peak_demand,
    peak_factor,
    rise_coefficients,
    shortest_rise,
    smooth_rise,
)
from cabledrive.trajectories.segments import Move, Trajectory, pulse, waypoints

__all__ = [
    "InputShaper",
    "Move",
    "MoveLimits",
    "Trajectory",
    "derivative_jump",
    "highest_acceleration",
    "input_shaper",
    "move_limits",
    "peak_demand",
    "peak_factor",
    "pulse",
    "residual_vibration",
    "rise_coefficients",
    "shortest_rise",
    "smooth_rise",
    "smoothing",
    "waypoints",
]
