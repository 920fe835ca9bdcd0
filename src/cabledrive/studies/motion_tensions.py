r"""Tensions of all ropes along a planned motion, and the torque that the motors need for it.

About the state of rest in each pose, with masses, springs and ropes of the network as matrices M, K and
the motions :math:`\Phi` that strain nothing,

.. math:: \Phi^T B\,\tau = \Phi^T (M\ddot q - F), \qquad
          K u = B\,\tau + F - M\ddot q, \qquad \Phi^T M u = 0

give the torque :math:`\tau` and the stretching u that distributes forces of inertia and friction F over
elastic ropes. With the vibration, each elastic mode of the pose answers the same forces from rest, exactly
for forces that change evenly between samples. Ropes stretch evenly in their spans; their mass is shared out
to the ends. Places, rates and accelerations of the coordinates are those of unstretched ropes: they follow
the motions that strain no rope, joint or spring.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

import numpy as np

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import Network, rotor_turn
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


def shares(here: Array, poses: int) -> Array:
    """Share of each pose at places along them, shape (m, poses)."""
    return np.clip(1.0 - np.abs(here[:, None] - np.arange(poses)), 0.0, 1.0)


def strainless(network: Network) -> Array:
    """Motions of the coordinates that strain no rope, joint or spring, shape (n, k)."""
    rows = np.vstack((-network.stretch, network.springs.rows))
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
    return np.asarray(np.einsum("mp,pmn->mn", shares(here, len(networks)), np.array(rates)))


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
    turns = np.array([rotor_turn(network.motion, number) for number in driven_of(drive)])
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


PER_PERIOD = 16
LEAST_STEPS, MOST_STEPS = 2_000, 40_000
_TURNING = 0.01
"""Part of its largest speed within which friction grows to its whole: sampled rates are not exact."""
_MISSING = 1e-3


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionTensions:
    """Tensions of one rope of each piece along a motion; q: index of a piece, start and end of it last."""

    slow: SlowMotion
    time: Array  # (t,): [s], in equal steps
    share: Array  # (t, poses): of each pose
    # rest, even, vibrating: (t, pieces, 2): at rest in the pose, with forces of inertia and friction, and
    # with the vibration [N]
    rest: Array
    even: Array
    vibrating: Array
    # torque, holding: (t, motors): beyond what holds the machine at rest, and that [N m]
    torque: Array
    holding: Array
    speed: Array  # (t, motors): of the rotors against their mounts [rad/s]
    mismatch: float  # largest difference between the torque that the file gives and that of its places [N m]
    # lowest_mode, highest_mode: of the elastic modes that answer [Hz]; NaN without one
    lowest_mode: float
    highest_mode: float


def motion_tensions(drive: RoutedDrive, motion: PlannedMotion) -> MotionTensions:
    """Tensions of a machine along a motion, from rest."""
    slow = slow_motion(drive, motion)
    modes = [_elastic_modes(network, free) for network, free in zip(slow.networks, slow.free, strict=True)]
    highest = max((float(own.omega.max(initial=0.0)) for own in modes), default=0.0)
    lowest = min((float(own.omega.min(initial=np.inf)) for own in modes), default=np.inf)
    duration = float(motion.time[-1])
    steps = int(np.clip(duration * highest / (2.0 * pi) * PER_PERIOD, LEAST_STEPS, MOST_STEPS))
    time = np.linspace(0.0, duration, steps + 1)
    share = shares(np.interp(time, motion.time, slow.here), len(slow.networks))
    rate, acceleration = (_at(time, motion.time, own) for own in (slow.rate, slow.acceleration))
    told = _at(time, motion.time, np.column_stack(torques_of(drive, motion)))
    along = time, rate, acceleration, told
    found = [
        _in_pose(network, free, own, along, slow.given)
        for network, free, own in zip(slow.networks, slow.free, modes, strict=True)
    ]
    rest, even, vibrating, torque, holding = (
        sum(share[:, p].reshape(-1, *[1] * (own[k].ndim - 1)) * own[k] for p, own in enumerate(found))
        for k in range(5)
    )
    turns = np.array([rotor_turn(slow.networks[0].motion, number) for number in driven_of(drive)])
    return MotionTensions(
        slow=slow,
        time=time,
        share=share,
        rest=np.asarray(rest),
        even=np.asarray(even),
        vibrating=np.asarray(vibrating),
        torque=np.asarray(torque),
        holding=np.asarray(holding),
        speed=rate @ turns.T,
        mismatch=float(np.abs(told - torque).max()) if slow.given and told.any() else 0.0,
        lowest_mode=lowest / (2.0 * pi) if np.isfinite(lowest) else float("nan"),
        highest_mode=highest / (2.0 * pi) if highest else float("nan"),
    )


@dataclass(frozen=True, eq=False)
class _ElasticModes:
    """Modes of matrices M and K apart from free motions; shapes of unit stiffness, shape (n, k)."""

    shapes: Array
    mass: Array
    loss: Array

    @property
    def omega(self) -> Array:
        """Of the modes with mass [rad/s]."""
        return np.asarray(1.0 / np.sqrt(self.mass[self.mass > 0.0]))


def _elastic_modes(network: Network, free: Array) -> _ElasticModes:
    from scipy.linalg import eigh, null_space

    others = null_space((network.static_mass @ free).T) if free.size else np.eye(len(network.motion.names))
    if not others.shape[1]:
        return _ElasticModes(np.zeros((len(others), 0)), np.zeros(0), np.zeros(0))
    mass, stiffness = (others.T @ own @ others for own in (network.static_mass, network.static_stiffness))
    try:
        own, vectors = eigh(mass, stiffness)
    except np.linalg.LinAlgError:
        raise InputRefused("motion: the machine is not stable at rest in a pose that it passes") from None
    shapes = others @ vectors
    along = [piece.rope.axial_damping / piece.length for piece in network.pieces]  # of one rope
    damping = np.append(network.dampers.values, network.ropes[::3] * along)
    loss = damping @ (np.vstack((network.dampers.rows, network.stretch)) @ shapes) ** 2
    return _ElasticModes(shapes, np.where(own > 1e-16 * own.max(), own, 0.0), loss)


def _in_pose(
    network: Network,
    free: Array,
    modes: _ElasticModes,
    along: tuple[Array, Array, Array, Array],
    given: bool,
) -> tuple[Array, Array, Array, Array, Array]:
    """Tensions at rest, with inertia, with the vibration; torque beyond rest, holding torque.

    ``along``: the motion's time, rates, accelerations, and the torque that its file gives.
    """
    time, rate, acceleration, told = along
    turns = np.array([rotor_turn(network.motion, number) for number in driven_of(network.drive)])
    rubbed = _friction(network, rate) if given else np.zeros_like(rate)
    inertia = acceleration @ network.static_mass
    torque = _torque(network, turns, free, inertia - rubbed) if given else told
    load = torque @ turns + rubbed
    even = load @ modes.shapes
    swing = np.column_stack(
        [
            _answer(own, mass, loss, time[1])
            for own, mass, loss in zip(even.T, modes.mass, modes.loss, strict=True)
        ]
        or [np.zeros((time.size, 0))]
    )
    tension = np.array([(piece.start_tension, piece.end_tension) for piece in network.pieces])
    rest = np.broadcast_to(tension, (time.size, *tension.shape))
    mass = (network.impedance * network.time)[::3]
    near, far = acceleration @ network.start[::3].T, acceleration @ network.end[::3].T
    own = np.stack((-mass * (2.0 * near + far), mass * (near + 2.0 * far)), axis=-1) / 6.0
    both = [rest + own + (x @ (network.pull @ modes.shapes).T)[:, :, None] for x in (even, swing)]
    return rest, both[0], both[1], torque, np.broadcast_to(_holding(network), (time.size, len(turns)))


def _answer(push: Array, mass: float, loss: float, step: float) -> Array:
    """A mode of unit stiffness under a force, from rest: exact for a force on straight lines."""
    from scipy.signal import cont2discrete, lfilter

    if mass == 0.0:
        return push
    (top,), bottom, _ = cont2discrete(([1.0], [mass, loss, 1.0]), step, method="foh")
    # The filter takes what stands before the first sample for zero: a first force is a short ramp.
    return np.asarray(lfilter(top, bottom, push))


def _friction(network: Network, rate: Array) -> Array:
    """Forces of bearings, bodies and motors against a motion, shape (t, n); nothing rubs at rest."""
    total = -rate @ network.dampers.matrix
    for friction, row, _ in zip(*network.rubs, strict=True):
        speed = rate @ row
        slow = max(_TURNING * float(np.abs(speed).max(initial=0.0)), 1e-300)
        total = total - np.outer(friction * np.clip(speed / slow, -1.0, 1.0), row)
    return np.asarray(total)


def _torque(network: Network, turns: Array, free: Array, need: Array) -> Array:
    """Torque of the motors that gives a motion, shape (t, motors)."""
    reach = turns @ free
    torque = need @ free @ np.linalg.pinv(reach)
    missing = np.abs(torque @ reach - need @ free).max(initial=0.0)
    if missing > _MISSING * np.abs(need @ free).max(initial=0.0):
        raise InputRefused(
            f"motion: {len(turns)} motors cannot make a motion of {free.shape[1]} freedoms as planned: plan "
            "places that the motors reach"
        )
    return np.asarray(torque)


def _holding(network: Network) -> Array:
    """Torque of each motor that holds the machine at rest, shape (motors,) [N m]."""
    drive, statics = network.drive, network.statics
    found = np.zeros(len(driven_of(drive)))
    for m, number in enumerate(driven_of(drive)):
        for index, span in enumerate(drive.free_spans):
            ropes = drive.route[span.route].ropes
            for place, sign, tension in (
                (span.start, -1.0, statics.start[index]),
                (span.end, 1.0, statics.end[index]),
            ):
                if place.pulley == number:
                    found[m] += sign * place.sense * place.radius * ropes * tension
    return found


def _at(time: Array, own: Array, values: Array) -> Array:
    return np.column_stack([np.interp(time, own, column) for column in values.T])
