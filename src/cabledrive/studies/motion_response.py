"""Response of ropes, pulleys and bodies to a planned motion: every mode that it can excite."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network import network_of, statics_of
from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.rest import rest_state
from cabledrive.modal import Mode
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route import posed
from cabledrive.reduction import sagging_model as sagging
from cabledrive.reduction.stretches import StretchModel
from cabledrive.reduction.waves import Waves, waves_of
from cabledrive.studies import excited_modes as excited
from cabledrive.studies import motion_stages as staged
from cabledrive.studies.motion_snapshot import Snapshot, longitudinal_of, snapshot_of, tracked
from cabledrive.studies.pair_thresholds import refuse_running
from cabledrive.studies.planned_motion import PlannedMotion, machine_at

HIGHEST = 80
"""Transverse modes of a row that are looked at, and of a section on average."""
SHORTEST = 1.0 / 40.0
"""Travel time of a section over the longest below which its own modes are not looked for."""

MOST_MODES = 20
"""Transverse modes of a row that are kept."""

FEWEST_ALONG, MOST_ALONG = 4, 10
MOST_FAMILY = 500.0
"""Content of a torque, over the lowest longitudinal frequency, up to which modes are searched for."""

STEPS_PER_PERIOD = 16
FEWEST_STEPS, MOST_STEPS = 4, 20_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PreparedMotion:
    """A motion, and the coefficients of the model along it."""

    h: float  # step [s]
    # time, torque: (steps,), (steps, motors): [s], and the torque above the holding torque [N m]
    time: Array
    torque: Array
    here: Array  # (steps,): number of the pose, with the share on the way to the next
    models: tuple[StretchModel, ...]  # one in each pose
    # of the modes in each row: span, unstretched ends [m], plane, number among those
    places: tuple[tuple[tuple[int, tuple[float, float], str, int], ...], ...]
    driven: bool  # whether places of bodies follow from the torque
    steepest: float  # largest slope of the sag [-]
    ambiguous: tuple[str, ...]  # modes that change too much between two poses to be followed
    complete: bool  # whether all transverse modes that the motion can excite are kept
    # instants [s] and longitudinal amplitudes about where the torque holds them, without transverse modes
    swing: tuple[Array, Array]

    def response(
        self,
        *,
        floor: float = 0.0,
        phase: float = 0.0,
        detuned: float = 0.0,
        torque: float = 1.0,
        parametric: bool = True,
    ) -> staged.Extremes:
        """Largest displacements along the motion; ``floor`` [m] of every mode begins at ``phase`` [rad]."""
        models = [model._replace(transverse=(1.0 + detuned) * model.transverse) for model in self.models]
        if not parametric:
            models = [m._replace(coupling=0.0 * m.coupling, square=0.0 * m.square) for m in models]
        stages = list(staged.stages_along(models, self.here, torque * self.torque))
        return staged.integrate(stages, self.h, floor=floor, phase=phase)[0]


class _Course:
    """A machine along a motion: its poses and what it is in each."""

    def __init__(self, machine: Machine, motion: PlannedMotion) -> None:
        self.motion, self.machine = motion, machine
        refuse_running(self.machine, "--motion")
        places = dict(motion.places)
        if self.machine.body and not places:
            network = network_of(self.machine, motor=FREE)
            driven = staged.driven_way(self.machine, network, motion)
            places = {} if driven is None else staged.places_along(self.machine, network, driven[0])
        columns = {name: getattr(motion, name) for name in ("pretension", "carriage", "load_torque")}
        places |= {name: values for name, values in columns.items() if values is not None}
        self.poses, here = staged.poses_along(self.machine, places, motion.time)
        self.here, self.driven = here, len(self.poses) > 1 and not motion.places and not motion.changes

    def network(self, pose: Mapping[str, float]) -> tuple[Network, float]:
        """The machine in a pose, and the torque that holds it there as far as the motion's has it [N m]."""
        machine = machine_at(self.machine, pose)
        load, moved = pose.get("load_torque", 0.0), {k: v for k, v in pose.items() if "." in k}
        torques = {1: machine.sense * load} if load else {}
        try:
            machine = posed(machine, moved) if moved else machine
            network = network_of(machine, motor=FREE, statics=statics_of(machine, torques=torques))
        except InputRefused as refusal:
            if not moved:
                raise
            where = ", ".join(f"{key} = {value:.4g}" for key, value in moved.items())
            raise InputRefused(f"motion: at {where}: {refusal}; give places as columns") from None
        if not self.machine.angles:  # of routes, whose torque is that beyond what holds it
            return network, 0.0
        at_torque = -load * machine.pulley[0].radius / machine.pulley[1].radius
        offset = machine.sense * machine.motor[0].offset_torque if machine.motor else 0.0
        return network, rest_state(machine, at_torque=at_torque).holding_torque - offset


