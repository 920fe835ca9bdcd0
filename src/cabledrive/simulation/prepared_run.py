"""What a run asks of what moves in it, be it a loop, a line or a machine with routes."""

from typing import Any, Protocol

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.case import Recording
from cabledrive.simulation.step_size import TimeGrid


class Stepper(Protocol):
    """Takes the steps of one run. A state is a NamedTuple of arrays, with the steps done in ``counts``."""

    def chunk(self, state: Any, done: int, count: int) -> tuple[Array, Array, str | None]:
        """Steps of some records, into ``state``; ``done``: records before them.

        Returns rows, shape (n, width), whole fields, and why n is less than ``count``, if so.
        """
        ...

    def last(self, state: Any) -> tuple[Array, Array, str | None]:
        """The record at the end of the run; ``state`` keeps no more than extremes and events of it."""
        ...


class PreparedRun(Protocol):
    """A run that has not begun."""

    @property
    def grid(self) -> TimeGrid:
        """Steps and records."""
        ...

    @property
    def recording(self) -> Recording:
        """What is kept."""
        ...

    @property
    def width(self) -> int:
        """Numbers per record."""
        ...

    @property
    def nodes(self) -> int:
        """Nodes of all ropes."""
        ...

    @property
    def field_records(self) -> int:
        """Whole fields that are kept."""
        ...

    @property
    def fingerprint(self) -> dict[str, Any]:
        """What a resumed run must have in common with the interrupted one; plain data."""
        ...

    def first_state(self) -> Any:
        """State before the first step."""
        ...

    def stepper(self) -> Stepper:
        """What takes its steps."""
        ...
