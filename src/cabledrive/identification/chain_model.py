r"""A lumped chain with its free parameters, its measured channels and their sensors.

.. math:: z = \max(0, y - z_0), \qquad T\dot y + y = |\omega|

A counter of pulses does not see the direction, its converter to a voltage lags, and shows nothing below a
threshold.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import direction, integrate_chain
from cabledrive.reduction.lumped_chain import LumpedChain


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """Input and outputs of one run."""

    input: Array  # (samples,): in any unit, in which all parameters then are
    output: Array  # (samples, channels)
    interval: float  # [s]

    def begun(self, samples: int) -> "Record":
        """The first samples."""
        return replace(self, input=self.input[:samples], output=self.output[:samples])


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeParameter:
    """One parameter of a chain."""

    name: str
    quantity: str  # of `cabledrive.reduction.friction_integration`, or "lag" or "threshold" of the sensors
    number: int = 0  # of the inertia or link
    # low, high: bounds; both positive but for offsets, whose search alone is not in the logarithm
    low: float = 1e-9
    high: float = 1e9


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainModel:
    """A lumped chain with its free parameters, all others 0; the input drives its first inertia."""

    inertias: int  # how many
    free: tuple[FreeParameter, ...]
    measured: tuple[int, ...]  # number of the inertia whose speed each output channel shows
    rectified: bool = False  # whether all sensors show absolute values
    delay: int = 0  # samples after which the input acts
    # {"line", "step"}: input on straight lines between samples, or standing from sample to sample
    hold: str = "step"
    substeps: int = 4  # steps per sample

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(s.name for s in self.free)

    @property
    def positive(self) -> NDArray[np.bool_]:
        """Which parameters are searched in their logarithm, shape (p,)."""
        return np.array([s.quantity != "offset" for s in self.free])

    def outputs(self, values: Mapping[str, float], record: Record) -> Array:
        """Outputs under the input of a record, shape (samples, channels)."""
        return self._moved(values, record, sensitive=False)[0]

    def compared(self, place: Array, record: Record) -> tuple[Array, Array]:
        """Simulated less measured (rows,) at a place (p,) of the search, and its derivatives (rows, p)."""
        outputs, slopes = self._moved(self.values_at(place), record, sensitive=True)
        slopes = slopes * self.slopes(place)
        return (outputs - record.output).ravel(), slopes.reshape(-1, len(self.free))

    def search_bounds(self, start: Mapping[str, float]) -> tuple[Array, Array, Array]:
        """Where the search begins, strictly within its bounds, and these, each (p,)."""
        rows = np.array([(start[s.name], s.low, s.high) for s in self.free]).T
        begin, low, high = (np.where(self.positive, np.log(np.where(self.positive, r, 1.0)), r) for r in rows)
        return begin, low, high

    def inside(self, start: Mapping[str, float]) -> dict[str, float]:
        """A start strictly within the bounds."""
        found = {}
        for s, positive in zip(self.free, self.positive, strict=True):
            margin = (1.0 + 1e-6) if positive else 1e-9 * (s.high - s.low)
            low, high = (s.low * margin, s.high / margin) if positive else (s.low + margin, s.high - margin)
            found[s.name] = float(np.clip(start[s.name], low, high))
        return found

    def values_at(self, place: Array) -> dict[str, float]:
        """Parameters at a place (p,) of the search."""
        return dict(zip(self.names, np.where(self.positive, np.exp(place), place).tolist(), strict=True))

    def slopes(self, place: Array) -> Array:
        """Derivatives (p,) of the parameters by the place (p,) of the search."""
        return np.where(self.positive, np.exp(place), 1.0)

    def _moved(self, values: Mapping[str, float], record: Record, *, sensitive: bool) -> tuple[Array, Array]:
        """Outputs (samples, channels) and, where asked, their derivatives (samples, channels, p)."""
        n, step = self.inertias, record.interval / self.substeps
        known = {(s.quantity, s.number): values[s.name] for s in self.free}

        def filled(name: str, count: int = n) -> tuple[float, ...]:
            return tuple(known.get((name, k), 0.0) for k in range(count))

        chain = LumpedChain(
            names=tuple(f"inertia {k}" for k in range(n)),
            inertias=filled("inertia"),
            viscous=filled("viscous"),
            coulomb=filled("coulomb"),
            offsets=filled("offset"),
            stiffness=filled("stiffness", n - 1),
            damping=filled("damping", n - 1),
            ratios=((1.0, 1.0),) * (n - 1),
        )
        sensors, still = ("lag", "threshold"), np.zeros(9 * n - 2)
        directions = [
            still if s.quantity in sensors else direction(n, s.quantity, s.number) for s in self.free
        ]
        late = np.concatenate([np.zeros(self.delay), record.input[: record.input.size - self.delay]])
        steps = (late.size - 1) * self.substeps + 1
        acting = np.repeat(late, self.substeps)[:steps]
        if self.hold == "line":
            acting = np.interp(np.arange(steps) / self.substeps, np.arange(late.size), late)
        run = integrate_chain(
            chain,
            acting,
            step,
            directions=np.column_stack(directions) if sensitive else None,
            hold=self.hold,
        )
        channels = list(self.measured)
        output, slopes = run.speeds[:, channels], run.speed_sensitivities[:, channels].copy()
        by = [s.quantity for s in self.free] if sensitive else []
        if self.rectified:
            slopes = slopes * np.sign(output)[:, :, None]
            output = np.abs(output)
        if (lag := known.get(("lag", 0), 0.0)) > 0.0:
            output, slopes = _lagged(output, lag, step), _lagged(slopes, lag, step)
            if "lag" in by:
                slopes[:, :, by.index("lag")] += (_lagged(output, lag, step) - output) / lag
        if (threshold := known.get(("threshold", 0), 0.0)) > 0.0:
            if "threshold" in by:
                slopes[:, :, by.index("threshold")] -= 1.0
            above = output > threshold
            output, slopes = np.where(above, output - threshold, 0.0), slopes * above[:, :, None]
        return output[:: self.substeps], slopes[:: self.substeps]


def _lagged(values: Array, lag: float, interval: float) -> Array:
    """Values (samples, ...) behind a lag [s] of order 1, from rest; exact for straight lines at samples."""
    ratio = interval / lag
    pole = exp(-ratio)
    late = 1.0 - (1.0 - pole) / ratio  # weight of the newer corner of each straight line
    base = values[:1]
    return np.asarray(base + signal.lfilter([late, 1.0 - pole - late], [1.0, -pole], values - base, axis=0))