def prepare(drive: Machine, motion: PlannedMotion, *, floor: float = 1e-5) -> PreparedMotion:
    """State of rest and modes that a motion can excite above a ``floor`` [m], along the motion."""
    course = _Course(drive, motion)
    networks, holding = zip(*(course.network(pose) for pose in course.poses), strict=True)
    stated = course.machine.sense * np.column_stack(staged.torques_of(course.machine, motion))

    def torque_at(time: Array) -> Array:
        """Torque above the holding torque at some instants, shape (n, motors) [N m]."""
        here = np.interp(time, motion.time, course.here)
        held = course.machine.sense * np.interp(here, np.arange(len(holding)), holding)
        found = np.column_stack([np.interp(time, motion.time, own) for own in stated.T])
        return found - held[:, None] * (np.arange(found.shape[1]) == 0)

    even = np.linspace(0.0, motion.time[-1], max(motion.time.size, 256))
    size = np.linalg.norm(excited.amplitudes(torque_at(even)), axis=1)
    total = np.cumsum(size**2)
    place = 1  # of the frequency below which 99.9 % of the torque's power lies [rad/s]
    if total[-1] > 0.0:
        place = min(int(np.searchsorted(total, 0.999 * total[-1])) + 2, total.size - 1)
    content = 2 * pi * place / float(motion.time[-1])
    along = longitudinal_of(networks[0], MOST_ALONG)
    if not along:
        raise InputRefused("motion: no longitudinal mode moves a pulley or a body: it changes no tension")
    lowest = 2.0 * pi * along[0].frequency
    fast = content > MOST_FAMILY * lowest
    if fast:  # before so many modes are searched for
        _grid(motion, lowest)
        _grid(motion, content)
        content = MOST_FAMILY * lowest
    kept = max(FEWEST_ALONG, sum(2 * pi * mode.frequency < 1.5 * content for mode in along))
    along = along[:kept]
    h, time = _grid(motion, max(2 * pi * along[-1].frequency, content))
    here, torque = np.interp(time, motion.time, course.here), torque_at(time)
    first = waves_of(networks[0], list(along), [])
    still = [sagging.sagging_model(first, [])]
    history = staged.integrate([(still[0], torque)], h, history=True)[1]
    lines = excited.lines_of(history, still[0], h)
    top = _reach(lines, first, networks, floor)
    snapshots, ambiguous = _snapshots(course, networks, along, top)
    waves = [one.waves() for one in snapshots]
    rows, complete = _chosen(snapshots, waves, lines, floor)
    if len(snapshots) > 1:
        still = [sagging.sagging_model(own, []) for own in waves]
        history = staged.integrate(list(staged.stages_along(still, here, torque)), h, history=True)[1]
    kept_keys = [snapshots[0].keys[i] for own, _ in rows for i in own]
    named = ("longitudinal", *(f"mode {n} of {span} ({plane}) between" for span, plane, _, n in kept_keys))
    models = _models(snapshots, rows, top)
    fastest = max(*(float(np.max(m.natural)) for m in models), *(float(m.transverse.max()) for m in models))
    swing = time, _swing(history, still, here, torque, h)
    h, time = _grid(motion, max(fastest, content))
    return PreparedMotion(
        h=h,
        time=time,
        torque=torque_at(time),
        here=np.interp(time, motion.time, course.here),
        models=models,
        places=tuple(tuple(_place(snapshots[0], i) for i in own) for own, _ in rows),
        driven=course.driven,
        steepest=max(float(np.abs(sagging.sag_slopes(own)[0]).max()) for own in waves),
        ambiguous=tuple(words for words in ambiguous if words.startswith(named)),
        complete=complete and not fast,
        swing=swing,
    )


