"""What every run has that has not begun: a loop, a network about its state of rest, bodies that travel."""

import json
import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.parameters import Machine
from cabledrive.parameters.schema import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.simulation import damped as of
from cabledrive.simulation import plan as at
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.methods import TimeGrid
from cabledrive.simulation.plan import Plan, State, copy_state
from cabledrive.simulation.result import SimulationResult
from cabledrive.simulation.signals import Signal
from cabledrive.simulation.start import Recording, Scheme

KEPT_OF_THE_LAST = {"extremes", "peaks", "reached", "events"}
"""What a state keeps of the step beyond the end of the run."""


class Outcome(NamedTuple):
    """How a run ended."""

    rows: Array  # records that belong to the run so far
    fields: Array
    state: Any  # at the end
    stopped: str | None  # why it ended early, in one line; None if it did not
    wall_time: float  # how long it took [s]


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedRun(ABC):
    """A run that has not begun. A state is a NamedTuple of arrays, the first of ``counts`` the steps done.

    ``channels`` are the columns of a record, ``nodes`` those of all ropes; ``settings`` distinguish the run
    from others of its drive, scheme and recording.
    """

    machine: Machine
    scheme: Scheme
    recording: Recording
    grid: TimeGrid
    torques: tuple[Signal, ...]  # of each motor
    holding: Array  # (motors,): what is added to them [N m]
    channels: tuple[Channel, ...]
    settings: dict[str, Any]  # plain data
    law_name = "exact"

    @property
    @abstractmethod
    def nodes(self) -> int:
        """Nodes of all ropes."""

    @property
    def record_size(self) -> int:
        """Bytes of all records."""
        records, every = self.grid.records, self.recording.fields
        fields = records // every + 1 if every else 0
        return 8 * ((records + 1) * len(self.channels) + fields * 3 * self.nodes)

    @property
    def interpreted(self) -> str | None:
        """Why the steps are not compiled, in one line; None if they are."""
        return why_plain()

    @abstractmethod
    def first_state(self) -> Any:
        """State before the first step."""

    def inputs(self, first: int, steps: int) -> tuple[Array, ...]:
        """What is given at some steps, each shape (steps, ...); torques, (steps, motors) [N m]."""
        return (self.at_steps(self.torques, first, steps) + self.holding,)

    def at_steps(self, signals: tuple[Signal, ...], first: int, steps: int) -> Array:
        """Signals at the times of some steps, shape (steps, signals)."""
        time = np.arange(first, first + steps, dtype=np.float64) * self.grid.step
        return np.stack([signal.at(time) for signal in signals], axis=1) if signals else np.zeros((steps, 0))

    @abstractmethod
    def integrate(self, state: Any, inputs: list[Array], every: int, rows: Array, fields: Array) -> int:
        """Take the steps, the first of every ``every`` recorded; why they end."""

    @abstractmethod
    def why(self, code: int, state: Any) -> str:
        """Why steps ended early in a state, in one line."""

    @cached_property
    def fingerprint(self) -> dict[str, Any]:
        """What a resumed run must have in common with the interrupted one; plain data."""
        content = {
            "cabledrive": __version__,
            "drive_hash": content_hash(self.machine),
            "scheme": asdict(replace(self.scheme, model=self.law_name)),
            "recording": asdict(self.recording),
            "grid": asdict(self.grid),
            **self.settings,
            "sources": digest_with_imports(Path(str(sys.modules[type(self).__module__].__file__))),
        }
        plain: dict[str, Any] = json.loads(json.dumps(content))
        return plain

    @abstractmethod
    def result(self, outcome: Outcome) -> SimulationResult:
        """Result of the run, as far as it went."""

    def common(self, outcome: Outcome) -> dict[str, Any]:
        """What every result holds of how its run ended."""
        time = np.arange(len(outcome.rows), dtype=np.float64) * self.grid.interval
        field_time = time[:: self.recording.fields or len(time) + 1][: len(outcome.fields)]
        return {
            "time": time,
            "field_time": field_time,
            "fields": outcome.fields[: len(field_time)],
            "rows": outcome.rows,
            "steps": int(outcome.state.counts[0]),
            "step": self.grid.step,
            "largest_step": self.grid.largest_step,
            "channels": self.channels,
            "stopped": outcome.stopped,
            "wall_time": outcome.wall_time,
        }

    def provenance(self, method: dict[str, Any], **beside: Any) -> dict[str, Any]:
        """Version, drive, method and settings of a result; ``method``: what only this kind of run has."""
        return {
            "cabledrive": __version__,
            "drive": self.machine.name,
            "drive_hash": content_hash(self.machine),
            "method": {
                "name": self.scheme.method,
                "model": self.law_name,
                "compiled": self.interpreted is None,
                "interpreted": self.interpreted,
                "segments": self.scheme.segments,
                "step": self.grid.step,
                "largest_step": self.grid.largest_step,
                "cfl": self.grid.step / self.grid.largest_step,
                "friction": self.scheme.friction,
                "slack": self.scheme.slack,
                **method,
            },
            **beside,
        }

    def chunk(self, state: Any, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records, into ``state``; ``done``: records before them.

        Returns rows, shape (n, channels), whole fields, and why n is less than ``count``, if so.
        """
        every, kept = self.grid.every, self.recording.fields
        inputs = self.inputs(done * every, count * every)
        steps = _finite_steps(inputs, count * every)
        rows, fields = np.zeros((count, len(self.channels))), np.zeros((count if kept else 0, 3, self.nodes))
        code = self.integrate(state, [given[:steps] for given in inputs], every, rows, fields)
        whole, stopped = -(-int(state.counts[0]) // every) - done, None
        if code != at.DONE:
            whole -= code == at.NOT_FINITE
            stopped = self.why(code, state)
        elif steps < count * every:
            stopped = self._not_finite(done * every + steps)
        return rows[:whole], fields[:whole][-done % kept :: kept] if kept else fields, stopped

    def last(self, state: Any) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back.

        ``state`` keeps no more than extremes and events of it.
        """
        beyond, inputs = copy_state(state), self.inputs(self.grid.steps, 1)
        keeps_field = self.recording.fields and self.grid.records % self.recording.fields == 0
        rows, fields = np.zeros((1, len(self.channels))), np.zeros((1 if keeps_field else 0, 3, self.nodes))
        if not _finite_steps(inputs, 1):
            return rows, fields, self._not_finite(self.grid.steps)
        code = self.integrate(beyond, list(inputs), 1, rows, fields)
        for name in KEPT_OF_THE_LAST & set(state._fields):
            getattr(state, name)[...] = getattr(beyond, name)
        state.counts[1:] = beyond.counts[1:]
        return rows, fields, None if code == at.DONE else self.why(code, beyond)

    def _not_finite(self, step: int) -> str:
        what = "torque or a force" if len(self.inputs(0, 1)) > 1 else "torque"
        return f"the {what} is not finite at t = {step * self.grid.step:.6g} s"


def reached(state: Any) -> Array:
    """Least and largest place of each coordinate, (2, n); 0 where no step was taken."""
    return np.where(np.isfinite(state.extremes), state.extremes, 0.0)


def extremes_of(names: tuple[str, ...], reach: Array) -> dict[str, tuple[float, float]]:
    """Least and largest place by the names of the coordinates; ``reach``, (2, n): both, in any order."""
    return dict(zip(names, map(tuple, np.sort(reach, axis=0).T.tolist()), strict=True))


def _finite_steps(inputs: tuple[Array, ...], steps: int) -> int:
    """How many of the steps come before an input that is not finite."""
    fine = [np.isfinite(given).all(axis=tuple(range(1, given.ndim))) for given in inputs]
    bad = np.flatnonzero(~np.all(fine, axis=0))
    return int(bad[0]) if bad.size else steps


def half_step_before(
    plan: Plan, laws: Sequence[CableLaw], start: State, torque: Array, forces: Array
) -> State:
    r"""The start with velocities half a step before t = 0, Eq. (2.39) with the term the print drops.

    :math:`\dot x_{-1/2} = \dot x_0 - \tfrac12 \Delta t\,\ddot x_0`, so that the first whole step comes out of
    the same formula as all others. ``laws``: of each piece.
    """
    x, x_t, q, q_t = start.x, start.x_t, start.q, start.q_t
    gradients, pull = np.diff(x, axis=1) * plan.segment[at.INVERSE_SPACING], np.zeros((3, x.shape[1] - 1))
    on_q = plan.rest - plan.stiffness @ q + plan.motor.T @ torque - plan.damping.sum(axis=0) @ q_t
    for (first, last), law in zip(plan.nodes, laws, strict=True):
        here = slice(first, last)
        own = np.stack(law.excess_components(*gradients[:, here]))
        if plan.axial != of.UNDAMPED and plan.segment[at.COMPLIANCE, first] > 0.0:
            direction = np.stack(law.strain_gradient(*gradients[:, here]))
            rate = np.sum(direction * np.diff(x_t[:, first : last + 1], axis=1), axis=0)
            own = own + direction * rate / plan.segment[at.COMPLIANCE, here]
        pull[:, here] = own
    # entries of the rows of the ends: row, piece, side and axis of each
    row = np.repeat(np.arange(6 * len(plan.nodes)), np.diff(plan.row_start))
    piece, side, axis = np.unravel_index(row, (len(plan.nodes), 2, 3))
    sign = plan.piece[piece, at.ROPES] * (1 - 2 * side)
    np.add.at(on_q, plan.row_column, sign * plan.row_value * pull[axis, plan.nodes[piece, side] - side])
    kick = plan.node[[at.KICK_U, at.KICK_T, at.KICK_T]]
    gain = np.zeros_like(x_t)
    gain[:, 1:-1] = kick[:, 1:-1] * np.diff(pull, axis=1)
    gain[[0, 2]] += plan.node[[at.FALL_U, at.FALL_W]]
    for (node, way), pushed in zip(plan.force, forces, strict=True):
        gain[way, node] += kick[way, node] * pushed
    damped = (1.0 - plan.node[at.KEEP_T]) / (1.0 + plan.node[at.KEEP_T])
    gain[1:] = gain[1:] * (1.0 + damped) - 2.0 * damped * x_t[1:]

    for k in np.flatnonzero(plan.stick >= 0):
        i, bound, smooth = plan.stick[k], plan.bound[k] * abs(plan.rub[k]).max(), plan.smooth[k]
        if plan.wrap[k, 0] >= 0:  # per tension of the slacker side of a wrap
            sides = pull[:, plan.nodes[plan.wrap[k], [1, 0]] - (1, 0)]
            sides[0] += plan.piece[plan.wrap[k], at.PRETENSION]
            bound *= np.linalg.norm(sides, axis=0).min()
        if smooth > 0.0:
            on_q[i] -= bound * np.tanh(q_t[i] / smooth)
        else:
            on_q[i] -= np.clip(on_q[i], -bound, bound) if q_t[i] == 0.0 else bound * np.sign(q_t[i])
    free = plan.moves > 0.0
    speeds = np.where(free, q_t, 0.0)
    speeds[free] -= 0.5 * plan.step * np.linalg.solve(plan.mass[np.ix_(free, free)], on_q[free])
    before = x_t - 0.5 * gain
    ends = np.bincount(row, plan.row_value * speeds[plan.row_column], 6 * len(plan.nodes))
    before[:, plan.nodes] = ends.reshape(-1, 2, 3).transpose(2, 0, 1)
    return start._replace(x_t=before, q_t=speeds)
