"""Stiffness of bodies that turn under the forces at rest."""

import numpy as np

from cabledrive.mechanics.network.motion import Motion
from cabledrive.mechanics.network.sections import gravity
from cabledrive.mechanics.network.statics import Statics
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.geometry import Point


def geometric_stiffness(motion: Motion, statics: Statics) -> Array:
    r"""Stiffness of turning bodies under constant forces, Eq. (N.4).

    .. math:: K_{ij} = -\sum F \cdot \frac{\partial^2 c}{\partial q_i\,\partial q_j}, \qquad
              \frac{\partial^2 c}{\partial q_a\,\partial q_b} = e_z \times \frac{\partial c}{\partial q_b}

    where a turns and carries b, or is b itself; zero else.
    """
    drive = motion.drive
    total = np.zeros((len(motion.names), len(motion.names)))
    if not any("turn" in body.moves for body in drive.body):
        return total
    g = gravity(drive)
    loads: list[tuple[Array, Point, int | None]] = [
        (body.mass * g + np.array(body.load), body.at, i) for i, body in enumerate(drive.body)
    ]
    loads += [
        (pulley.mass * g, pulley.at, drive.body_number(pulley.on, pulley.name)) for pulley in drive.pulley
    ]
    for number, span in enumerate(drive.free_spans):
        for end, place in enumerate((span.start, span.end)):
            loads.append((statics.forces[number, end], place.centre, motion.body_of(place)))
    for force, at, body in loads:
        rows = motion.point(at, body)
        turned = force[1] * rows[0] - force[0] * rows[1]  # F . (e_z x dc/dq)
        chain = drive.carried_by(body)
        for position, outer in enumerate(chain):
            if "turn" not in drive.body[outer].moves:
                continue
            a = motion.unit(f"{drive.body[outer].name}.turn")
            for inner in chain[: position + 1]:
                for move in drive.body[inner].moves:
                    b = motion.unit(f"{drive.body[inner].name}.{move}")
                    value = -float(turned @ b)
                    total += value * np.outer(a, b)
                    total += value * np.outer(b, a) if inner != outer else 0.0
    return total
