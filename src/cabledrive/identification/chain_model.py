r"""A lumped chain with its free parameters, its measured channels and their sensors.

.. math:: z = \max(0, y - z_0), \qquad T\dot y + y = |\omega|

A counter of pulses does not see the direction, its converter to a voltage lags, and shows nothing below a
threshold.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp

import numpy as np
from scipy import signal

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import direction, integrate_chain
from cabledrive.reduction.lumped_chain import LumpedChain

SENSOR_QUANTITIES = ("lag", "threshold")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """Input and outputs of one run."""

    input: Array  # (samples,): in any unit, in which all parameters then are
    output: Array  # (samples, channels)
    interval: float  # [s]

    def __post_init__(self) -> None:
        if self.output.ndim != 2 or self.output.shape[0] != self.input.size:
            raise InputRefused(
                f"output of shape {self.output.shape} beside {self.input.size} inputs: give one row per input"
            )

    def begun(self, samples: int) -> "Record":
        """The first samples."""
        return Record(input=self.input[:samples], output=self.output[:samples], interval=self.interval)


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeParameter:
    """One parameter of a chain."""

    name: str
    quantity: str  # one of those of `cabledrive.reduction.friction_integration`, or of `SENSOR_QUANTITIES`
    number: int = 0  # of the inertia or link
    # low, high: bounds; both positive but for offsets
    low: float = 1e-9
    high: float = 1e9

    @property
    def positive(self) -> bool:
        """Whether the search is in its logarithm."""
        return self.quantity != "offset"


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

    def outputs(self, values: Mapping[str, float], record: Record) -> Array:
        """Outputs under the input of a record, shape (samples, channels)."""
        return self._moved(values, record, sensitive=False)[0]

    def compared(self, place: Array, record: Record) -> tuple[Array, Array]:
        """Residual over what is fitted (rows,), simulated less measured, and its derivatives (rows, p).

        ``place``, shape (p,): where the search is: logarithms of what is positive.
        """
        outputs, sensitivities = self._moved(self.values_at(place), record, sensitive=True)
        slopes = sensitivities * self.slopes(place)
        return (outputs - record.output).ravel(), slopes.reshape(-1, len(self.free))

    def search_bounds(self, start: Mapping[str, float]) -> tuple[Array, Array, Array]:
        """Where the search begins, and its bounds, each (p,).

        Raises `InputRefused` if a start value is missing or outside its bounds.
        """
        for s in self.free:
            if s.name not in start:
                raise InputRefused(f"{s.name}: no start value: give one")
            if not s.low < start[s.name] < s.high:
                bounds = f"{s.low:.4g} and {s.high:.4g}"
                raise InputRefused(
                    f"{s.name} = {start[s.name]:.4g} must lie between {bounds}: take another start"
                )
        rows = [(start[s.name], s.low, s.high) for s in self.free]
        logs = [np.log(row) if s.positive else np.array(row) for s, row in zip(self.free, rows, strict=True)]
        begin, low, high = np.array(logs).T
        return begin, low, high

    def inside(self, start: Mapping[str, float]) -> dict[str, float]:
        """A start strictly within the bounds."""
        found = {}
        for s in self.free:
            margin = (1.0 + 1e-6) if s.positive else 1e-9 * (s.high - s.low)
            low, high = (s.low * margin, s.high / margin) if s.positive else (s.low + margin, s.high - margin)
            found[s.name] = float(np.clip(start[s.name], low, high))
        return found

    def values_at(self, place: Array) -> dict[str, float]:
        """Parameters at a place (p,) of the search."""
        pairs = zip(self.free, place, strict=True)
        return {s.name: float(np.exp(x)) if s.positive else float(x) for s, x in pairs}

    def slopes(self, place: Array) -> Array:
        """Derivatives (p,) of the parameters by the place (p,) of the search."""
        return np.array([np.exp(x) if s.positive else 1.0 for s, x in zip(self.free, place, strict=True)])

    def _moved(self, values: Mapping[str, float], record: Record, *, sensitive: bool) -> tuple[Array, Array]:
        """Outputs (samples, channels) and, where asked, their derivatives (samples, channels, p)."""
        n = self.inertias
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
        still = np.zeros(9 * n - 2)
        directions = [
            still if s.quantity in SENSOR_QUANTITIES else direction(n, s.quantity, s.number)
            for s in self.free
        ]
        run = integrate_chain(
            chain,
            self._acting(record.input),
            record.interval / self.substeps,
            gains=(1.0, *(0.0,) * (n - 1)),
            start=np.zeros(2 * n),
            directions=np.column_stack(directions) if sensitive else None,
            hold=self.hold,
        )
        channels = list(self.measured)
        speeds, slopes = run.speeds[:, channels], run.speed_sensitivities[:, channels].copy()
        quantities = [s.quantity for s in self.free] if sensitive else []
        output, step = speeds, record.interval / self.substeps
        lag, threshold = known.get(("lag", 0), 0.0), known.get(("threshold", 0), 0.0)
        if self.rectified:
            slopes = slopes * np.sign(output)[:, :, None]
            output = np.abs(output)
        if lag > 0.0:
            output, slopes = lagged(output, lag, step), lagged(slopes, lag, step)
            by_lag = (lagged(output, lag, step) - output) / lag
            for k in (k for k, name in enumerate(quantities) if name == "lag"):
                slopes[:, :, k] += by_lag
        if threshold > 0.0:
            for k in (k for k, name in enumerate(quantities) if name == "threshold"):
                slopes[:, :, k] -= 1.0
            above = output > threshold
            output, slopes = np.where(above, output - threshold, 0.0), slopes * above[:, :, None]
        return output[:: self.substeps], slopes[:: self.substeps]

    def _acting(self, values: Array) -> Array:
        """The input at every step of the integration, late by the delay."""
        late = np.concatenate([np.zeros(self.delay), values[: values.size - self.delay]])
        steps = (values.size - 1) * self.substeps + 1
        if self.hold == "step":
            return np.repeat(late, self.substeps)[:steps]
        return np.interp(np.arange(steps) / self.substeps, np.arange(values.size), late)


def lagged(values: Array, lag: float, interval: float) -> Array:
    """Values (samples, ...) behind a lag [s] of order 1, from rest; exact for straight lines at samples."""
    ratio = interval / lag
    pole = exp(-ratio)
    late = 1.0 - (1.0 - pole) / ratio  # weight of the newer corner of each straight line
    early = 1.0 - pole - late
    base = values[:1]
    return np.asarray(base + signal.lfilter([late, early], [1.0, -pole], values - base, axis=0))
