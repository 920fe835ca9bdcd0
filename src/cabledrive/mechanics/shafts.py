"""What turns: the two pulleys, and the motor behind a flexible joint."""

from dataclasses import dataclass

from cabledrive.parameters.drive import Drive


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Joint:
    """Flexible joint between motor and drive pulley."""

    stiffness: float  # stiffness k_m [N m/rad]
    damping: float  # damping b_m [N m s/rad]


def shafts_of(drive: Drive) -> tuple[Shaft, ...]:
    """Drive pulley, a motor on a rigid joint included; load pulley; a motor on a flexible joint."""
    pulleys = [
        Shaft(
            name=name,
            radius=pulley.radius,
            inertia=pulley.inertia,
            viscous_friction=pulley.viscous_friction,
            coulomb_friction=pulley.coulomb_friction,
            fixed=pulley.fixed,
        )
        for name, pulley in zip(("drive", "load"), drive.pulley, strict=True)
    ]
    if drive.motor is None:
        return tuple(pulleys)
    rigid = drive.motor.joint_stiffness is None
    base = pulleys[0]
    motor = Shaft(
        name="drive" if rigid else "motor",
        radius=base.radius,
        inertia=drive.motor.inertia + (base.inertia if rigid else 0.0),
        viscous_friction=drive.motor.viscous_friction + (base.viscous_friction if rigid else 0.0),
        coulomb_friction=drive.motor.coulomb_friction + (base.coulomb_friction if rigid else 0.0),
        holding_stiffness=drive.motor.holding_stiffness or 0.0,
    )
    return (motor, pulleys[1]) if rigid else (*pulleys, motor)


def joint_of(drive: Drive) -> Joint | None:
    """Flexible joint between motor and drive pulley; None without a motor or where it is rigid."""
    motor = drive.motor
    if motor is None or motor.joint_stiffness is None:
        return None
    return Joint(stiffness=motor.joint_stiffness, damping=motor.joint_damping)
