"""A planned motion of a machine with routes: its poses, their modes, the pairs that come near resonance."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import ceil, pi

import numpy as np

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import Network, turns_by_torque
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import RoutedDrive, posed
from cabledrive.parameters.route.strain_free import place_of
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM, lost_square, near_pairs, refuse_running
from cabledrive.studies.planned_motion import PlannedMotion
from cabledrive.studies.route_snapshot import Snapshot, snapshot_of, tracked

STEPS_PER_PERIOD = 16
"""Of the highest mode: every mode turns exactly, only its coupling is taken in steps."""
MOST_STEPS = 500_000
POSES = 13
"""At which modes are computed where bodies move; between them they are interpolated."""
STILL = 1e-9
"""Largest motion of a body that leaves the modes alone [m], [rad]."""
_STRAINLESS = 1e-9
_HELD = 1e-3
"""Square of frequency times duration below which a motion without strain counts as free."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RoutePath:
    """A machine along a motion, in equal steps."""

    poses: tuple[dict[str, float], ...]  # places of bodies, one for each snapshot [m], [rad]
    snapshots: tuple[Snapshot, ...]  # all with the same modes in one order
    # time, here: (steps + 1,): [s]; number of the snapshot, with the share on the way to the next
    time: Array
    here: Array
    # torque, pushed: (steps + 1, motors): [N m]; in the middle of each step
    torque: Array
    pushed: Array
    ambiguous: tuple[str, ...] = ()  # modes that change too much between two poses to be followed

    @cached_property
    def driven(self) -> tuple[Array, Array]:
        """Longitudinal modes under the torque, [m sqrt(kg)], and their rates [1/s], shape (steps + 1, q).

        Rotations are exact, damping acts around them.
        """
        h = float(self.time[1] - self.time[0])
        middle = 0.5 * (self.here[1:] + self.here[:-1])
        omega, loss, turn = (self.at(name, middle) for name in ("along", "along_loss", "along_turn"))
        rest = np.einsum("iqm,im->iq", turn, self.pushed) / omega**2
        cosine, sine, decay = np.cos(omega * h), np.sin(omega * h), np.exp(-0.5 * h * loss)
        x, v = np.zeros(omega.shape[1]), np.zeros(omega.shape[1])
        places, rates = np.zeros((self.time.size, x.size)), np.zeros((self.time.size, x.size))
        for i in range(len(omega)):
            v = v * decay[i]
            x, v = (
                rest[i] + (x - rest[i]) * cosine[i] + v / omega[i] * sine[i],
                decay[i] * (v * cosine[i] - (x - rest[i]) * omega[i] * sine[i]),
            )
            places[i + 1], rates[i + 1] = x, v
        return places, rates

    @cached_property
    def swing(self) -> Array:
        """Longitudinal modes in the middle of each step, of fourth order, shape (steps, q)."""
        along, rate = self.driven
        h = float(self.time[1] - self.time[0])
        return np.asarray(0.5 * (along[1:] + along[:-1]) - 0.125 * h * np.diff(rate, axis=0))

    @cached_property
    def _stacked(self) -> dict[str, Array]:
        names = ("along", "along_loss", "along_turn", "across", "across_loss", "across_turn")
        return {
            name: np.array([getattr(one, name) for one in self.snapshots])
            for name in (*names, "coupling", "shape", "strain", "tension")
        }

    def at(self, name: str, here: Array) -> Array:
        """A figure of the snapshots at places along them, the place first."""
        values = self._stacked[name]
        first = np.minimum(here.astype(np.intp), max(len(values) - 2, 0))
        share = (here - first).reshape(-1, *[1] * (values.ndim - 1))
        return np.asarray(
            (1.0 - share) * values[first] + share * values[np.minimum(first + 1, len(values) - 1)]
        )


def path_of(drive: RoutedDrive, motion: PlannedMotion) -> RoutePath:
    """Snapshots along a motion, and the longitudinal modes under its torque from rest."""
    refuse_running(drive, "--motion")
    places = dict(motion.places)
    if not places:
        network = network_of(drive, motor=FREE)
        driven = driven_way(drive, network, motion)
        places = {} if driven is None else places_along(drive, network, driven[0])
    poses, here = poses_along(drive, places, motion.time)
    snapshots, ambiguous = _snapshots(drive, poses)
    highest = max(max(one.along.max(), one.across.max(initial=0.0)) for one in snapshots)
    duration = float(motion.time[-1])
    steps = ceil(duration * highest / (2.0 * pi) * STEPS_PER_PERIOD)
    if steps > MOST_STEPS:
        said = f"motion: {duration:.4g} s of modes up to {highest / (2 * pi):.4g} Hz take {steps} steps"
        raise NotComputed(f"{said}, at most {MOST_STEPS} are made: give a shorter part of the motion")
    time = np.linspace(0.0, duration, steps + 1)
    rows = torques_of(drive, motion)
    middle = 0.5 * (time[1:] + time[:-1])
    torque, pushed = (
        np.column_stack([np.interp(t, motion.time, row) for row in rows]) for t in (time, middle)
    )
    return RoutePath(
        poses=tuple(poses),
        snapshots=tuple(snapshots),
        ambiguous=tuple(ambiguous),
        time=time,
        here=np.interp(time, motion.time, here),
        torque=torque,
        pushed=pushed,
    )


