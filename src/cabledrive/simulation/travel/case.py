"""Everything that is decided before the first step of a run in which bodies travel."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.network import Network
from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.parameters.hashing import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.simulation.case import Recording
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.scheme import Scheme
from cabledrive.simulation.signals import Signal
from cabledrive.simulation.step_size import TimeGrid
from cabledrive.simulation.travel.channels import travel_channels
from cabledrive.simulation.travel.plan import TALLIES, TravelPlan, TravelState
from cabledrive.simulation.travel.way import Way
from cabledrive.trajectories import smooth_rise

if TYPE_CHECKING:
    from cabledrive.simulation.travel.stepper import TravelStepper

ORDER = 9
"""Of the rise of a move: smooth up to its fourth derivative."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedMove:
    """Bodies that go somewhere, led by the turns of the motors.

    Attributes
    ----------
    moves : dict of str to float
        By coordinate, such as "car.y" [m].
    rise : float
        Time that the move takes [s]; the motors rest from then on.
    """

    moves: Mapping[str, float]
    rise: float


@dataclass(frozen=True, kw_only=True, eq=False)
class TravelCase:
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
    def nodes(self) -> int:
        """Cells of all spans."""
        return int(self.plan.cells[-1])

    @property
    def field_records(self) -> int:
        """Whole fields that are kept: none."""
        return 0

    @cached_property
    def fingerprint(self) -> dict[str, Any]:
        """What a resumed run must have in common with the interrupted one; plain data."""
        content = {
            "cabledrive": __version__,
            "drive_hash": content_hash(self.network.drive),
            "scheme": asdict(self.scheme),
            "recording": asdict(self.recording),
            "grid": asdict(self.grid),
            "move": None if self.move is None else [dict(self.move.moves), self.move.rise],
            "torque": [signal.fingerprint for signal in self.torques],
            "start": sha256(self.q_t.tobytes()).hexdigest(),
            "sources": digest_with_imports(Path(__file__)),
        }
        plain: dict[str, Any] = json.loads(json.dumps(content))
        return plain

    def given(self, first: int, steps: int) -> Array:
        """Torques of the motors at the times of some steps [N m], or their speeds over them [rad/s]."""
        number = np.arange(first, first + steps + 1, dtype=np.float64)
        time = number * self.grid.step
        if self.move is None or self.way is None:
            return np.stack([signal.at(time[:-1]) for signal in self.torques], axis=1) + self.holding
        # The state lies half a step behind its speeds: turns at the times of the steps, speeds between them.
        part = smooth_rise(np.minimum(time / self.move.rise, 1.0), ORDER)[0]
        turns = np.stack([self.way.turns(part, int(rotor)) for rotor in self.plan.rotor], axis=1)
        return np.asarray(np.diff(turns, axis=0) / self.grid.step)

    def first_state(self) -> TravelState:
        """State before the first step: speeds half a step before the start."""
        plan, n, spans = self.plan, len(self.names), len(self.spans)
        q_t = self.q_t.copy()
        if not plan.prescribed:
            force = np.zeros(n)
            force[plan.rotor] = self.given(0, 1)[0] - self.holding
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

    def stepper(self) -> "TravelStepper":
        """What takes the steps."""
        from cabledrive.simulation.travel.stepper import TravelStepper

        return TravelStepper(self)
