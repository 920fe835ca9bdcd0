r"""A lumped chain with its free parameters, its measured channels and their sensors.

.. math:: z = \max(0, y - z_0), \qquad T\dot y + y = |\omega|

A counter of pulses does not see the direction, its converter to a voltage lags, and shows nothing below a
threshold.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import zero_phase
from cabledrive.parameters import InputRefused
from cabledrive.reduction.friction_integration import direction, integrate_chain
from cabledrive.reduction.lumped_chain import LumpedChain

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Record:
    """Input and outputs of one run."""

    input: Array  # (samples,): in any unit: gains turn it into torque or force
    output: Array  # (samples, channels)
    interval: float  # [s]
    # first, last: samples ``first`` to ``last`` (not included) are fitted; the rest is for validation
    first: int = 0
    last: int | None = None
    # measured and simulated outputs are compared below this frequency [Hz]; None: as they are
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


SENSOR_QUANTITIES = ("lag", "threshold")


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A speed sensor."""

    rectified: bool = False  # whether it shows the absolute value
    lag: float = 0.0  # time constant T [s]; 0: none
    threshold: float = 0.0  # speed :math:`z_0` that is taken off; 0: none


def shown(
    sensor: Sensor, speeds: Array, sensitivities: Array, interval: float, quantities: tuple[str, ...]
) -> tuple[Array, Array]:
    """What the sensor shows, and its derivatives.

    ``speeds``, shape (samples, channels); ``sensitivities``, shape (samples, channels, p): of the speeds;
    ``interval`` [s]; ``quantities``: what each of the p parameters is; those of `SENSOR_QUANTITIES` act here.
    Returns ``output``, shape (samples, channels); ``derivatives``, shape (samples, channels, p).
    """
    output, slopes = speeds, sensitivities.copy()
    if sensor.rectified:
        slopes = slopes * np.sign(output)[:, :, None]
        output = np.abs(output)
    if sensor.lag > 0.0:
        output, slopes = lagged(output, sensor.lag, interval), lagged(slopes, sensor.lag, interval)
        by_lag = (lagged(output, sensor.lag, interval) - output) / sensor.lag
        for k in (k for k, name in enumerate(quantities) if name == "lag"):
            slopes[:, :, k] += by_lag
    if sensor.threshold > 0.0:
        for k in (k for k, name in enumerate(quantities) if name == "threshold"):
            slopes[:, :, k] -= 1.0
        above = output > sensor.threshold
        output, slopes = np.where(above, output - sensor.threshold, 0.0), slopes * above[:, :, None]
    return output, slopes


def lagged(values: Array, lag: float, interval: float) -> Array:
    """Values behind a lag of order 1, from rest at the first value; on straight lines between samples exact.

    ``values``, shape (samples, ...); ``lag`` [s]; ``interval`` [s].
    """
    ratio = interval / lag
    pole = exp(-ratio)
    late = 1.0 - (1.0 - pole) / ratio  # weight of the newer corner of each straight line
    early = 1.0 - pole - late
    base = values[:1]
    return np.asarray(base + signal.lfilter([late, early], [1.0, -pole], values - base, axis=0))


