"""What turns and how it is held, and the two flexible modes as if each were alone."""

from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.machine import MachineBase

DRIVE_PULLEY = "drive pulley"
LOAD_PULLEY = "load pulley"
MOTOR = "motor"
PULLEYS = (DRIVE_PULLEY, LOAD_PULLEY)

FREE, HELD, HOLDING = "free", "held", "holding"
CONDITIONS = (FREE, HELD, HOLDING)


def motor_condition(drive: MachineBase, motor: str | None = None) -> str:
    """How the rotor is held in a calculation.

    "free": the rotor turns. "held": it does not; behind a flexible joint the drive pulley still turns on the
    joint, and without ``[motor]`` the drive pulley itself is held. "holding": the rotor turns on
    ``motor.holding_stiffness``; refused without one. Default: "holding" where the file gives that stiffness,
    else "free".
    """
    sprung = any(own.holding_stiffness is not None for own in drive.motors)
    if motor is None:
        return HOLDING if sprung else FREE
    if motor not in CONDITIONS:
        raise InputRefused(f'motor = "{motor}" is not one of its values: write free, held or holding')
    if motor == HOLDING and not sprung:
        said = 'motor = "holding" needs motor.holding_stiffness [N m/rad], which the drive file does not give'
        raise InputRefused(f"{said}: add it, or take free or held")
    return motor


def released(drive: Any) -> Any:
    """A machine without holding stiffness: what a torque controller sees of it.

    A stepper under field-oriented control commutates with the rotor, and a torque command replaces the
    position loop of a servo: either way no spring pulls the rotor to a commanded angle.
    """
    if all(own.holding_stiffness is None for own in drive.motors):
        return drive
    freed = tuple(replace(own, holding_stiffness=None) for own in drive.motors)
    return replace(drive, motor=freed if isinstance(drive.motor, tuple) else freed[0])


def left_out_under_torque(drive: MachineBase) -> str | None:
    """What is left out where a torque controls a machine, a sentence; None without a holding stiffness."""
    stiff = [f"{own.holding_stiffness:.4g}" for own in drive.motors if own.holding_stiffness is not None]
    if not stiff:
        return None
    said = f"motor.holding_stiffness = {' and '.join(dict.fromkeys(stiff))} N m/rad is left out"
    return f"{said}: under torque control (field-oriented for a stepper) the motor turns freely"


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaft:
    """One turning inertia with its friction, Eq. (2.28)."""

    name: str  # "drive", "load" or "motor": which one it is
    radius: float
    """Radius that turns its angle into a displacement of the rim [m]; of the motor: the drive pulley's."""
    inertia: float  # moment of inertia [kg m^2]; of the drive pulley: with the motor if their joint is rigid
    viscous_friction: float  # viscous friction [N m s/rad]
    coulomb_friction: float  # Coulomb friction [N m]
    fixed: bool = False  # whether it cannot turn
    holding_stiffness: float = 0.0  # spring from the shaft to the ground, to its angle zero [N m/rad]

    @property
    def rim_mass(self) -> float:
        """Inertia as the rim feels it, J / r^2 [kg]."""
        return self.inertia / self.radius**2


def shafts_of(drive: Drive) -> tuple[Shaft, ...]:
    """Drive pulley, a motor on a rigid joint included; load pulley; a motor on a flexible joint."""
    keys, motor = ("inertia", "viscous_friction", "coulomb_friction"), drive.motor
    base, load = (
        Shaft(name=name, radius=own.radius, fixed=own.fixed, **{key: getattr(own, key) for key in keys})
        for name, own in zip(("drive", "load"), drive.pulley, strict=True)
    )
    if motor is None:
        return base, load
    rigid, holding = motor.joint_stiffness is None, motor.holding_stiffness or 0.0
    own = {key: getattr(motor, key) + (getattr(base, key) if rigid else 0.0) for key in keys}
    if rigid:
        return replace(base, fixed=False, holding_stiffness=holding, **own), load
    return base, load, Shaft(name="motor", radius=base.radius, holding_stiffness=holding, **own)


def shaft_frictions(drive: Drive) -> list[tuple[float, float, Array]]:
    """Friction of drive pulley, load pulley, motor and joint, seen at the rim.

    Viscous [N s/m] and Coulomb [N], and how much of it moves with the rims of the three shafts, shape (3,).
    """
    pulley, motor = drive.pulley, drive.motor
    found = [(own.viscous_friction / own.radius**2, own.coulomb_friction / own.radius) for own in pulley]
    if motor is not None:
        r = drive.drive_pulley.radius
        found += [
            (motor.viscous_friction / r**2, motor.coulomb_friction / r),
            (motor.joint_damping / r**2, 0.0),
        ]
    ways = np.vstack((np.eye(3), (-1.0, 0.0, 1.0)))
    return [(viscous, coulomb, way) for (viscous, coulomb), way in zip(found, ways, strict=False)]


def modal_losses(drive: Drive, rims: Array, squares: Array) -> Array:
    """Damping between modes of unit modal mass, (k, k) [1/s]: shafts, joint, and Kelvin-Voigt of the cable.

    ``rims``, (k, 3): displacement of drive pulley, load pulley and motor [kg^-1/2]; ``squares``, (k,): of the
    frequencies [rad^2/s^2], the strain energy of which springs take a part.
    """
    motor, square, losses = drive.motor, drive.drive_pulley.radius**2, np.diag(squares)
    turned = [(viscous, rims @ way) for viscous, _, way in shaft_frictions(drive)]
    per_stiffness = drive.cable.axial_damping / drive.cable.axial_rigidity
    if motor is not None:  # what their springs take
        springs = motor.joint_stiffness or 0.0, motor.holding_stiffness or 0.0
        ways = rims[:, 2] - rims[:, 0], rims[:, 2]
        turned += [(-per_stiffness * k / square, way) for k, way in zip(springs, ways, strict=True)]
    return np.asarray(sum((b * np.outer(way, way) for b, way in turned), per_stiffness * losses))


def lumped_joint_mode(drive: Drive) -> float | None:
    r"""Frequency of the motor against the drive pulley, the cable taken away.

    .. math:: \omega^2 = k_m\,\Big(\frac{1}{J_{11}} + \frac{1}{J_{12}}\Big)

    Returns angular frequency [rad/s]; None without a flexible joint.
    """
    if drive.motor is None or drive.motor.joint_stiffness is None:
        return None
    return sqrt(drive.motor.joint_stiffness * (1.0 / drive.motor.inertia + 1.0 / drive.drive_pulley.inertia))


def span_stiffness(drive: Drive) -> float:
    """Stiffness k of one span: as measured, ``[lumped]``, else EA / L. Returns stiffness [N/m]."""
    if drive.lumped is not None and drive.lumped.cable_stiffness is not None:
        return drive.lumped.cable_stiffness
    return drive.cable.axial_rigidity / drive.span_length
