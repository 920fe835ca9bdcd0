"""The cable at rest as a motion finds it: tension and slope of every segment, what holds the drive pulley."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.mesh_forces import gradients
from cabledrive.mechanics.statics import equilibrium
from cabledrive.parameters import Drive

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StaticState:
    """Static equilibrium of a drive whose drive pulley is held.

    Attributes
    ----------
    mesh : Mesh
    tension, stretch : ndarray, shape (segments of all spans,)
        Tension of each segment [N], and its length over that of the straight pretensioned one [-].
    slope : ndarray, shape (segments of all spans,)
        Slope of each segment against the straight span in the plane of the loop, the sag's [-].
    holding_torque : float
        Torque on the drive pulley that keeps it at rest [N m].
    """

    mesh: Mesh
    tension: Array
    stretch: Array
    slope: Array
    holding_torque: float

    @property
    def steepest(self) -> float:
        """Largest slope [-]."""
        return float(np.max(np.abs(self.slope)))


def static_state(drive: Drive, *, load_torque: float = 0.0, segments: int = 120) -> StaticState:
    """Where the cable rests under gravity, carriages and a steady torque on the load pulley.

    Parameters
    ----------
    drive : Drive
    load_torque : float, default 0.0
        Steady torque on the load pulley [N m]; positive pulls the upper span.
    segments : int, default 120
        Per span.

    Returns
    -------
    StaticState

    Raises
    ------
    NotComputed
        If no equilibrium is found, or a piece of the cable hangs slack.
    """
    mesh, law = mesh_of(drive, segments), cable_law(drive.cable, "exact")
    if load_torque:
        weight = mesh.weight_u.copy()
        weight[mesh.segments] += load_torque / drive.load_pulley.radius
        mesh = replace(mesh, weight_u=weight)
    found = equilibrium(mesh, law, hold="drive")
    u_x, v_x, w_x = gradients(mesh, found.displacement)
    return StaticState(
        mesh=mesh,
        tension=law.tension(u_x, v_x, w_x),
        stretch=np.hypot(1.0 + u_x, w_x),
        slope=w_x / (1.0 + u_x),
        holding_torque=found.holding_torque[0],
    )
