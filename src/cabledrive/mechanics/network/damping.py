"""Dampers of a machine with routes: bodies, bearings and joints, with the rows by which q moves them."""

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.parameters.arrays import Array


def dampers_of(network: Network) -> tuple[Array, Array]:
    """Dampers [N s/m], [N m s/rad], shape (k,), and their rows, shape (k, n); ropes have their own."""
    drive, motion = network.drive, network.motion
    parts: list[tuple[float, Array]] = []
    for body in drive.body:
        parts += [(body.damping, motion.unit(f"{body.name}.{move}")) for move in body.moves]
    motors = dict(zip(drive.driven, drive.motor, strict=True))
    for number, pulley in enumerate(drive.pulley):
        turn = relative_turn(network, number)
        parts.append((pulley.viscous_friction, turn))
        motor = motors.get(number)
        if motor is None:
            continue
        rotor = rotor_turn(network, number)
        parts.append((motor.viscous_friction, rotor))
        if motor.joint_stiffness is not None:
            parts.append((motor.joint_damping, rotor - turn))
    kept = [(value, row) for value, row in parts if value > 0.0 and row.any()]
    rows = np.array([row for _, row in kept]) if kept else np.zeros((0, len(motion.names)))
    return np.array([value for value, _ in kept]), rows


def relative_turn(network: Network, pulley: int) -> Array:
    """Turn of a pulley against what carries it, shape (n,)."""
    part = network.drive.pulley[pulley]
    mount = network.motion.rotation(network.drive.body_number(part.on, part.name))
    return network.motion.angle(pulley) - mount


def rotor_turn(network: Network, pulley: int) -> Array:
    """Turn of the rotor that drives a pulley, against what carries the motor, shape (n,)."""
    part = network.drive.pulley[pulley]
    name = f"rotor of {part.name}"
    if name not in network.motion.names:
        return relative_turn(network, pulley)
    mount = network.motion.rotation(network.drive.body_number(part.on, part.name))
    return network.motion.unit(name) - mount