def poses_along(
    drive: RoutedDrive, places: Mapping[str, Array], time: Array
) -> tuple[list[dict[str, float]], Array]:
    """Poses at which modes are computed, fixed places in all, and where between them the motion is."""
    moving = {key: values for key, values in places.items() if np.ptp(values) > STILL}
    fixed = {key: float(values[0]) for key, values in places.items() if key not in moving}
    fixed = {key: value for key, value in fixed.items() if abs(value - place_of(drive, key)) > STILL}
    if not moving:
        return [fixed], np.zeros(time.size)
    if len(moving) == 1:  # on a line: a way back passes the same poses
        ((key, values),) = moving.items()
        grid = np.linspace(values.min(), values.max(), POSES)
        return [fixed | {key: float(one)} for one in grid], np.interp(values, grid, np.arange(POSES))
    scaled = np.array([values / np.ptp(values) for values in moving.values()])
    way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(scaled), axis=0)))
    grid, goes = np.linspace(0.0, way[-1], POSES), np.append(True, np.diff(way) > 0.0)
    poses = [
        fixed | {key: float(np.interp(one, way[goes], values[goes])) for key, values in moving.items()}
        for one in grid
    ]
    return poses, np.interp(way, grid, np.arange(POSES))


def pose_words(drive: RoutedDrive, pose: Mapping[str, float]) -> str:
    """A pose for a refusal, with the places of the file, for whoever gave ways instead of places."""
    return ", ".join(
        f"{key} = {value:.4g} {'rad' if key.endswith('.turn') else 'm'} "
        f"(in the file {place_of(drive, key):.4g})"
        for key, value in pose.items()
    )


def _snapshots(drive: RoutedDrive, poses: list[dict[str, float]]) -> tuple[list[Snapshot], list[str]]:
    """Snapshots with the same modes, followed by their shapes, and modes that could not be followed."""
    first = _snapshot(drive, poses[0], None)
    top = 1.05 * first.top
    found = [first] if len(poses) == 1 else [_snapshot(drive, pose, top) for pose in poses]
    count = min(one.along.size for one in found)
    beside = {key: one for one in found for key in one.keys}

    def between(place: float) -> Snapshot:
        """The snapshot at a place along the poses."""
        number = min(int(place), len(poses) - 2)
        share = place - number
        near, far = poses[number], poses[number + 1]
        pose = {key: (1.0 - share) * near[key] + share * far[key] for key in near}
        own = _snapshot(drive, pose, top)
        return own.with_keys(beside, min(count, own.along.size))

    return tracked([one.with_keys(beside, count) for one in found], between)


def _snapshot(drive: RoutedDrive, pose: dict[str, float], top: float | None) -> Snapshot:
    try:
        return snapshot_of(posed(drive, pose) if pose else drive, top)
    except InputRefused as refusal:
        if not pose:
            raise
        where = ", ".join(f"{key} = {value:.4g}" for key, value in pose.items())
        raise InputRefused(f"motion: at {where}: {refusal}; give places as columns") from None


def places_along(drive: RoutedDrive, network: Network, way: Array) -> dict[str, Array]:
    """Place of every body where the coordinates go a way, shape (m, n): (m,) by key [m], [rad]."""
    keys = [f"{body.name}.{move}" for body in drive.body for move in body.moves]
    return {key: place_of(drive, key) + way @ network.motion.dense(key)[0] for key in keys}


def strainless(network: Network) -> Array:
    """Motions of the coordinates that strain no rope, joint or spring, shape (n, k)."""
    rows = np.vstack((-network.stretch, network.springs.dense))
    size = np.abs(rows).max(axis=0)  # a column of metres and one of radians count alike
    scale = 1.0 / np.where(size > 0.0, size, 1.0)
    _, values, vectors = np.linalg.svd(rows * scale)
    rank = int(np.sum(values > _STRAINLESS * values[0]))
    return np.asarray(scale[:, None] * vectors[rank:].T)


