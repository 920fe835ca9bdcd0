"""Reference motions, smooth to a stated order, with every derivative a control law asks for."""

from cabledrive.trajectories.input_shaping import InputShaper, input_shaper, residual_vibration
from cabledrive.trajectories.limits import MoveLimits, move_limits, peak_demand, shortest_rise
from cabledrive.trajectories.rise import derivative_jump, peak_factor, rise_coefficients, smooth_rise
from cabledrive.trajectories.segments import Move, Trajectory, pulse, waypoints
from cabledrive.trajectories.shaped_corner import highest_acceleration, smoothing

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
