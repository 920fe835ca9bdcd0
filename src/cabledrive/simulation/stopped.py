"""A run that ended before its time, with what was computed until then."""

from typing import TYPE_CHECKING

from cabledrive.parameters.errors import NotComputed

if TYPE_CHECKING:
    from cabledrive.simulation.network.result import NetworkResult
    from cabledrive.simulation.result import SimulationResult


class SimulationStopped(NotComputed):
    """The run could not go on: a span went slack, a number was not finite, the disk was full.

    Attributes
    ----------
    result : SimulationResult
        Everything up to there.
    """

    def __init__(self, message: str, result: "SimulationResult") -> None:
        super().__init__(message)
        self.result = result


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
