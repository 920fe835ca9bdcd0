"""What every run has that has not begun: a loop, a network about its state of rest, bodies that travel."""

import json
import sys
from abc import ABC, abstractmethod
from dataclasses import asdict, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.sources import digest_with_imports
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.schema import content_hash
from cabledrive.parameters.version import __version__
from cabledrive.simulation.methods import TimeGrid
from cabledrive.simulation.plan import DONE, NOT_FINITE, copy_state
from cabledrive.simulation.start import Recording, Scheme

KEPT_OF_THE_LAST = {"extremes", "peaks", "reached", "events"}
"""What a state keeps of the step beyond the end of the run."""


class PreparedRun(ABC):
    """A run that has not begun. A state is a NamedTuple of arrays, the first of ``counts`` the steps done."""

    scheme: Scheme
    recording: Recording
    grid: TimeGrid

    @property
    @abstractmethod
    def machine(self) -> Drive | RoutedDrive:
        """The drive of the run."""

    @property
    @abstractmethod
    def width(self) -> int:
        """Numbers per record."""

    @property
    @abstractmethod
    def nodes(self) -> int:
        """Nodes of all ropes."""

    @property
    def field_records(self) -> int:
        """Whole fields that are kept."""
        return 0 if self.recording.fields == 0 else self.grid.records // self.recording.fields + 1

    @property
    @abstractmethod
    def law_name(self) -> str:
        """Name of the cable law."""

    @property
    def interpreted(self) -> str | None:
        """Why the steps are not compiled, in one line; None if they are."""
        return why_plain()

    @property
    @abstractmethod
    def settings(self) -> dict[str, Any]:
        """What distinguishes the run from others of its drive, scheme, recording and grid; plain data."""

    @abstractmethod
    def first_state(self) -> Any:
        """State before the first step."""

    @abstractmethod
    def inputs(self, first: int, steps: int) -> tuple[Array, ...]:
        """What is given at some steps, each shape (steps, ...)."""

    @abstractmethod
    def integrate(self, state: Any, inputs: list[Array], every: int, rows: Array, fields: Array) -> int:
        """Take the steps, the first of every ``every`` recorded; why they end."""

    @abstractmethod
    def why(self, code: int, state: Any, before: Any, inputs: tuple[Array, ...]) -> str:
        """Why steps ended early, in one line; ``before``: the state before these steps."""

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
                "friction": self.scheme.friction,
                "slack": self.scheme.slack,
                **method,
            },
            **beside,
        }

    def chunk(self, state: Any, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records, into ``state``; ``done``: records before them.

        Returns rows, shape (n, width), whole fields, and why n is less than ``count``, if so.
        """
        every, kept = self.grid.every, self.recording.fields
        inputs, before = self.inputs(done * every, count * every), copy_state(state)
        steps = _finite_steps(inputs, count * every)
        rows, fields = np.zeros((count, self.width)), np.zeros((count if kept else 0, 3, self.nodes))
        code = self.integrate(state, [given[:steps] for given in inputs], every, rows, fields)
        whole, stopped = -(-int(state.counts[0]) // every) - done, None
        if code != DONE:
            whole -= code == NOT_FINITE
            stopped = self.why(code, state, before, inputs)
        elif steps < count * every:
            stopped = self._not_finite(done * every + steps)
        return rows[:whole], fields[:whole][-done % kept :: kept] if kept else fields, stopped

    def last(self, state: Any) -> tuple[Array, Array, str | None]:
        """The record at the end of the run, of a step beyond it that is taken back.

        ``state`` keeps no more than extremes and events of it.
        """
        beyond, inputs = copy_state(state), self.inputs(self.grid.steps, 1)
        keeps_field = self.recording.fields and self.grid.records % self.recording.fields == 0
        rows, fields = np.zeros((1, self.width)), np.zeros((1 if keeps_field else 0, 3, self.nodes))
        if not _finite_steps(inputs, 1):
            return rows, fields, self._not_finite(self.grid.steps)
        code = self.integrate(beyond, list(inputs), 1, rows, fields)
        for name in KEPT_OF_THE_LAST & set(state._fields):
            getattr(state, name)[...] = getattr(beyond, name)
        state.counts[1:] = beyond.counts[1:]
        return rows, fields, None if code == DONE else self.why(code, beyond, copy_state(state), inputs)

    def _not_finite(self, step: int) -> str:
        what = "torque or a force" if len(self.inputs(0, 1)) > 1 else "torque"
        return f"the {what} is not finite at t = {step * self.grid.step:.6g} s"


def _finite_steps(inputs: tuple[Array, ...], steps: int) -> int:
    """How many of the steps come before an input that is not finite."""
    fine = [np.isfinite(given).all(axis=tuple(range(1, given.ndim))) for given in inputs]
    bad = np.flatnonzero(~np.all(fine, axis=0))
    return int(bad[0]) if bad.size else steps
