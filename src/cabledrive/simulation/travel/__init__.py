"""Machines with routes whose bodies travel: hoisting, winches, heads over their bed."""

from cabledrive.simulation.travel.case import PlannedMove

__all__ = ["PlannedMove"]
