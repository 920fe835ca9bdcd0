"""Runs that ended before their time."""

from typing import TYPE_CHECKING, TypeVar

from cabledrive.parameters.errors import NotComputed

if TYPE_CHECKING:
    from cabledrive.simulation.network.result import NetworkResult
    from cabledrive.simulation.result import SimulationResult


Result = TypeVar("Result", bound="SimulationResult | NetworkResult")


def whole(result: Result) -> Result:
    """A result of a run that came to its end; `NotComputed` with the reason of one that did not."""
    if result.stopped is not None:
        raise NotComputed(result.stopped)
    return result


class SimulationInterrupted(KeyboardInterrupt):
    """The run was interrupted from outside; its line says how to go on.

    Attributes
    ----------
    result : SimulationResult or NetworkResult
        Everything up to there.
    """

    def __init__(self, message: str, result: "SimulationResult | NetworkResult") -> None:
        super().__init__(message)
        self.result = result
