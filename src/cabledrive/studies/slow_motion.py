"""What a planned motion asks of every coordinate of a machine with routes: places, rates and accelerations.

The ropes are taken as unstretched here: coordinates follow the motions that strain no rope, joint or spring.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import DIRECTIONS, Network, rotor_turn
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive, moved
from cabledrive.studies.pair_thresholds import driven_of
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_path import place_in_file, pose_words, poses_along, summed, torques_of

STILL = 1e-9
"""Largest motion of a body that leaves the machine in its pose [m], [rad]."""
_STRAINLESS = 1e-9
_ASTRAY = 1e-3
_HELD = 1e-3
"""Square of frequency times duration below which a motion without strain counts as free."""


@dataclass(frozen=True, eq=False, kw_only=True)
class SlowMotion:
    """A machine along a motion, its ropes unstretched."""

    machines: tuple[RoutedDrive, ...]  # in each pose
    networks: tuple[Network, ...]
    free: tuple[Array, ...]  # (n, k): motions that strain nothing, in each pose
    here: Array  # (m,): number of the pose at the motion's times, with the share on the way to the next
    # rate, acceleration: (m, n): of the coordinates [m/s], [rad/s] and so on
    rate: Array
    acceleration: Array
    given: bool  # whether the motion gives places; else they follow from the torque, without friction

    def blend(self, here: Array) -> Array:
        """Share of each pose at places along them, shape (m, poses)."""
        return np.clip(1.0 - np.abs(here[:, None] - np.arange(len(self.networks))), 0.0, 1.0)


def slow_motion(drive: RoutedDrive, motion: PlannedMotion) -> SlowMotion:
    """The coordinates of a machine along a motion."""
    for route in drive.route:
        if route.speed:
            raise InputRefused(
                f'route "{route.name}" runs: --motion is for cables that do not; set speed to 0'
            )
    network = network_of(drive, motor=FREE)
    first = strainless(network)
    given = bool(motion.places)
    if given:
        steps = np.column_stack([own - place_in_file(drive, key) for key, own in motion.places.items()])
        follow = _follow(network, first, motion, steps)
        way, rate = steps @ follow.T, _slope(motion.time, steps) @ follow.T
    else:
        way, rate = _driven_way(drive, network, first, motion)
    keys = [f"{body.name}.{move}" for body in drive.body for move in body.moves]
    places = {key: place_in_file(drive, key) + way @ network.motion.unit(key) for key in keys}
    poses, here = poses_along(drive, places, motion.time)
    found = [_network(drive, pose) for pose in poses]
    machines, networks = tuple(own.drive for own in found), tuple(found)
    free = tuple(strainless(own) for own in networks)
    if given:
        rate = _rates(networks, free, here, motion)
    return SlowMotion(
        machines=machines,
        networks=networks,
        free=free,
        here=here,
        rate=rate,
        acceleration=_slope(motion.time, rate),
        given=given,
    )


def strainless(network: Network) -> Array:
    """Motions of the coordinates that strain no rope, joint or spring, shape (n, k)."""
    along = network.direction == DIRECTIONS.index(ALONG)
    rows = np.vstack((network.start[along] - network.end[along], network.spring_rows))
    size = np.abs(rows).max(axis=0)  # a column of metres and one of radians count alike
    scale = 1.0 / np.where(size > 0.0, size, 1.0)
    _, values, vectors = np.linalg.svd(rows * scale)
    rank = int(np.sum(values > _STRAINLESS * values[0]))
    return np.asarray(scale[:, None] * vectors[rank:].T)


def _network(drive: RoutedDrive, pose: Mapping[str, float]) -> Network:
    """The machine in a pose."""
    try:
        return network_of(moved(drive, pose) if pose else drive, motor=FREE)
    except InputRefused as refusal:
        raise InputRefused(f"motion: at {pose_words(drive, pose) or 'rest'}: {refusal}") from None


def _rates(
    networks: tuple[Network, ...], free: tuple[Array, ...], here: Array, motion: PlannedMotion
) -> Array:
    """Rates of all coordinates, by the motions of each pose, shape (m, n)."""
    places = np.column_stack(list(motion.places.values()))
    speed = _slope(motion.time, places)
    steps = places - places[0]
    rates = [
        speed @ _follow(network, own, motion, steps).T for network, own in zip(networks, free, strict=True)
    ]
    share = np.clip(1.0 - np.abs(here[:, None] - np.arange(len(networks))), 0.0, 1.0)
    return np.asarray(np.einsum("mp,pmn->mn", share, np.array(rates)))


def _follow(network: Network, free: Array, motion: PlannedMotion, steps: Array) -> Array:
    """Rates of all coordinates per rate of each given place, shape (n, given)."""
    rows = np.array([network.motion.unit(key) for key in motion.places])
    names = ", ".join(motion.places)
    if not free.shape[1]:
        raise InputRefused(
            f"motion: {names}: a spring or a rope holds every body of this machine, so no place can be "
            "planned: give the torque alone"
        )
    if np.linalg.matrix_rank(rows @ free, tol=1e-9 * np.abs(free).max()) < free.shape[1]:
        others = [
            f"{body.name}.{move}"
            for body in network.drive.body
            for move in body.moves
            if f"{body.name}.{move}" not in motion.places
            and (network.motion.unit(f"{body.name}.{move}") @ free).any()
        ]
        raise InputRefused(
            f"motion: the places of {names} do not say how the machine moves: "
            f"add {' or '.join(others) or 'torque alone'}"
        )
    inverse = np.linalg.pinv(rows @ free)
    missing = np.abs(steps @ inverse.T @ (rows @ free).T - steps)
    if np.any(missing > _ASTRAY * np.abs(steps).max(initial=STILL)):
        raise InputRefused(
            f"motion: the places of {names} do not go together: the ropes would stretch or hang"
        )
    return np.asarray(free @ inverse)


def _driven_way(
    drive: RoutedDrive, network: Network, free: Array, motion: PlannedMotion
) -> tuple[Array, Array]:
    """Where the torque takes the coordinates of the machine from rest, without friction, and their rates."""
    turns = np.array([rotor_turn(network, number) for number in driven_of(drive)])
    mass = free.T @ network.static_mass @ free
    held = np.linalg.solve(mass, free.T @ network.static_stiffness @ free)
    if np.abs(held).max(initial=0.0) * motion.time[-1] ** 2 > _HELD:
        raise InputRefused(
            "motion: weights or directions of ropes hold the machine against its torque: give the places of "
            "its bodies as columns"
        )
    push = np.column_stack(torques_of(drive, motion)) @ turns @ free
    speed = summed(motion.time, np.linalg.solve(mass, push.T).T)
    return summed(motion.time, speed) @ free.T, speed @ free.T


def _slope(time: Array, values: Array) -> Array:
    if time.size > 2:
        return np.asarray(np.gradient(values, time, axis=0, edge_order=2))
    return np.asarray(np.gradient(values, time, axis=0))
