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
from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import moved
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.studies import motion_stages as stages
from cabledrive.studies.pair_thresholds import refuse_running
from cabledrive.studies.planned_motion import PlannedMotion

_ASTRAY = 1e-3


def shares(here: Array, poses: int) -> Array:
    """Share of each pose at places along them, shape (m, poses)."""
    return np.clip(1.0 - np.abs(here[:, None] - np.arange(poses)), 0.0, 1.0)


def _network(drive: Machine, pose: Mapping[str, float]) -> Network:
    """The machine in a pose."""
    try:
        return network_of(moved(drive, pose) if pose else drive, motor=FREE)
    except InputRefused as refusal:
        raise InputRefused(f"motion: at {stages.pose_words(drive, pose) or 'rest'}: {refusal}") from None


def _follow(network: Network, free: Array, motion: PlannedMotion, steps: Array) -> Array:
    """Rates of all coordinates per rate of each given place, shape (n, given)."""
    rows = network.motion.dense(*motion.places)
    names = ", ".join(motion.places)
    if not free.shape[1]:
        said = f"motion: {names}: a spring or a rope holds every body of this machine"
        raise InputRefused(f"{said}, so no place can be planned: give the torque alone")
    if np.linalg.matrix_rank(rows @ free, tol=1e-9 * np.abs(free).max()) < free.shape[1]:
        others = [
            f"{body.name}.{move}"
            for body in network.drive.body
            for move in body.moves
            if f"{body.name}.{move}" not in motion.places
            and (network.motion.dense(f"{body.name}.{move}") @ free).any()
        ]
        said = f"motion: the places of {names} do not say how the machine moves"
        raise InputRefused(f"{said}: add {' or '.join(others) or 'torque alone'}")
    inverse = np.linalg.pinv(rows @ free)
    missing = np.abs(steps @ inverse.T @ (rows @ free).T - steps)
    if np.any(missing > _ASTRAY * np.abs(steps).max(initial=stages.STILL)):
        raise InputRefused(
            f"motion: the places of {names} do not go together: the ropes would stretch or hang"
        )
    return np.asarray(free @ inverse)


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

    networks: tuple[Network, ...]  # the machine in each pose
    given: bool  # whether the motion gives places; else they follow from the torque, without friction
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
    modes: tuple[float, float]  # lowest and highest of the elastic modes that answer [Hz]; NaN without one


def motion_tensions(drive: Machine, motion: PlannedMotion) -> MotionTensions:
    """Tensions of a machine along a motion, from rest."""
    refuse_running(drive, "--motion")
    network, given = network_of(drive, motor=FREE), bool(motion.places)
    if given:
        steps = np.column_stack([own - place_of(drive, key) for key, own in motion.places.items()])
        way = steps @ _follow(network, stages.strainless(network), motion, steps).T
    else:
        driven = stages.driven_way(drive, network, motion)
        if driven is None:
            said = "motion: weights or directions of ropes hold the machine against its torque"
            raise InputRefused(f"{said}: give the places of its bodies as columns")
        way, rate = driven
    poses, here = stages.poses_along(drive, stages.places_along(drive, network, way), motion.time)
    networks = [_network(drive, pose) for pose in poses]
    frees = [stages.strainless(one) for one in networks]
    if given:  # by the motions of each pose
        planned = np.column_stack(list(motion.places.values()))
        speed = _slope(motion.time, planned)
        rates = [
            speed @ _follow(one, free, motion, planned - planned[0]).T
            for one, free in zip(networks, frees, strict=True)
        ]
        rate = np.einsum("mp,pmn->mn", shares(here, len(networks)), np.array(rates))
    modes = [_elastic_modes(one, free) for one, free in zip(networks, frees, strict=True)]
    omega = np.concatenate([1.0 / np.sqrt(mass[mass > 0.0]) for _, mass, _ in modes])
    lowest, highest = float(omega.min(initial=np.inf)), float(omega.max(initial=0.0))
    duration = float(motion.time[-1])
    count = int(np.clip(duration * highest / (2.0 * pi) * PER_PERIOD, LEAST_STEPS, MOST_STEPS))
    time = np.linspace(0.0, duration, count + 1)
    share = shares(np.interp(time, motion.time, here), len(networks))
    stated = np.column_stack(stages.torques_of(drive, motion))
    rate, acceleration, stated = (
        np.column_stack([np.interp(time, motion.time, column) for column in values.T])
        for values in (rate, _slope(motion.time, rate), stated)
    )
    along = time, rate, acceleration, None if given else stated
    found = [_in_pose(*pose, along) for pose in zip(networks, frees, modes, strict=True)]
    rest, even, vibrating, torque, holding = (
        np.asarray(sum(share[:, p].reshape(-1, *[1] * (x.ndim - 1)) * x for p, x in enumerate(parts)))
        for parts in zip(*found, strict=True)
    )
    turns = turns_by_torque(networks[0])
    return MotionTensions(
        networks=tuple(networks),
        given=given,
        time=time,
        share=share,
        rest=rest,
        even=even,
        vibrating=vibrating,
        torque=torque,
        holding=holding,
        speed=rate @ turns.T,
        mismatch=float(np.abs(stated - torque).max()) if given and stated.any() else 0.0,
        modes=(lowest / (2.0 * pi), highest / (2.0 * pi)) if omega.size else (float("nan"), float("nan")),
    )


