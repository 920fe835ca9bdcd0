"""Machines with routes in time: every span divided as that of a loop, bodies and pulleys between them."""

from cabledrive.simulation.network.case import NetworkStart
from cabledrive.simulation.result import NetworkResult

__all__ = ["NetworkResult", "NetworkStart"]