SIGNED = ("offset", "angle", "speed")


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeParameter:
    """One parameter of a row."""

    name: str
    # one of `cabledrive.reduction.friction_integration.QUANTITIES`, or of
    # `cabledrive.identification.chain_model.SENSOR_QUANTITIES`
    quantity: str
    number: int = 0  # of the inertia or link
    # low, high: Bounds; both positive but for offsets and initial values
    low: float = 1e-9
    high: float = 1e9

    @property
    def positive(self) -> bool:
        """Whether the search is in its logarithm."""
        return self.quantity not in SIGNED


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainModel:
    """A lumped chain with its free parameters and its measured channels."""

    inertias: int  # how many
    free: tuple[FreeParameter, ...]
    measured: tuple[int, ...]  # number of the inertia whose speed each output channel shows
    driven: int = 0  # number of the inertia that the input drives
    # quantities that are known, by quantity and number; all others are 0
    given: Mapping[tuple[str, int], float]
    sensor: Sensor = field(default_factory=Sensor)  # of all channels; free parameters replace its own values
    delay: int = 0  # samples after which the input acts
    # {"line", "step"}: input on straight lines between samples, or standing from sample to sample
    hold: str = "step"
    substeps: int = 4  # steps per sample

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(s.name for s in self.free)

    @property
    def directions(self) -> Array:
        """How each parameter moves the quantities of the row, shape (9 n - 2, p)."""
        still = np.zeros(9 * self.inertias - 2)
        columns = [
            still if s.quantity in SENSOR_QUANTITIES else direction(self.inertias, s.quantity, s.number)
            for s in self.free
        ]
        return np.column_stack(columns)

    def outputs(self, values: Mapping[str, float], record: Record) -> Array:
        """Outputs under the input of a record.

        Returns shape (samples, channels).
        """
        return self._moved(values, record, sensitive=False)[0]

    def compared(self, place: Array, record: Record) -> tuple[Array, Array]:
        """Residual over the training part, simulated less measured, and its derivatives.

        ``place``, shape (p,): where the search is: logarithms of what is positive.
        Returns ``residual``, shape (rows,); ``derivatives``, shape (rows, p).
        """
        outputs, sensitivities = self._moved(self.values_at(place), record, sensitive=True)
        off = record.seen(outputs - record.output)[record.training]
        slopes = record.seen(sensitivities)[record.training] * self.slopes(place)
        return off.ravel(), slopes.reshape(-1, len(self.free))

    def search_bounds(self, start: Mapping[str, float]) -> tuple[Array, Array, Array]:
        """Where the search begins, and its bounds.

        Returns ``begin, low, high``, shape (p,).
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

    def values_at(self, place: Array) -> dict[str, float]:
        """Parameters at a place of the search.

        ``place``, shape (p,).
        """
        pairs = zip(self.free, place, strict=True)
        return {s.name: float(np.exp(x)) if s.positive else float(x) for s, x in pairs}

    def slopes(self, place: Array) -> Array:
        """Derivatives of the parameters by the place of the search.

        ``place``, shape (p,).
        Returns shape (p,).
        """
        return np.array([np.exp(x) if s.positive else 1.0 for s, x in zip(self.free, place, strict=True)])

    def row(self, values: Mapping[str, float]) -> LumpedChain:
        """The lumped chain."""
        n, q = self.inertias, self._quantities(values)
        return LumpedChain(
            names=tuple(f"inertia {k}" for k in range(n)),
            inertias=_filled(q, "inertia", n),
            viscous=_filled(q, "viscous", n),
            coulomb=_filled(q, "coulomb", n),
            offsets=_filled(q, "offset", n),
            stiffness=_filled(q, "stiffness", n - 1),
            damping=_filled(q, "damping", n - 1),
            ratios=((1.0, 1.0),) * (n - 1),
        )

    def _quantities(self, values: Mapping[str, float]) -> dict[tuple[str, int], float]:
        return dict(self.given) | {(s.quantity, s.number): values[s.name] for s in self.free}

    def _moved(self, values: Mapping[str, float], record: Record, *, sensitive: bool) -> tuple[Array, Array]:
        n, q = self.inertias, self._quantities(values)
        gains = tuple(q.get(("gain", k), 1.0) if k == self.driven else 0.0 for k in range(n))
        fine = record.interval / self.substeps
        run = integrate_chain(
            self.row(values),
            self._acting(record.input),
            fine,
            gains=gains,
            start=np.array([*_filled(q, "angle", n), *_filled(q, "speed", n)]),
            directions=self.directions if sensitive else None,
            hold=self.hold,
        )
        channels = list(self.measured)
        speeds, sensitivities = run.speeds[:, channels], run.speed_sensitivities[:, channels]
        quantities = tuple(s.quantity for s in self.free) if sensitive else ()
        sensor = replace(
            self.sensor,
            lag=q.get(("lag", 0), self.sensor.lag),
            threshold=q.get(("threshold", 0), self.sensor.threshold),
        )
        output, slopes = shown(sensor, speeds, sensitivities, fine, quantities)
        return output[:: self.substeps], slopes[:: self.substeps]

    def _acting(self, values: Array) -> Array:
        """The input at every step of the integration, late by the delay."""
        late = np.concatenate([np.zeros(self.delay), values[: values.size - self.delay]])
        steps = (values.size - 1) * self.substeps + 1
        if self.hold == "step":
            return np.repeat(late, self.substeps)[:steps]
        return np.interp(np.arange(steps) / self.substeps, np.arange(values.size), late)


def _filled(quantities: Mapping[tuple[str, int], float], name: str, count: int) -> tuple[float, ...]:
    return tuple(quantities.get((name, k), 0.0) for k in range(count))
