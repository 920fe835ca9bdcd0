r"""A cable transporter in few coordinates: drive pulley, carriage, load pulley and a mass that hangs below.

Displacements are those of the cable at each body: :math:`q_1 = r\theta_1`, the carriage's :math:`s`,
:math:`q_2 = r\theta_2`, the hanging mass's :math:`y`. With the carriage at x the three strands have stiffness
:math:`EA/x`, :math:`EA/(L - x)` and :math:`EA/L`, so that modes change along the way.
"""

from typing import NamedTuple

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import first_order, frequencies_of

BODIES = 4
SWING_RATIO = 0.005
"""Damping ratio of the swing where none is known."""


class Transporter(NamedTuple):
    """A loop with a carriage on its upper span, and a mass on a line below the carriage."""

    span_length: float  # L [m]
    axial_rigidity: float  # EA [N]
    pretension: float  # [N]
    damping_time: float  # damping over stiffness of the cable, T [s]
    radius: float  # of the drive pulley [m]
    drive_mass: float  # inertia of motor with drive pulley over its radius squared [kg]
    load_mass: float  # inertia of the load pulley over its radius squared [kg]
    carriage_mass: float  # [kg]
    payload_mass: float  # [kg]
    line_length: float  # of the line on which the payload hangs [m]
    gravity: float  # [m/s^2]
    rail_friction: float  # of the carriage on its guide [N s/m]
    swing_damping: float  # damping of the swing over its stiffness [s]
    viscous: float  # friction of the motor, at the rim [N s/m]
    coulomb: float  # friction of the motor, at the rim [N]
    offset: float  # constant force of the motor, at the rim [N]
    start: float  # carriage's place at the start, from the drive pulley [m]

    @property
    def masses(self) -> Array:
        """Of drive pulley, carriage, load pulley, payload [kg], shape (4,)."""
        return np.array([self.drive_mass, self.carriage_mass, self.load_mass, self.payload_mass])


def transporter_of(
    drive: Drive, *, payload_mass: float, line_length: float, rail_friction: float = 0.5
) -> Transporter:
    """The transporter that a drive with one carriage on its upper span is.

    ``drive``: a loop with motor, rigid joint, pulleys of one radius and one guided carriage;
    ``payload_mass``: of the mass that hangs below the carriage [kg]; ``line_length``: on which it hangs [m];
    ``rail_friction`` [N s/m]; the swing has the damping ratio `SWING_RATIO`.
    Raises `InputRefused` if the drive is another kind of machine, or a mass or length is not positive.
    """
    if not drive.closed or len(drive.carriage) != 1 or drive.carriage[0].span != "upper":
        said = f"drive {drive.name!r} is no loop with one carriage on its upper span"
        raise InputRefused(f"{said}: give one, such as dissertation-transporter")
    if drive.motor is None:
        raise InputRefused("motor is missing, and the carriage is to be moved: add motor.inertia")
    if min(payload_mass, line_length) <= 0.0:
        raise InputRefused(
            f"payload_mass = {payload_mass:.4g} kg and line_length = {line_length:.4g} m must be above 0"
        )
    motor, (first, second) = drive.motor, drive.pulley
    carriage, r = drive.carriage[0], first.radius
    rigidity = drive.cable.axial_rigidity
    return Transporter(
        span_length=drive.span_length,
        axial_rigidity=rigidity,
        pretension=drive.cable.pretension,
        damping_time=drive.cable.axial_damping / rigidity,
        radius=r,
        drive_mass=(motor.inertia + first.inertia) / r**2,
        load_mass=second.inertia / second.radius**2,
        carriage_mass=carriage.mass,
        payload_mass=payload_mass,
        line_length=line_length,
        gravity=drive.layout.gravity,
        rail_friction=rail_friction,
        swing_damping=2.0 * SWING_RATIO * (line_length / drive.layout.gravity) ** 0.5,
        viscous=(motor.viscous_friction + first.viscous_friction) / r**2,
        coulomb=(motor.coulomb_friction + first.coulomb_friction) / r,
        offset=motor.offset_torque / r,
        start=carriage.position,
    )


def strand_stiffness(transporter: Transporter, position: float) -> tuple[float, float, float]:
    """Stiffness [N/m] drive pulley to carriage at a position [m], carriage to load pulley, and back.

    A carriage that is not between the pulleys is refused.
    """
    t = transporter
    if not 0.0 < position < t.span_length:
        said = f"position = {position:.4g} m is not within 0 and {t.span_length:.4g} m, the span's length"
        raise InputRefused(f"{said}: keep the carriage between the pulleys")
    return (
        t.axial_rigidity / position,
        t.axial_rigidity / (t.span_length - position),
        t.axial_rigidity / t.span_length,
    )


def compliance(transporter: Transporter, position: Array) -> tuple[Array, Array, Array]:
    r"""Compliance between motor and carriage, and its first two derivatives by position, Eq. (T.3).

    .. math:: c(x) = \frac{x(2L - x)}{2L\,EA}

    ``position``: x [m].
    Returns [m/N], [1/N], [1/(N m)].
    """
    t = transporter
    unit = 1.0 / (t.span_length * t.axial_rigidity)
    x = np.asarray(position, dtype=np.float64)
    return 0.5 * x * (2.0 * t.span_length - x) * unit, (t.span_length - x) * unit, np.full_like(x, -unit)


def stiffness_and_damping(transporter: Transporter, position: float) -> tuple[Array, Array]:
    """Stiffness [N/m] and damping [N s/m] matrices, shape (4, 4), frozen at a position [m], Eq. (T.1)."""
    t = transporter
    cable, swing = np.zeros((BODIES, BODIES)), np.zeros((BODIES, BODIES))
    for k, (i, j) in zip(strand_stiffness(t, position), ((0, 1), (1, 2), (2, 0)), strict=True):
        pull = np.zeros(BODIES)
        pull[i], pull[j] = 1.0, -1.0
        cable += k * np.outer(pull, pull)
    hang = np.array([0.0, 1.0, 0.0, -1.0])
    swing += t.payload_mass * t.gravity / t.line_length * np.outer(hang, hang)  # of small angles
    friction = np.diag([t.viscous, t.rail_friction, 0.0, 0.0])
    return cable + swing, t.damping_time * cable + t.swing_damping * swing + friction


def frozen_state_space(transporter: Transporter, position: float) -> tuple[Array, Array]:
    """State space, (8, 8) and (8, 4), of displacements, then speeds, frozen at a position [m]."""
    return first_order(*stiffness_and_damping(transporter, position), transporter.masses)


def frozen_frequencies(transporter: Transporter, position: float) -> Array:
    """Undamped frequencies at a position [m] [rad/s]: swing, carriage on the cable, load pulley."""
    return held_frequencies(transporter, position, first=0)[1:]


def held_frequencies(transporter: Transporter, position: float, *, first: int = 1) -> Array:
    """Those with the motor held; of the bodies from ``first`` on."""
    stiffness, _ = stiffness_and_damping(transporter, position)
    return frequencies_of(stiffness[first:, first:], transporter.masses[first:])