def _reach(
    lines: tuple[Array, Array, float], waves: Waves, networks: Sequence[Network], floor: float
) -> float:
    """Frequency up to which transverse modes are looked for [rad/s]: what a line can excite, the first."""
    times = np.array([_crossing_times(one) for one in networks]).max(axis=0)
    times = times[times >= SHORTEST * times.max()]
    most = (HIGHEST + 0.5) * times.size * pi / times.sum()
    (size, omega, duration), network = lines, waves.network
    speed = float((waves.length / network.time[1::3]).max())
    loss = min(piece.rope.transverse_damping for piece in network.pieces)
    shaken = size * float(np.abs(sagging.sag_slopes(waves)[0]).max()) * speed
    shaken = shaken * np.minimum(1.0 / max(loss, 1e-300), 0.5 * duration)
    direct = omega[(shaken > excited.LEAST_SHARE * floor) | (size > 0.5 * excited.STRONG)].max(initial=0.0)
    pumped = omega[0.125 * omega * size * duration > 0.5 * excited.LEAST_GROWTH].max(initial=0.0)
    return max(min(max(1.1 * direct, 0.6 * pumped), most), (excited.ALWAYS + 0.5) * pi / times.min())


def _crossing_times(network: Network) -> list[float]:
    """Time that a transverse wave takes along each section between held places [s]."""
    ends = np.cumsum([len(own) for own in network.sections])[:-1]
    return [float(times.sum()) for times in np.split(network.time[1::3], ends)]


def _snapshots(
    course: _Course, networks: Sequence[Network], along: tuple[Mode, ...], top: float
) -> tuple[list[Snapshot], list[str]]:
    """Snapshots with the same modes, followed by their shapes, and modes that could not be followed."""
    first = snapshot_of(networks[0], along, top, shapes=len(networks) > 1)
    if len(networks) == 1:
        return [first], []
    found = [first, *(snapshot_of(one, longitudinal_of(one, len(along)), top) for one in networks[1:])]
    count, beside = min(len(one.along) for one in found), {key: one for one in found for key in one.keys}

    def halfway(place: float) -> Snapshot:
        """The snapshot at a place along the poses."""
        number = min(int(place), len(found) - 2)
        share, near, far = place - number, course.poses[number], course.poses[number + 1]
        network, _ = course.network({key: (1.0 - share) * near[key] + share * far[key] for key in near})
        own = snapshot_of(network, longitudinal_of(network, count), top)
        return own.with_keys(beside, min(count, len(own.along)))

    return tracked([one.with_keys(beside, count) for one in found], halfway)


