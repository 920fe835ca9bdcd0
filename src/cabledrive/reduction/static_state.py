"""The cable at rest as a motion finds it: tension and slope of every segment, what holds the drive pulley."""

from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.rest import rest_state
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StaticState:
    """Static equilibrium of a drive whose drive pulley is held."""

    mesh: Mesh
    tension: Array  # (segments of all spans,): of each segment [N]
    stretch: Array  # (segments of all spans,): its length over the straight pretensioned one [-]
    slope: Array  # (segments of all spans,): against the straight span in the loop's plane, by sag [-]
    holding_torque: float  # torque on the drive pulley that keeps it at rest [N m]

    @property
    def steepest(self) -> float:
        """Largest slope [-]."""
        return float(np.max(np.abs(self.slope)))


def static_state(drive: Drive, *, load_torque: float = 0.0, segments: int = 120) -> StaticState:
    """Where the cable rests under gravity, carriages and a steady torque on the load pulley [N m].

    A positive torque pulls the upper span. `NotComputed`: no equilibrium, or a piece of cable hangs slack.
    """
    at_torque = -load_torque * drive.drive_pulley.radius / drive.load_pulley.radius
    rest, mesh = rest_state(drive, at_torque=at_torque), mesh_of(drive, segments)
    if rest.lowest_tension <= 0.0:
        raise NotComputed(
            f"a span hangs slack at rest (lowest tension {rest.lowest_tension:.4g} N): raise cable.pretension"
        )
    tension, slope = np.empty(mesh.spacing.size), np.empty(mesh.spacing.size)
    unstretched = 1.0 + drive.cable.prestrain
    for number, span in enumerate(mesh.spans):
        middle = 0.5 * (mesh.position[number, 1:] + mesh.position[number, :-1]) / unstretched
        for piece in rest.stretches:
            inside = np.flatnonzero((middle > piece.start) & (middle < piece.end))
            if piece.span == span:
                along, across = piece.force_at(middle[inside])
                tension[number * mesh.segments + inside] = piece.tension_at(middle[inside])
                slope[number * mesh.segments + inside] = across / along
    return StaticState(
        mesh=mesh,
        tension=tension,
        stretch=(1.0 + tension / drive.cable.axial_rigidity) / unstretched,
        slope=slope,
        holding_torque=rest.holding_torque,
    )
