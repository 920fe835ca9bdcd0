"""A record with its training part: inputs and outputs of one run."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import zero_phase
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """Input and outputs of one run.

    Attributes
    ----------
    input : ndarray, shape (samples,)
        In any unit: gains turn it into torque or force.
    output : ndarray, shape (samples, channels)
    interval : float
        [s].
    first, last : int, int or None
        Samples ``first`` to ``last`` (not included) are fitted; the rest is for validation.
    bandwidth : float or None
        Measured and simulated outputs are compared below this frequency [Hz]; None: as they are.
    """

    input: Array
    output: Array
    interval: float
    first: int = 0
    last: int | None = None
    bandwidth: float | None = None

    def __post_init__(self) -> None:
        if self.output.ndim != 2 or self.output.shape[0] != self.input.size:
            raise InputRefused(
                f"output of shape {self.output.shape} beside {self.input.size} inputs: give one row per input"
            )

    @property
    def training(self) -> slice:
        """Samples that are fitted."""
        return slice(self.first, self.last)

    @property
    def compared_size(self) -> int:
        """Number of values that are compared."""
        return len(range(self.input.size)[self.training]) * self.output.shape[1]

    def seen(self, outputs: Array) -> Array:
        """Outputs as they are compared, below the bandwidth.

        ``outputs``, shape (samples, ...).
        """
        return outputs if self.bandwidth is None else zero_phase(outputs, self.interval, self.bandwidth)
