r"""The divided cable at rest under gravity and carriages.

Of N segments of equal unstretched length the one at the unstretched place s carries the force
:math:`\mathbf F(s)` of Eq. (N.10), since the weight of a node is the difference of its neighbours. So the
statics of `cabledrive.mechanics.network.statics` hold with a sum over the segments for the integral, and with
the gradients that the law of the cable gives under that force.
"""

from dataclasses import dataclass, fields, replace
from itertools import chain

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import taut_law
from cabledrive.mechanics.mesh import Mesh
from cabledrive.mechanics.network.motion import Motion
from cabledrive.mechanics.network.rest_forces import MOST_STEPS, RestingStretch, Ropes
from cabledrive.mechanics.network.statics import at_rest
from cabledrive.parameters.arrays import Integers
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.route.two_pulleys import NAMES, as_machine


def hanging_gradients(law: CableLaw, along: Array, across: Array) -> tuple[Array, Array]:
    """Gradients u', w' under which a law gives some forces, by Newton's method from the exact law."""
    tension = np.where(across == 0.0, along, np.hypot(along, across))
    strain = (tension - law.pretension) / law.stiffness
    cosine, sine = along / tension, across / tension
    u_x, w_x = strain * cosine - sine**2 / (1.0 + cosine), (1.0 + strain) * sine
    for _ in range(MOST_STEPS):
        x, _, z = law.excess_components(u_x, 0.0 * w_x, w_x)
        left = np.stack([along - law.pretension - x, across - z], axis=-1)
        if np.abs(left).max() <= 64.0 * np.finfo(float).eps * law.stiffness:
            return u_x, w_x
        slope = law.stiffness_matrix(u_x, 0.0 * w_x, w_x)[:, ::2, ::2]
        u_x, w_x = np.stack([u_x, w_x]) + np.linalg.solve(slope, left[..., None])[..., 0].T
    raise NotComputed(f"no equilibrium: the law {law.name} does not give {tension.min():.4g} N; take another")


def segment_forces(rest: RestingStretch, count: int) -> Array:
    """Force along and across in each of so many segments of a piece at rest, (2, count) [N]."""
    return rest.force_at(rest.start + rest.length * (np.arange(count) + 0.5) / count)


@dataclass(frozen=True, eq=False, kw_only=True)
class DividedRopes(Ropes):
    """Pieces of one cable in segments."""

    law: CableLaw
    count: Integers  # (p,): segments of each piece

    def reach(self, force: Array) -> tuple[Array, Array]:
        """As of `Ropes`."""
        left, gives = np.zeros_like(force), np.zeros((3, len(force)))
        longer = self.law.pretension / self.law.axial_rigidity
        for k, count in enumerate(self.count.tolist()):
            share = self.length[k] / count
            carried = force[k, :, None] - self.load[k, :, None] * share * (np.arange(count) + 0.5)
            u_x, w_x = hanging_gradients(self.law, *carried)
            left[k] = share * ((1.0 + longer) * u_x + longer).sum(), share * (1.0 + longer) * w_x.sum()
            slope = self.law.stiffness_matrix(u_x, 0.0 * w_x, w_x)[:, ::2, ::2]
            gives[:, k] = share * (1.0 + longer) * np.linalg.inv(slope).sum(axis=0)[[0, 0, 1], [0, 1, 1]]
        return left, gives

    def settled(self, tension: Array, shear: Array, share: float) -> "DividedRopes":
        """As they are: nodes at the ends stay where straight ropes leave their wheels."""
        return self