def driven_way(drive: RoutedDrive, network: Network, motion: PlannedMotion) -> tuple[Array, Array] | None:
    """Where the torque takes the coordinates of the machine from rest, without friction, and their rates.

    None where weights or directions of ropes hold it against the torque.
    """
    free = strainless(network)
    mass = free.T @ network.static_mass @ free
    held = np.linalg.solve(mass, free.T @ network.static_stiffness @ free)
    if np.abs(held).max(initial=0.0) * motion.time[-1] ** 2 > _HELD:
        return None
    from scipy.integrate import cumulative_trapezoid  # a third of a second, for moving bodies alone

    push = np.column_stack(torques_of(drive, motion)) @ turns_by_torque(network) @ free
    pulled = np.asarray(np.linalg.solve(mass, push.T).T)
    speed = cumulative_trapezoid(pulled, motion.time, axis=0, initial=0.0)
    way = cumulative_trapezoid(speed, motion.time, axis=0, initial=0.0)
    return way @ free.T, speed @ free.T


def torques_of(drive: RoutedDrive, motion: PlannedMotion) -> list[Array]:
    """Torque of each motor over the motion's time [N m]."""
    others = [drive.pulley[number].name for number in drive.turned[1:]]
    return [motion.torque, *(motion.torques.get(name, np.zeros(motion.time.size)) for name in others)]


INSTANTS = 2000


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """A longitudinal mode and the one or two transverse modes that it comes near to exciting."""

    kind: str  # {"1:2", "sum"}
    # span, plane: of the first transverse mode
    span: str
    plane: str
    # longitudinal_hz, transverse_hz: where the amplitude is the largest share of the threshold [Hz]
    longitudinal_hz: float
    transverse_hz: tuple[float, float]
    # lowest and highest longitudinal frequency minus the sum of the transverse ones [Hz]
    detuning_hz: tuple[float, float]
    passes: bool  # whether it goes through resonance
    amplitude: float  # amplitude of the longitudinal mode over its threshold, the largest along the motion
    time: float  # when [s]


def passages_of(path: RoutePath) -> tuple[Passage, ...]:
    """Every pair that comes near resonance along a motion, the largest amplitude over its threshold first."""
    if not path.snapshots[0].keys:
        return ()
    picked = np.unique(np.linspace(0, path.time.size - 1, INSTANTS).astype(np.intp))
    here = path.here[picked]
    names = ("along", "across", "across_loss", "coupling")
    along, across, loss, coupling = (path.at(name, here) for name in names)
    # Of each longitudinal mode about where the torque holds it.
    omega, turn = path.at("along", path.here), path.at("along_turn", path.here)
    rest = np.einsum("iqm,im->iq", turn, path.torque) / omega**2
    amplitude = np.hypot(path.driven[0] - rest, path.driven[1] / omega)[picked]
    strength, hertz = np.abs(coupling).max(axis=0), (along / (2.0 * pi), across / (2.0 * pi))
    found = []
    for q, natural in enumerate(along.T):
        detunings = natural[:, None, None] - across[:, :, None] - across[:, None, :]
        crossed = np.ptp(np.sign(detunings), axis=0) > 0.0
        off = np.abs(detunings / natural[:, None, None]).min(axis=0)
        for i, j in near_pairs(strength[q], np.where(crossed, 0.0, off)):
            detuning = detunings[:, i, j]
            least = lost_square(0.5 * loss[:, i], 0.5 * loss[:, j], detuning)
            threshold = 4.0 * np.sqrt(across[:, i] * across[:, j] * least)
            share = np.abs(coupling[:, q, i, j]) * amplitude[:, q] / np.maximum(threshold, 1e-300)
            when = int(np.argmax(share))
            span, plane, _ = path.snapshots[0].keys[i]
            found.append(
                Passage(
                    kind=ONE_TO_TWO if i == j else SUM,
                    span=span,
                    plane=plane,
                    longitudinal_hz=float(hertz[0][when, q]),
                    transverse_hz=(float(hertz[1][when, i]), float(hertz[1][when, j])),
                    detuning_hz=(float(detuning.min()) / (2.0 * pi), float(detuning.max()) / (2.0 * pi)),
                    passes=bool(detuning.min() <= 0.0 <= detuning.max()),
                    amplitude=float(share[when]),
                    time=float(path.time[picked[when]]),
                )
            )
    return tuple(sorted(found, key=lambda one: -one.amplitude))
