"""How a drive is held: the rotor free, held or on a spring; pulleys and carriages by name."""

from collections.abc import Sequence
from dataclasses import replace

from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest

DRIVE_PULLEY = "drive pulley"
LOAD_PULLEY = "load pulley"
MOTOR = "motor"
PULLEYS = (DRIVE_PULLEY, LOAD_PULLEY)

FREE, HELD, HOLDING = "free", "held", "holding"
CONDITIONS = (FREE, HELD, HOLDING)


def motor_condition(drive: Drive, motor: str | None = None) -> str:
    """How the rotor is held in a calculation.

    "free": the rotor turns. "held": it does not; behind a flexible joint the drive pulley still turns on the
    joint, and without ``[motor]`` the drive pulley itself is held. "holding": the rotor turns on
    ``motor.holding_stiffness``; refused without one. Default: "holding" where the file gives that stiffness,
    else "free".
    """
    sprung = drive.motor is not None and drive.motor.holding_stiffness is not None
    if motor is None:
        return HOLDING if sprung else FREE
    if motor not in CONDITIONS:
        raise InputRefused(f'motor = "{motor}" is not one of its values: write free, held or holding')
    if motor == HOLDING and not sprung:
        raise InputRefused(
            'motor = "holding" needs motor.holding_stiffness [N m/rad], which the drive file does not give: '
            "add it, or take free or held"
        )
    return motor


def joint_stiffness(drive: Drive) -> float | None:
    """Stiffness [N m/rad] of the joint between motor and drive pulley; None without motor or if rigid."""
    return drive.motor.joint_stiffness if drive.motor is not None else None


def carriage_joint(number: int) -> str:
    """Name of a carriage among the joints of a chain, "carriage 0" for number 0 of the drive file."""
    return f"carriage {number}"


def held_joints(drive: Drive, hold: Sequence[str]) -> frozenset[str]:
    """Joints of the drive's chains by the names that a user gives them; others are refused.

    ``hold``: "drive pulley", "load pulley", "carriage 0" (its number in the file), or a carriage's ``name``.
    """
    if isinstance(hold, str):
        hold = (hold,)
    known = {name: name for name in PULLEYS}
    for number, carriage in enumerate(drive.carriage):
        known |= {carriage_joint(number): carriage_joint(number)}
        if carriage.name:
            known[carriage.name] = carriage_joint(number)
    for name in hold:
        if name not in known:
            hint = ': the rotor is held by motor = "held"' if name == MOTOR else nearest(name[:60], known)
            raise InputRefused(f'hold = "{name[:60]}" is no part of this drive that can be held{hint}')
    return frozenset(known[name] for name in hold)


def released(drive: Drive) -> Drive:
    """The drive without a holding stiffness: what a torque controller sees of it.

    A stepper under field-oriented control commutates with the rotor, and a torque command replaces the
    position loop of a servo: either way no spring pulls the rotor to a commanded angle.
    """
    if drive.motor is None or drive.motor.holding_stiffness is None:
        return drive
    return replace(drive, motor=replace(drive.motor, holding_stiffness=None))


def left_out_under_torque(drive: Drive) -> str | None:
    """What is left out where a torque controls the drive, a sentence; None without a holding stiffness."""
    if drive.motor is None or drive.motor.holding_stiffness is None:
        return None
    return (
        f"motor.holding_stiffness = {drive.motor.holding_stiffness:.4g} N m/rad is left out: under torque "
        "control (field-oriented for a stepper) the motor turns freely"
    )