def equilibrium(
    drive: Drive, mesh: Mesh, law: CableLaw, *, hold: str = "none"
) -> tuple[Array, tuple[float, float]]:
    """Where cable and carriages rest: displacements from the straight cable, and what holds the pulleys.

    ``hold``, {"none", "drive", "both"}: pulleys held at angle zero. With "none" the drive pulley stays at
    zero because nothing turns it, which is checked; on a holding stiffness it turns until that balances the
    weights.
    Returns u, v, w, (3, nodes) [m], and torques on drive pulley and load pulley that keep them there [N m],
    that of a holding stiffness included; zero where a pulley is free.
    Raises `InputRefused` if `hold` is unknown, or both pulleys are free and the weight of carriages on a
    slope would turn them; `NotComputed` if no equilibrium is found, or a piece of a cable that cannot push
    hangs slack.
    """
    from scipy.optimize import newton

    if hold not in ("none", "drive", "both"):
        raise InputRefused(f'hold = "{hold}" is not one of its values: write "none", "drive" or "both"')
    rigid_load, radius = drive.load_pulley.fixed or hold == "both", drive.drive_pulley.radius
    held = replace(drive, pulley=(drive.drive_pulley, replace(drive.load_pulley, fixed=rigid_load)))
    machine, taut, closed = as_machine(held), taut_law(law), drive.kind == "loop"
    count = np.diff(np.unique([*mesh.nodes.ravel(), *mesh.carriages]))

    def divide(ropes: Ropes) -> DividedRopes:
        own = {field.name: getattr(ropes, field.name) for field in fields(ropes)}
        return DividedRopes(**own, law=taut, count=count)

    behind = 0.0 if closed else law.pretension

    def hung(torque: float | None) -> tuple[Array, float, float]:
        """Displacements from those of the drive pulley; pulls of the cable on both rims [N]."""
        motion, torques = Motion(machine, hold=NAMES[:1]), dict[int, float]()
        if torque is not None:
            motion, torques = Motion(machine), {0: radius * behind - torque}
        stretches, _ = at_rest(machine, motion, torques, divide)
        pieces = list(chain.from_iterable(stretches))
        if law.tension_only and min(piece.lowest_tension for piece in pieces) <= 0.0:
            raise NotComputed("no equilibrium: a piece of the cable hangs slack; raise cable.pretension")
        carried = np.hstack([segment_forces(*both) for both in zip(pieces, count.tolist(), strict=True)])
        x = np.zeros((3, mesh.size))
        x[::2, 1:] = np.cumsum(np.stack(hanging_gradients(taut, *carried)) * mesh.spacing, axis=1)
        x[2, ~mesh.sways] = 0.0
        last = stretches[-1]
        at_load, at_drive = (last[0].force[0], last[-1].end_force[0]) if closed else (behind, behind)
        return x, stretches[0][0].force[0] - at_drive, at_load - stretches[0][-1].end_force[0]

    spring = rotor_stiffness(drive) if hold == "none" else 0.0
    x, pull, load_pull = hung(None)
    loose = hold == "none" and not drive.drive_pulley.fixed and not rigid_load and spring == 0.0
    if loose and abs(pull) > 1e-9 * law.pretension:
        raise InputRefused(
            f"gravity turns the free pulleys: {-pull * radius:.4g} N m would hold them; hold the drive pulley"
        )
    if spring and rigid_load and abs(pull) > 1e-12 * law.pretension:  # it turns the pulley against the spring
        whole = pull
        try:
            pull *= newton(
                lambda s: s + spring * hung(-s * whole * radius)[0][0, mesh.nodes[0, 1]] / whole,
                1.0,
                x1=0.5,
                tol=1e-12,
            )
        except RuntimeError:
            raise NotComputed(
                "no equilibrium on the holding stiffness: raise it, or hold the drive pulley"
            ) from None
        x, _, load_pull = hung(-pull * radius)
    x[0] += pull / spring if spring else 0.0
    torque = -load_pull * drive.load_pulley.radius if rigid_load else 0.0
    return x, (0.0 if loose else -pull * radius, torque)


def rotor_stiffness(drive: Drive) -> float:
    """What holds the drive rim [N/m]: the holding stiffness in series with the motor's joint; 0: nothing."""
    motor = drive.motor
    if motor is None or not motor.holding_stiffness:
        return 0.0
    joint = 0.0 if motor.joint_stiffness is None else 1.0 / motor.joint_stiffness
    return 1.0 / (1.0 / motor.holding_stiffness + joint) / drive.drive_pulley.radius**2


def angles_of(drive: Drive, mesh: Mesh, x: Array) -> Array:
    """Angles of drive pulley, load pulley and motor that follow displacements of the rims, (3,) [rad]."""
    start, end = x[0, mesh.nodes[0]]
    return np.array([start, end, start]) / [own.radius for own in (*drive.pulley, drive.drive_pulley)]
