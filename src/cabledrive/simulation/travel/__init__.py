"""Machines with routes whose bodies travel: hoisting, winches, heads over their bed."""

from cabledrive.simulation.travel.case import PlannedMove
from cabledrive.simulation.travel.door import simulate_travel

__all__ = ["PlannedMove", "simulate_travel"]