_Modes = tuple[Array, Array, Array]


def _elastic_modes(network: Network, free: Array) -> _Modes:
    """Shapes of unit stiffness, (n, k), masses and dampings of the modes apart from free motions, (k,)."""
    from scipy.linalg import eigh, null_space

    others = null_space((network.static_mass @ free).T) if free.size else np.eye(len(network.motion.names))
    if not others.shape[1]:
        return np.zeros((len(others), 0)), np.zeros(0), np.zeros(0)
    mass, stiffness = (others.T @ own @ others for own in (network.static_mass, network.static_stiffness))
    try:
        own, vectors = eigh(mass, stiffness)
    except np.linalg.LinAlgError:
        raise InputRefused("motion: the machine is not stable at rest in a pose that it passes") from None
    shapes = others @ vectors
    along = [piece.rope.axial_damping / piece.length for piece in network.pieces]  # of one rope
    damping = np.append(network.dampers.values, network.ropes[::3] * along)
    loss = damping @ (np.vstack((network.dampers.dense, network.stretch)) @ shapes) ** 2
    return shapes, np.where(own > 1e-16 * own.max(), own, 0.0), loss


def _in_pose(
    network: Network, free: Array, modes: _Modes, along: tuple[Array, Array, Array, Array | None]
) -> tuple[Array, Array, Array, Array, Array]:
    """Tensions at rest, with inertia, with the vibration; torque beyond rest, holding torque.

    ``along``: time, rates, accelerations, and the torque of the file, None where it gives places.
    """
    (time, rate, acceleration, stated), (shapes, masses, losses) = along, modes
    turns = turns_by_torque(network)
    rubbed = _friction(network, rate) if stated is None else np.zeros_like(rate)
    inertia = acceleration @ network.static_mass
    torque = _torque(turns, free, inertia - rubbed) if stated is None else stated
    even = (torque @ turns + rubbed) @ shapes
    answers = zip(even.T, masses, losses, strict=True)
    swing = np.array([_answer(*one, time[1]) for one in answers]).reshape(-1, time.size).T
    tension = np.array([(piece.start_tension, piece.end_tension) for piece in network.pieces])
    rest = np.broadcast_to(tension, (time.size, *tension.shape))
    mass = (network.impedance * network.time)[::3]
    near, far = acceleration @ network.start[::3].T, acceleration @ network.end[::3].T
    own = np.stack((-mass * (2.0 * near + far), mass * (near + 2.0 * far)), axis=-1) / 6.0
    both = [rest + own + (x @ (network.pull @ shapes).T)[:, :, None] for x in (even, swing)]
    holding = -network.statics.torques[list(network.drive.turned)]
    return rest, both[0], both[1], torque, np.broadcast_to(holding, (time.size, len(turns)))


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
    for friction, row in zip(network.rubs.values, network.rubs.dense, strict=True):
        speed = rate @ row
        slow = max(_TURNING * float(np.abs(speed).max(initial=0.0)), 1e-300)
        total = total - np.outer(friction * np.clip(speed / slow, -1.0, 1.0), row)
    return np.asarray(total)


def _torque(turns: Array, free: Array, need: Array) -> Array:
    """Torque of the motors that gives a motion, shape (t, motors)."""
    reach = turns @ free
    torque = need @ free @ np.linalg.pinv(reach)
    missing = np.abs(torque @ reach - need @ free).max(initial=0.0)
    if missing > _MISSING * np.abs(need @ free).max(initial=0.0):
        said = f"motion: {len(turns)} motors cannot make a motion of {free.shape[1]} freedoms as planned"
        raise InputRefused(f"{said}: plan places that the motors reach")
    return np.asarray(torque)
