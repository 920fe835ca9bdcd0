"""Machines with routes: coordinates, tensions at rest, and the network of spans, springs and masses."""

from cabledrive.mechanics.network.assembly import Network, network_of
from cabledrive.mechanics.network.response import responses
from cabledrive.mechanics.network.statics import Statics, statics_of

__all__ = ["Network", "Statics", "network_of", "responses", "statics_of"]
