"""Everything that is decided before the first step of a run in which bodies travel."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network, network_of
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.fields import described, meaning, nearest
from cabledrive.parameters.route import Machine, moved
from cabledrive.parameters.route.strain_free import turns_between
from cabledrive.simulation.plan import SLACK
from cabledrive.simulation.prepared import Outcome, PreparedRun, extremes_of, reached
from cabledrive.simulation.result import SimulationResult, neglected
from cabledrive.simulation.travel.plan import (
    DENSITY,
    NO_SPAN,
    OFF_THE_PULLEY,
    ROPES,
    TALLIES,
    TOO_SHORT,
    TravelPlan,
    TravelState,
    TravelWorkspace,
    new_travel_workspace,
)
from cabledrive.trajectories.limits import smooth_rise

POSES = 25


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """Poses over the part of a move that is done, from 0 to 1."""

    part: Array  # (poses,)
    turned: Array  # (poses, pulleys): from the pose of the file, without strain beyond that at rest [rad]
    shortest: Array  # (spans,): least free length of each span [m]
    networks: list[Network]  # the machine at a few poses, first and last among them

    def turns(self, part: Array, pulley: int) -> Array:
        """Turn of a pulley where parts of the move are done, shape (p,) [rad]."""
        from scipy.interpolate import CubicSpline  # here, for asking for help does not need it

        return np.asarray(CubicSpline(self.part, self.turned[:, pulley])(part), dtype=np.float64)


def way_of(drive: Machine, moves: Mapping[str, float]) -> Way:
    """Poses through which bodies go by their distances [m]; other bodies follow or keep their places.

    Raises `InputRefused` if the machine cannot be in one of them, or moves do not go together.
    """
    slides = [(body, move) for body in drive.body for move in body.moves if move != "turn"]
    at = {f"{body.name}.{move}": body.at["xy".index(move)] for body, move in slides}
    for name, distance in moves.items():
        if name not in at:
            raise InputRefused(f'move: "{name[:60]}" slides no body{nearest(name[:60], at)}')
        if not np.isfinite(distance):
            raise InputRefused(f"move {name} = {distance} m must be finite: give a distance")
    if not any(moves.values()):
        raise InputRefused("move: no body moves: give a distance, such as car.y=10m")
    part = np.linspace(0.0, 1.0, POSES)
    try:
        poses = [moved(drive, {name: at[name] + one * way for name, way in moves.items()}) for one in part]
        networks = [network_of(pose, motor="free") for pose in poses[:: POSES // 4]]
    except (InputRefused, NotComputed) as refusal:
        raise InputRefused(f"move: {refusal}") from None
    return Way(
        part=part,
        turned=np.array([turns_between(drive, pose) for pose in poses]),
        shortest=np.array([[span.length for span in pose.free_spans] for pose in poses]).min(axis=0),
        networks=networks,
    )


ORDER = 9
"""Of the rise of a move: smooth up to its fourth derivative."""


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedMove:
    """Bodies that go somewhere, led by the turns of the motors."""

    moves: Mapping[str, float] = meaning('by coordinate, such as "car.y" [m]')
    rise: float = meaning("time that the move takes [s]; the motors rest from then on")


PARALLEL = 1e-3
"""Sine of the angle by which spans may turn without inertia of the ropes across them counting."""

_ASSUMPTIONS = (
    "ropes are straight between pulleys: no vibration across them, no sag",
    "ropes stick to pulleys (see the friction that needs) and have no mass on them; on a drum they stay in "
    "one layer and keep the tension of their span",
)
_ACROSS = "ropes have weight but no inertia across their spans"


@dataclass(frozen=True, kw_only=True, eq=False)
class TravelCase(PreparedRun):
    """A run that has not begun; torques: beyond what holds the machine at rest, which is ``holding``."""

    network: Network
    plan: TravelPlan
    names: tuple[str, ...]  # of the coordinates
    motors: tuple[str, ...]  # pulleys of the motors
    spans: tuple[str, ...]
    move: PlannedMove | None  # None: the torques are given
    way: Way | None
    x: Array  # places of the cells at rest [m]
    length: Array  # unstretched lengths of the spans at rest [m]
    q_t: Array  # (n,): speeds at t = 0

    @property
    def nodes(self) -> int:
        """Cells of all ropes."""
        return int(self.plan.cells[-1])

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

    def why(self, code: int, state: TravelState) -> str:
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

    def inputs(self, first: int, steps: int) -> tuple[Array, ...]:
        """Torques of the motors at the times of some steps [N m], or their speeds over them [rad/s]."""
        if self.move is None or self.way is None:
            return super().inputs(first, steps)
        time = np.arange(first, first + steps + 1, dtype=np.float64) * self.grid.step
        # The state lies half a step behind its speeds: turns at the times of the steps, speeds between them.
        part = smooth_rise(np.minimum(time / self.move.rise, 1.0), ORDER)[0]
        driven = self.network.drive.turned
        turns = np.stack([self.way.turns(part, pulley) for pulley in driven], axis=1)
        return (np.asarray(np.diff(turns, axis=0) / self.grid.step),)

    def result(self, outcome: Outcome) -> SimulationResult:
        """Result of the run, as far as it went."""
        rows, move = outcome.rows, self.move
        columns = {channel.name: k for k, channel in enumerate(self.channels)}
        first, last = columns["rope_energy"], columns["balance"] - TALLIES
        # Strain and springs count from the start: at rest they are large, and nothing happens to them.
        moving = rows[:, first : first + 2].sum(axis=1)
        work = np.abs(rows[:, last]) if len(rows) else np.zeros(1)
        return SimulationResult(
            **self.common(outcome),
            extremes=extremes_of(self.names, reached(outcome.state)),
            spans=self.spans,
            energy_handled=max(float(np.max(moving, initial=0.0)), float(np.max(work, initial=0.0))),
            energy_at_rest=float(rows[0, columns["strain_energy"]]) if len(rows) else 0.0,
            assumptions=self._assumptions,
            wraps=self._wraps(outcome.state),
            doubts=tuple(self._doubts(outcome.state, rows)),
            provenance=self.provenance(
                {"travels": True, "motor": "free" if move is None else "prescribed"},
                move=None if move is None else dict(move.moves),
                rise=None if move is None else move.rise,
                torque=[signal.fingerprint for signal in self.torques],
            ),
        )

    @property
    def _assumptions(self) -> tuple[str, ...]:
        drive, plan, found = self.network.drive, self.plan, list(_ASSUMPTIONS)
        sideways = np.stack([-plan.bearing[:, 1], plan.bearing[:, 0]], axis=1)
        if np.max(np.abs(np.einsum("sc,sicn->sin", sideways, plan.frame)), initial=0.0) > PARALLEL:
            mass = float(np.sum(plan.piece[:, ROPES] * plan.piece[:, DENSITY] * self.length))
            carried = sum(body.mass for body in drive.body)
            found.append(f"{_ACROSS}: {mass:.3g} kg of ropes beside {carried:.4g} kg of bodies")
        if self.move is None:
            found.append("torque: beyond what holds the machine at rest")
        return (*found, *neglected(drive.ropes, drive.motor))

    def _wraps(self, state: TravelState) -> tuple[dict[str, Any], ...]:
        """Largest friction coefficient that each wrap needed, beside the file's."""
        found: dict[str, dict[str, Any]] = {}
        for s, span in enumerate(self.network.drive.free_spans):
            if span.wrap is None or span.end.pulley is None or self.plan.beyond[s, 1] < 0:
                continue
            name, needed = span.end.name, float(state.reached[1, s])
            if name not in found or needed > found[name]["needed_friction"]:
                own = self.network.drive.pulley[span.end.pulley].capstan_friction
                found[name] = {"pulley": name, "needed_friction": needed, "friction": own}
        return tuple(found.values())

    def _doubts(self, state: TravelState, rows: Array) -> Iterator[str]:
        """What the run assumed and did not keep to; where it asks more of a motor than the file allows."""
        for wrap in self._wraps(state):
            needed, own = wrap["needed_friction"], wrap["friction"]
            if own is not None and needed > own:
                yield (
                    f"the rope would slip on {wrap['pulley']}: it needs a friction coefficient of "
                    f"{needed:.3g}, capstan_friction is {own:.3g}; the run holds it fast"
                )
        columns = {channel.name: k for k, channel in enumerate(self.channels)}
        for motor, name, rotor in zip(self.network.drive.motor, self.motors, self.plan.rotor, strict=False):
            asked = (
                ("torque", motor.torque_limit, f"torque on {name}", "N m"),
                ("speed", motor.speed_limit, f"speed of {self.names[int(rotor)]}", "rad/s"),
            )
            for what, limit, channel, unit in asked:
                largest = float(np.max(np.abs(rows[:, columns[channel]]), initial=0.0))
                if limit is not None and largest > limit:
                    yield (
                        f"the {what} of {name} reaches {largest:.4g} {unit}, above {what}_limit = "
                        f"{limit:.4g}: move more slowly"
                    )

    def first_state(self) -> TravelState:
        """State before the first step: speeds half a step before the start."""
        plan, n, spans = self.plan, len(self.names), len(self.spans)
        q_t = self.q_t.copy()
        if not plan.prescribed:
            force = np.zeros(n)
            force[plan.rotor] = self.inputs(0, 1)[0][0] - self.holding
            q_t -= 0.5 * self.grid.step * np.linalg.solve(plan.mass, force - plan.damping @ self.q_t)
        rows = np.einsum("sc,sicn->sin", plan.bearing, plan.frame) + plan.turn
        ends = np.einsum("sin,n->si", rows, self.q_t)
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
