"""Viscous losses of a longitudinal mode of a machine with routes, and how its motor drives it."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.assembly import Network
from cabledrive.modal import Mode

Array = NDArray[np.float64]

POINTS = 48
"""Points at which a wave is looked at on each piece of a span: enough for 20 half waves."""


def quadrature() -> tuple[Array, Array, Array]:
    """Gauss points of [0, 1], their weights, and the matrix that differentiates at them."""
    x, w = np.polynomial.legendre.leggauss(POINTS)
    gaps = x[:, None] - x + np.eye(POINTS)
    scale = np.array([np.prod(row) for row in 2.0 * gaps])
    slope = scale[:, None] / scale / gaps
    np.fill_diagonal(slope, 0.0)
    np.fill_diagonal(slope, -slope.sum(axis=1))
    return 0.5 * (x + 1.0), 0.5 * w, 2.0 * slope


def motor_turn(network: Network, mode: Mode) -> float:
    """Turn of the first motor's pulley, or of its rotor, in a mode of unit modal mass [rad/sqrt(kg)]."""
    drive = network.drive
    pulley = drive.pulley[drive.driven[0] if drive.driven else 0].name
    joints = mode._motion.joints
    for name in (f"rotor of {pulley}", pulley):
        if name in joints:
            value = abs(float(np.real(joints[name][0])))
            return value if value > 1e-9 * max(float(np.abs(v[0])) for v in joints.values()) else 0.0
    return 0.0


def modal_damping(network: Network, mode: Mode, strains: dict[int, Array]) -> float:
    """Damping of a longitudinal mode of unit modal mass [1/s]: viscous parts of the file alone.

    ``strains``: slopes along the pieces at the points of quadrature.
    """
    drive, joints = network.drive, mode._motion.joints
    _, weights, _ = quadrature()
    total = 0.0
    for number, values in strains.items():
        piece = network.pieces[number]
        route = drive.free_spans[piece.span].route
        damping = drive.ropes[route].axial_damping * drive.route[route].ropes
        total += damping * piece.length * float(weights @ values**2)

    def moved(name: str) -> float:
        return float(np.abs(joints[name][0])) if name in joints else 0.0

    for pulley in drive.pulley:
        total += pulley.viscous_friction * moved(pulley.name) ** 2
    for motor, own in zip(drive.motor, drive.driven, strict=True):
        name = drive.pulley[own].name
        rotor = f"rotor of {name}"
        total += motor.viscous_friction * moved(rotor if rotor in joints else name) ** 2
        if rotor in joints:
            total += (motor.joint_damping or 0.0) * float(np.abs(joints[rotor][0] - joints[name][0])) ** 2
    for body in drive.body:
        total += body.damping * sum(moved(f"{body.name}.{move}") ** 2 for move in body.moves)
    return total
