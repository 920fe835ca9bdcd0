"""Poles of the sampled loop of two motors where the body rests, by differences; friction left out."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.tension_position import TensionGains, first_state, step
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors_kernels import TwoMotors
from cabledrive.rig.two_motors.plan import held_tensions, lines_along
from cabledrive.rig.two_motors.plant_kernels import move, pull_of

DIFFERENCE = 1e-6
_SLOW, _AT_ONE = 0.2, 1e-12


def loop_poles(
    machine: TwoMotors, gains: TensionGains, place: Array, substeps: int
) -> NDArray[np.complex128]:
    """Poles [rad/s] of the loop about the body at rest at a place, shape (p,); those of dead beats left out.

    ``machine``: the plant; ``place``, shape (m,) [m].
    """
    still = machine._replace(turning_coulomb=np.zeros(2), coulomb=np.zeros_like(machine.coulomb))
    believed = gains._replace(machine=still)
    along, length, free = lines_along(still, place[None])
    tension = held_tensions(gains.preferred, along, still.force[None])[0]
    angle = (still.unwound - length[0] + tension * free[0] / still.rigidity) / still.drum
    state = first_state(gains, tension)
    m = place.size
    state[:m], state[3 * m + 4 : 3 * m + 6] = place, angle
    reference = np.concatenate([place, np.zeros(2 * m + 2)])
    rest = np.concatenate([place, np.zeros(m), angle, np.zeros(2), state[: 3 * m + 6]])
    size = np.ones(rest.size)
    size[5 * m + 4 : 5 * m + 8] = tension.max()

    def following(x: Array) -> Array:
        """The loop one sample later."""
        q, v, turned, turn = (part.copy() for part in np.split(x[: 2 * m + 4], [m, 2 * m, 2 * m + 2]))
        own, rows, pull = state.copy(), np.zeros((2, m)), np.zeros(2)
        own[: 3 * m + 6] = x[2 * m + 4 :]
        pull_of(still, q, v, turned, turn, rows, pull)
        own, torque = step(believed, own, np.concatenate([turned, pull]), reference)
        for _ in range(substeps):
            move(still, gains.interval / substeps, q, v, turned, turn, torque, np.zeros(m), rows, pull)
        return np.concatenate([q, v, turned, turn, own[: 3 * m + 6]])

    columns = [
        (following(rest + h) - following(rest - h)) / (2.0 * DIFFERENCE) for h in DIFFERENCE * np.diag(size)
    ]
    values = np.linalg.eigvals(size[:, None] ** -1 * np.array(columns).T)
    return np.asarray(np.log(values[np.abs(values) > _SLOW]) / gains.interval)


def least_damping(machine: TwoMotors, gains: TensionGains, places: Array, substeps: int) -> float:
    """Least damping ratio of all poles over some places, shape (places, m); negative: unstable."""
    found = []
    for place in places:
        poles = loop_poles(machine, gains, place, substeps)
        poles = poles[np.abs(poles) > _AT_ONE]
        found.append(float((-poles.real / np.abs(poles)).min()))
    return min(found)
