"""The pulley mode seen at the rims: displacements, what resists them, and the rigid rotation beside it."""

from dataclasses import dataclass

from cabledrive.mechanics.holding import DRIVE_PULLEY, LOAD_PULLEY, MOTOR
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.tuning import PulleyMode
from cabledrive.parameters import Drive


@dataclass(frozen=True, slots=True, kw_only=True)
class Shaft:
    """What resists the turning of a pulley or motor, seen at the rim."""

    viscous: float  # b / r^2 [N s/m]
    coulomb: float  # c / r [N]
    shape: float  # displacement per q of the pulley mode
    turns: bool = True  # whether it turns with the rigid rotation; the motor's joint does not


def scaled_rims(pulley: PulleyMode) -> tuple[dict[str, float], float]:
    """Displacements of drive rim, load rim and motor per q, and the square root of the modal mass [kg^1/2].

    q is the displacement of the load rim relative to the drive rim; in modes where the two go together, the
    larger of both.
    """
    shape = {name: float(values[pulley.shape]) for name, values in pulley.mode.joints.items()}
    drive, load = shape.get(DRIVE_PULLEY, 0.0), shape.get(LOAD_PULLEY, 0.0)
    scale = load - drive
    if abs(scale) < 0.1 * max(abs(drive), abs(load)):
        scale = load if abs(load) > abs(drive) else drive
    motor = shape.get(MOTOR, drive)
    return {DRIVE_PULLEY: drive / scale, LOAD_PULLEY: load / scale, MOTOR: motor / scale}, 1.0 / scale


def shafts_of(drive: Drive, rim: dict[str, float]) -> list[Shaft]:
    """Everything with friction: both pulleys, the motor, its joint. ``rim``: displacements per q."""
    first, second, motor = drive.drive_pulley, drive.load_pulley, drive.motor
    shafts = [
        Shaft(
            viscous=pulley.viscous_friction / pulley.radius**2,
            coulomb=pulley.coulomb_friction / pulley.radius,
            shape=rim[name],
        )
        for name, pulley in ((DRIVE_PULLEY, first), (LOAD_PULLEY, second))
    ]
    if motor is not None:
        arm, twist = first.radius, rim[MOTOR] - rim[DRIVE_PULLEY]
        own = Shaft(
            viscous=motor.viscous_friction / arm**2, coulomb=motor.coulomb_friction / arm, shape=rim[MOTOR]
        )
        shafts += [own, Shaft(viscous=motor.joint_damping / arm**2, coulomb=0.0, shape=twist, turns=False)]
    return shafts


def modal_damping(
    drive: Drive, shafts: list[Shaft], rim: dict[str, float], mass: float, omega: float
) -> float:
    """Damping c_q [1/s] of the pulley mode: pulleys, motor, joint, and Kelvin-Voigt for the cable's strain.

    ``rim``: displacements per q; ``mass``: M [kg]; ``omega``: W [rad/s].
    """
    motor, strain = drive.motor, omega**2
    if motor is not None and motor.joint_stiffness is not None:
        strain -= (
            motor.joint_stiffness * ((rim[MOTOR] - rim[DRIVE_PULLEY]) / drive.drive_pulley.radius) ** 2 / mass
        )
    if motor is not None and motor.holding_stiffness is not None:
        strain -= motor.holding_stiffness * (rim[MOTOR] / drive.drive_pulley.radius) ** 2 / mass
    cable = drive.cable.axial_damping / drive.cable.axial_rigidity * strain
    return cable + sum(shaft.viscous * shaft.shape**2 for shaft in shafts) / mass


def rigid_mass(drive: Drive) -> float:
    """Mass at the rim of everything that moves when the drive turns. Returns [kg]."""
    (chain,) = longitudinal_chains(drive)
    parts = chain.chain
    pendant = parts.pendant.mass if parts.pendant else 0.0
    return float(parts.masses.sum() + parts.cable_mass + pendant)
