"""Control laws as pure steps over frozen gains; nothing here knows a simulation."""

from cabledrive.control.own_controller import ControllerProtocol, OwnController

__all__ = ["ControllerProtocol", "OwnController"]