def _chosen(
    snapshots: Sequence[Snapshot], waves: Sequence[Waves], lines: tuple[Array, Array, float], floor: float
) -> tuple[list[tuple[list[int], NDArray[np.intp]]], bool]:
    """Rows of modes that a motion can excite, with the pieces that they move; whether these are all."""
    first = snapshots[0]
    pieces = first.network.pieces
    moving = np.array([np.isin(np.arange(len(pieces)), own) for own in first.pieces])
    hertz = [[np.nan if mode is None else mode.frequency for mode in one.across] for one in snapshots]
    omega = 2.0 * pi * np.array(hertz)
    loss = np.array([piece.rope.transverse_damping for piece in pieces])
    planes = np.array([key[1] for key in first.keys])
    found, complete = [], True
    for members in sagging.rows_of(planes, moving) if len(first.keys) else []:
        own_pieces = np.flatnonzero(moving[members].any(axis=0))
        chosen = dict[int, None]()
        for number in sorted({0, len(snapshots) // 2, len(snapshots) - 1}):
            here = members[np.isfinite(omega[number, members])]
            here = here[np.argsort(omega[number, here])][:HIGHEST]
            speeds = waves[number].length / waves[number].network.time[1::3]
            steep = np.abs(sagging.sag_slopes(waves[number])[0][own_pieces]).max()
            row = excited.Row(
                omega=omega[number, here],
                loss=float(loss[own_pieces].min()),
                speed=float(speeds[own_pieces].max()),
                steep=float(steep) if planes[members[0]] == "w" else 0.0,
            )
            chosen |= dict.fromkeys(int(here[i]) for i in excited.excited_modes(row, lines, floor))
        complete &= len(chosen) <= MOST_MODES
        found.append((sorted(list(chosen)[:MOST_MODES]), own_pieces))
    return found, complete


def _place(one: Snapshot, number: int) -> tuple[int, tuple[float, float], str, int]:
    """Of a mode across: span, unstretched ends of what can move of it [m], plane, number."""
    (name, plane, _, count), pieces = one.keys[number], one.network.pieces
    span = one.network.drive.spans.index(name)
    own = [pieces[i].unstretched for i in one.pieces[number] if pieces[i].span == span]
    return span, (own[0][0], own[-1][1]), plane, count


def _models(
    snapshots: Sequence[Snapshot], rows: Sequence[tuple[list[int], NDArray[np.intp]]], top: float
) -> tuple[StretchModel, ...]:
    """The model in each pose; a mode that is not there stands at ``top`` [rad/s] and nothing couples it."""
    every = [i for own, _ in rows for i in own]
    waves = [one.waves(every) for one in snapshots]
    labels = np.array([sagging.strands_of(own) for own in waves])
    strands = np.unique(labels, axis=1, return_inverse=True)[1].ravel()
    models = []
    for one, own in zip(snapshots, waves, strict=True):
        place = {i: n for n, i in enumerate(i for i in every if one.across[i] is not None)}
        placed = [([place.get(i, -1) for i in members], pieces) for members, pieces in rows]
        models.append(sagging.sagging_model(own, placed, strands))
    for row, (members, _) in enumerate(rows):
        for slot, i in enumerate(members):
            here = [n for n, one in enumerate(snapshots) if one.across[i] is not None]
            for number, model in enumerate(models):
                if number not in here:
                    other = models[min(here, key=lambda n: abs(n - number))]
                    model.transverse[row, slot] = top
                    for name in ("mass", "loss", "probes"):
                        getattr(model, name)[row, slot] = getattr(other, name)[row, slot]
    return tuple(models)


def _swing(history: Array, still: Sequence[StretchModel], here: Array, torque: Array, h: float) -> Array:
    """Amplitude of each longitudinal mode about where the torque holds it, (steps, k); zero if rigid."""
    natural, shape = (
        staged.interpolated([getattr(one, of) for one in still], here) for of in ("natural", "torque_shape")
    )
    place, elastic = history[:, : natural.shape[1]], natural > 0.0
    safe = np.where(elastic, natural, 1.0)
    rest = np.einsum("tkm,tm->tk", shape, torque) / safe**2
    return np.where(elastic, np.hypot(place - rest, np.gradient(place, h, axis=0) / safe), 0.0)


def _grid(motion: PlannedMotion, fastest: float) -> tuple[float, Array]:
    per_second = fastest * STEPS_PER_PERIOD / (2 * pi)
    wanted = float(ceil(motion.time[-1] * per_second))
    if not FEWEST_STEPS <= wanted <= MOST_STEPS:
        raise InputRefused(
            f"motion: lasts {motion.time[-1]:.4g} s, which takes {wanted:.3g} steps; it is judged from "
            f"{FEWEST_STEPS / per_second:.3g} s to {MOST_STEPS / per_second:.4g} s: plan one of that length"
        )
    h = float(motion.time[-1]) / int(wanted)
    return h, h * np.arange(int(wanted), dtype=np.float64)
