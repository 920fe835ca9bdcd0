"""Coulomb friction of a machine with routes: bodies, bearings and motors, with the rows that move them."""

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.damping import relative_turn, rotor_turn
from cabledrive.parameters.arrays import Array


def coulomb_of(network: Network) -> list[tuple[str, Array, float]]:
    """Name, row, shape (n,), and friction [N], [N m] of all that rubs, but for ropes on their wraps."""
    drive, motion = network.drive, network.motion
    parts = [
        (f"{body.name}.{move}", motion.unit(f"{body.name}.{move}"), body.coulomb_friction)
        for body in drive.body
        for move in body.moves
    ]
    parts += [
        (pulley.name, relative_turn(network, number), pulley.coulomb_friction)
        for number, pulley in enumerate(drive.pulley)
    ]
    for number, motor in zip(drive.driven, drive.motor, strict=True):
        parts.append(
            (f"motor of {drive.pulley[number].name}", rotor_turn(network, number), motor.coulomb_friction)
        )
    return [part for part in parts if part[2] > 0.0 and part[1].any()]
