"""Everything that is decided before the first step of a run in which bodies travel."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from math import degrees
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network, network_of
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning, nearest
from cabledrive.parameters.route import RoutedDrive, moved
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.methods import TimeGrid
from cabledrive.simulation.network.case import slides
from cabledrive.simulation.plan import SLACK
from cabledrive.simulation.prepared import PreparedRun
from cabledrive.simulation.signals import Signal
from cabledrive.simulation.start import Recording, Scheme
from cabledrive.simulation.travel.plan import (
    NO_SPAN,
    OFF_THE_PULLEY,
    TALLIES,
    TOO_SHORT,
    TravelPlan,
    TravelState,
    TravelWorkspace,
    new_travel_workspace,
)
from cabledrive.trajectories import smooth_rise


def travel_channels(
    names: tuple[str, ...], motors: tuple[str, ...], spans: tuple[str, ...]
) -> tuple[Channel, ...]:
    """Columns of a record, in order."""
    units = ["m" if slides(name) else "rad" for name in names]
    both = list(zip(names, units, strict=True))
    found = [Channel(name, unit, f"place of {name} from the pose of the file") for name, unit in both]
    found += [Channel(f"speed of {name}", f"{unit}/s", f"speed of {name}") for name, unit in both]
    found += [Channel(f"torque on {name}", "N m", f"torque of the motor of {name}") for name in motors]
    found += [
        Channel(f"mean tension, {one}", "N", f"tension of {one} with its damping, mean along it")
        for one in spans
    ]
    found += [
        Channel(f"least tension, {one}", "N", f"least tension of {one} with its damping") for one in spans
    ]
    found += [Channel(f"free length, {one}", "m", f"free length of {one}") for one in spans]
    return (
        *found,
        Channel("rope_energy", "J", "kinetic energy of the ropes in their spans"),
        Channel("body_energy", "J", "kinetic energy of bodies, pulleys and motors, of drums with their rope"),
        Channel("strain_energy", "J", "elastic energy of the ropes in their spans"),
        Channel("spring_energy", "J", "energy of springs, weights and loads above that at rest"),
        Channel("torque_work", "J", "work of the torques since the start"),
        Channel("weight_work", "J", "work of the ropes' weight since the start"),
        Channel("axial_loss", "J", "energy lost to axial damping of the ropes since the start"),
        Channel("viscous_loss", "J", "energy lost to bearings, bodies and joints since the start"),
        Channel("coulomb_loss", "J", "energy lost to Coulomb friction since the start"),
        Channel("creep_loss", "J", "energy lost where rope creeps on pulleys, since the start"),
        Channel("wound_energy", "J", "energy that rope took onto rims and drums since the start"),
        Channel("balance", "J", "energies plus losses minus works: constant if the budget closes"),
    )


POSES = 25
_SMALL = 1e-7


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """Poses over the part of a move that is done, from 0 to 1."""

    part: Array  # (poses,)
    places: Array  # (poses, n): coordinates from the pose of the file, without strain beyond that at rest
    shortest: Array  # (spans,): least free length of each span [m]
    networks: list[Network]  # the machine at a few poses, first and last among them

    def turns(self, part: Array, coordinate: int) -> Array:
        """Turn of a rotor where parts of the move are done, shape (p,) [rad]."""
        from scipy.interpolate import CubicSpline  # here, for asking for help does not need it

        return np.asarray(CubicSpline(self.part, self.places[:, coordinate])(part), dtype=np.float64)


def way_of(drive: RoutedDrive, moves: Mapping[str, float]) -> Way:
    """Poses through which bodies go by their distances [m]; other bodies follow or keep their places.

    Raises `InputRefused` if the machine cannot be in one of them, or moves do not go together.
    """
    network = network_of(drive, motor="free")
    names = network.motion.names
    slides = [f"{body.name}.{move}" for body in drive.body for move in body.moves if move != "turn"]
    for name, distance in moves.items():
        if name not in slides:
            raise InputRefused(f'move: "{name[:60]}" slides no body{nearest(name[:60], slides)}')
        if not np.isfinite(distance):
            raise InputRefused(f"move {name} = {distance} m must be finite: give a distance")
    if not any(moves.values()):
        raise InputRefused("move: no body moves: give a distance, such as car.y=10m")
    places, networks = [np.zeros(len(names))], [network]
    part = np.linspace(0.0, 1.0, POSES)
    for step in np.diff(part):  # second order: rates at the middle of each step
        half = places[-1] + 0.5 * step * _rates(networks[-1], moves, slides)
        middle = _posed(drive, half, names, slides)
        places.append(places[-1] + step * _rates(middle, moves, slides))
        networks.append(_posed(drive, places[-1], names, slides))
    lengths = np.array([[span.length for span in one.drive.free_spans] for one in networks])
    return Way(
        part=part, places=np.array(places), shortest=lengths.min(axis=0), networks=networks[:: POSES // 4]
    )


def _posed(drive: RoutedDrive, place: Array, names: tuple[str, ...], slides: list[str]) -> Network:
    """The machine with its bodies at a place."""
    at = {f"{body.name}.{axis}": body.at["xy".index(axis)] for body in drive.body for axis in "xy"}
    pose = {name: at[name] + float(place[names.index(name)]) for name in slides}
    try:
        return network_of(moved(drive, pose), motor="free")
    except InputRefused as refusal:
        raise InputRefused(f"move: {refusal}") from None


def _rates(network: Network, moves: Mapping[str, float], slides: list[str]) -> Array:
    """Rates of all coordinates where bodies move and neither a rope nor a spring is strained."""
    names = network.motion.names
    along = network.direction == 0
    strained = np.vstack([network.start[along] - network.end[along], network.spring_rows])
    _, sizes, rows = np.linalg.svd(strained)
    rank = int(np.sum(sizes > _SMALL * sizes[0]))
    free = rows[rank:].T  # motions that strain nothing, shape (n, m)
    wanted: list[tuple[Array, float]] = []
    for name in (*moves, *(name for name in slides if name not in moves)):
        row, value = free[names.index(name)], moves.get(name, 0.0)
        known = np.array([other for other, _ in wanted]).reshape(-1, free.shape[1])
        share, *_ = np.linalg.lstsq(known.T, row, rcond=None) if len(known) else (np.zeros(0),)
        if np.linalg.norm(row - known.T @ share) > _SMALL:
            wanted.append((row, value))
        elif name in moves and abs(share @ np.array([v for _, v in wanted]) - value) > _SMALL * abs(value):
            raise InputRefused(
                f"move: {name} cannot go {value:.6g} m without straining a rope or a spring: leave it out, "
                "as it follows the others, or give the distance that they leave it"
            )
    matrix, values = np.array([row for row, _ in wanted]), np.array([value for _, value in wanted])
    share, *_ = np.linalg.lstsq(matrix, values, rcond=None)
    return np.asarray(free @ share)


ORDER = 9
"""Of the rise of a move: smooth up to its fourth derivative."""


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedMove:
    """Bodies that go somewhere, led by the turns of the motors."""

    moves: Mapping[str, float] = meaning('by coordinate, such as "car.y" [m]')
    rise: float = meaning("time that the move takes [s]; the motors rest from then on")


@dataclass(frozen=True, kw_only=True, eq=False)
class TravelCase(PreparedRun):
    """A run that has not begun."""

    network: Network
    scheme: Scheme
    recording: Recording
    grid: TimeGrid
    plan: TravelPlan
    names: tuple[str, ...]  # of the coordinates
    motors: tuple[str, ...]  # pulleys of the motors
    move: PlannedMove | None  # None: the torques are given
    way: Way | None
    torques: tuple[Signal, ...]  # of each motor beyond what holds the machine at rest
    holding: Array  # (motors,): what holds it [N m]
    x: Array  # places of the cells at rest [m]
    length: Array  # unstretched lengths of the spans at rest [m]
    q_t: Array  # (n,): speeds at t = 0

    @cached_property
    def spans(self) -> tuple[str, ...]:
        """Names of the spans."""
        return tuple(span.name for span in self.network.drive.free_spans)

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Columns of a record."""
        return travel_channels(self.names, self.motors, self.spans)

    @property
    def width(self) -> int:
        """Numbers per record."""
        return len(self.channels)

    @property
    def machine(self) -> RoutedDrive:
        """The drive of the run."""
        return self.network.drive

    @property
    def nodes(self) -> int:
        """Cells of all spans."""
        return int(self.plan.cells[-1])

    @property
    def law_name(self) -> str:
        """Name of the cable law."""
        return "exact"

    @property
    def settings(self) -> dict[str, Any]:
        """Move, torques and start."""
        return {
            "move": None if self.move is None else [dict(self.move.moves), self.move.rise],
            "torque": [signal.fingerprint for signal in self.torques],
            "start": sha256(self.q_t.tobytes()).hexdigest(),
        }

    @cached_property
    def work(self) -> TravelWorkspace:
        """Work space of the steps."""
        return new_travel_workspace(self.plan)

    def integrate(
        self, state: TravelState, inputs: list[Array], every: int, rows: Array, fields: Array
    ) -> int:
        """Take the steps, the first of every ``every`` recorded; why they end."""
        from cabledrive.simulation.travel.kernels import integrate_travel

        return int(integrate_travel(self.plan, state, self.work, inputs[0], every, rows))

    def why(self, code: int, state: TravelState, before: TravelState, inputs: tuple[Array, ...]) -> str:
        """Why steps ended early, in one line."""
        when = f"at t = {state.counts[0] * self.grid.step:.6g} s"
        number, figure = int(state.events[0, 0]), float(state.events[0, 1])
        span = self.network.drive.free_spans[number]
        words = {
            SLACK: f"span {span.name} goes slack {when}: move more slowly, or raise pretension",
            TOO_SHORT: f"span {span.name} is {figure:.4g} m long {when}: the step of {self.grid.step:.4g} s "
            f"is stable down to {self.plan.shortest[number]:.4g} m: go less far",
            OFF_THE_PULLEY: f"the rope leaves {span.end.name} {when} (wrap {degrees(figure):.3g} deg): go "
            "less far",
            NO_SPAN: f"span {span.name} has no free length any more {when}: go less far",
        }
        return words.get(code, f"diverged {when}: lower the input, or give a smaller step")

    def inputs(self, first: int, steps: int) -> tuple[Array]:
        """Torques of the motors at the times of some steps [N m], or their speeds over them [rad/s]."""
        number = np.arange(first, first + steps + 1, dtype=np.float64)
        time = number * self.grid.step
        if self.move is None or self.way is None:
            return (np.stack([signal.at(time[:-1]) for signal in self.torques], axis=1) + self.holding,)
        # The state lies half a step behind its speeds: turns at the times of the steps, speeds between them.
        part = smooth_rise(np.minimum(time / self.move.rise, 1.0), ORDER)[0]
        turns = np.stack([self.way.turns(part, int(rotor)) for rotor in self.plan.rotor], axis=1)
        return (np.asarray(np.diff(turns, axis=0) / self.grid.step),)

    def first_state(self) -> TravelState:
        """State before the first step: speeds half a step before the start."""
        plan, n, spans = self.plan, len(self.names), len(self.spans)
        q_t = self.q_t.copy()
        if not plan.prescribed:
            force = np.zeros(n)
            force[plan.rotor] = self.inputs(0, 1)[0][0] - self.holding
            q_t -= 0.5 * self.grid.step * np.linalg.solve(plan.mass, force - plan.damping @ self.q_t)
        ends = np.einsum("sin,n->si", self._rows_at_rest, self.q_t)
        speeds = [
            ends[s, 0] + (ends[s, 1] - ends[s, 0]) * (np.arange(count) + 0.5) / count
            for s, count in enumerate(np.diff(plan.cells))
        ]
        return TravelState(
            x=self.x.copy(),
            x_t=np.concatenate(speeds),
            q=np.zeros(n),
            q_t=q_t,
            length=self.length.copy(),
            flow=np.zeros((spans, 2)),
            wound=np.zeros((spans, 2)),
            tallies=np.zeros((2, TALLIES)),
            extremes=np.stack([np.full(n, np.inf), np.full(n, -np.inf)]),
            reached=np.stack([np.full(spans, np.inf), np.zeros(spans)]),
            events=np.zeros((1, 2)),
            counts=np.zeros(1, dtype=np.int64),
        )

    @property
    def _rows_at_rest(self) -> Array:
        along = self.plan.bearing
        return np.asarray(np.einsum("sc,sicn->sin", along, self.plan.frame) + self.plan.turn)
