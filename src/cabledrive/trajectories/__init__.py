"""Reference motions, smooth to a stated order, with every derivative a control law asks for."""

from cabledrive.trajectories.limits import MoveLimits, move_limits, peak_demand, shortest_rise
from cabledrive.trajectories.rise import derivative_jump, peak_factor, rise_coefficients, smooth_rise
from cabledrive.trajectories.segments import Move, Trajectory, pulse, waypoints

__all__ = [
    "Move",
    "MoveLimits",
    "Trajectory",
    "derivative_jump",
    "move_limits",
    "peak_demand",
    "peak_factor",
    "pulse",
    "rise_coefficients",
    "shortest_rise",
    "smooth_rise",
    "waypoints",
]
