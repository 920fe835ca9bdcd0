"""Signals in time: torques and forces, given as a formula, as samples, or as a function."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from math import isfinite, log, pi

import numpy as np
from numpy.typing import ArrayLike

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters import Machine
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning

Function = Callable[[Array], ArrayLike]


class Signal(ABC):
    """A number that changes in time."""

    def at(self, time: Array) -> Array:
        """Values of the signal.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Times from the start of the run [s].

        Returns
        -------
        ndarray, shape (n,)
            N m for a torque, N for a force.
        """
        return self._at(time)

    @abstractmethod
    def _at(self, time: Array) -> Array: ...

    @property
    def lasts(self) -> float:
        """Time up to which the signal is defined [s]."""
        return float("inf")

    @property
    def fingerprint(self) -> str:
        """Text that is the same for the same signal, by which a resumed run knows its input."""
        return repr(self)


@dataclass(frozen=True, slots=True)
class Constant(Signal):
    """A signal that stays as it is."""

    value: float

    def __post_init__(self) -> None:
        _check_finite(self, "value")

    def _at(self, time: Array) -> Array:
        return np.full(time.size, self.value)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Sine(Signal):
    r"""``amplitude * sin(2 pi frequency t + phase)``."""

    amplitude: float = meaning("largest value [N m or N]")
    frequency: float = meaning("frequency [Hz]")
    phase: float = meaning("phase at the start [rad]", 0.0)

    def __post_init__(self) -> None:
        _check_finite(self, "amplitude", "frequency", "phase")

    def _at(self, time: Array) -> Array:
        return self.amplitude * np.sin(2.0 * pi * self.frequency * time + self.phase)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Sweep(Signal):
    """A sine whose frequency goes from one value to another, and stays there."""

    amplitude: float = meaning("largest value [N m or N]")
    start: float = meaning("frequency at the beginning of the sweep [Hz]")
    end: float = meaning("frequency at its end [Hz]")
    duration: float = meaning("how long the sweep takes [s]")
    logarithmic: bool = meaning("whether the frequency grows by equal factors instead of equal steps", False)

    def __post_init__(self) -> None:
        _check_finite(self, "amplitude", "start", "end", "duration")
        if self.duration <= 0.0:
            raise InputRefused(f"sweep: duration = {self.duration:.6g} s must be above 0: give its length")
        if self.logarithmic and (self.start <= 0.0 or self.end <= 0.0):
            raise InputRefused("sweep: a logarithmic sweep needs frequencies above 0 Hz: raise them")

    def _at(self, time: Array) -> Array:
        inside = np.minimum(time, self.duration)
        rate = self.end / self.start if self.logarithmic else 1.0
        if rate != 1.0:
            turns = self.start * self.duration / log(rate) * np.expm1(inside / self.duration * log(rate))
        else:
            turns = self.start * inside + 0.5 * (self.end - self.start) / self.duration * inside**2
        turns = turns + self.end * (time - inside)
        return self.amplitude * np.sin(2.0 * pi * turns)


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Multisine(Signal):
    """A sum of sines."""

    amplitudes: tuple[float, ...] = meaning("of each sine [N m or N]")
    frequencies: tuple[float, ...] = meaning("of each sine [Hz]")
    phases: tuple[float, ...] = meaning("of each sine [rad]; zero if left out", ())

    def __post_init__(self) -> None:
        if len(self.amplitudes) != len(self.frequencies) or len(self.phases) not in (0, len(self.amplitudes)):
            raise InputRefused(
                f"multisine: {len(self.amplitudes)} amplitudes, {len(self.frequencies)} frequencies and "
                f"{len(self.phases)} phases: give one of each per sine"
            )
        if not np.isfinite([*self.amplitudes, *self.frequencies, *self.phases]).all():
            raise InputRefused("multisine: a number is not finite: give finite ones")

    def _at(self, time: Array) -> Array:
        phases = self.phases or (0.0,) * len(self.amplitudes)
        total = np.zeros(time.size)
        for amplitude, frequency, phase in zip(self.amplitudes, self.frequencies, phases, strict=True):
            total += amplitude * np.sin(2.0 * pi * frequency * time + phase)
        return total


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sampled(Signal):
    """Values at equal intervals from the start of the run."""

    values: Array = meaning("(n,): the samples [N m or N]")
    rate: float = meaning("samples per second [Hz]")
    hold: bool = meaning(
        "whether a sample holds until the next one, as from a digital controller, instead of a straight line",
        False,
    )

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.float64)
        if values.ndim != 1 or values.size == 0:
            raise InputRefused(
                f"sampled signal: shape {values.shape}, not a row of samples: give one number per time"
            )
        if not np.isfinite(values).all():
            bad = int(np.flatnonzero(~np.isfinite(values))[0])
            raise InputRefused(f"sampled signal: sample {bad} is {values[bad]}: give finite numbers")
        if not (isfinite(self.rate) and self.rate > 0.0):
            raise InputRefused(f"sampled signal: rate = {self.rate} Hz must be above 0 and finite")
        object.__setattr__(self, "values", values)

    @property
    def lasts(self) -> float:
        """Time of the last sample, or the end of its hold [s]."""
        return (self.values.size - (0 if self.hold else 1)) / self.rate

    @property
    def fingerprint(self) -> str:
        """Rate, kind, and a digest of the samples."""
        return f"Sampled({self.rate!r}, {self.hold}, {sha256(self.values.tobytes()).hexdigest()})"

    def _at(self, time: Array) -> Array:
        place = np.clip(time * self.rate, 0.0, self.values.size - 1.0)
        # a time meant to be that of a sample must not fall into the interval before it by rounding
        nearest = np.rint(place)
        place = np.where(np.abs(place - nearest) < 1e-9 * np.maximum(nearest, 1.0), nearest, place)
        before = np.floor(place).astype(np.intp)
        if self.hold:
            return self.values[before]
        after = np.minimum(before + 1, self.values.size - 1)
        share = place - before
        return (1.0 - share) * self.values[before] + share * self.values[after]


@dataclass(frozen=True, slots=True, eq=False)
class FromFunction(Signal):
    """A signal computed by a function of time, of one time or of an array of them."""

    function: Function

    @property
    def fingerprint(self) -> str:
        """Name of the function: what it computes cannot be seen from outside."""
        module, name = (getattr(self.function, key, "?") for key in ("__module__", "__qualname__"))
        return f"FromFunction({module}.{name})"

    def _at(self, time: Array) -> Array:
        try:
            values = np.asarray(self.function(time), dtype=np.float64)
        except (TypeError, ValueError):  # a function of one time
            values = np.array([self.function(t) for t in time], dtype=np.float64)
        return np.broadcast_to(values, time.shape).copy()


def signal_of(given: Signal | float | Function, what: str) -> Signal:
    """Signal from what a caller gives: itself, a constant, a function of time; else refused in words."""
    if isinstance(given, Signal):
        return given
    if callable(given):
        return FromFunction(given)
    try:
        return Constant(float(given))
    except (TypeError, ValueError):
        raise InputRefused(
            f"{what} is a {type(given).__name__}: give a number, a function of time, or Sampled(...)"
        ) from None


def checked_signal(given: Signal | float | Function, what: str, duration: float, step: float) -> Signal:
    """As `signal_of`; refused in the words for it where it ends before the run [s], or outruns its step."""
    signal = signal_of(given, what)
    if signal.lasts < duration * (1.0 - 1e-12):
        raise InputRefused(
            f"{what} ends at {signal.lasts:.9g} s, before the run of {duration:.9g} s: give more samples"
        )
    if isinstance(signal, Sine) and abs(signal.frequency) * step > 0.5:
        said = f"frequency = {signal.frequency:.4g} Hz has less than two steps of {step:.3g} s per period"
        raise InputRefused(f"{said}: give at most {0.5 / step:.4g} Hz, or a shorter step")
    return signal


def _check_finite(signal: Signal, *names: str) -> None:
    for name in names:
        value = getattr(signal, name)
        if not isfinite(value):
            raise InputRefused(
                f"{type(signal).__name__.lower()}: {name} = {value} must be finite: give a number"
            )


@described
@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarriageForce:
    """A force on a carriage."""

    signal: Signal | float | Function = meaning("the force [N]")
    carriage: int = meaning("which carriage, in the order of the drive file", 0)
    plane: str = meaning("along the span, or across it", "u")


def checked_forces(
    drive: Machine, forces: Sequence[CarriageForce], duration: float, step: float
) -> tuple[Signal, ...]:
    """Signals of forces on the carriages of a drive; refused: a carriage or a direction that is not there."""
    for force in forces:
        count = len(drive.carriage)
        if not 0 <= force.carriage < count:
            said = f"force on carriage {force.carriage}, but the drive has {count}"
            raise InputRefused(f"{said}, numbered from 0")
        if force.plane not in ("u", "v", "w"):
            raise InputRefused(f'force: plane = "{force.plane}" is not one of its values: write u, v or w')
        if force.plane != "u" and drive.carriage[force.carriage].guided:
            raise InputRefused(
                f"force along {force.plane} on carriage {force.carriage}, which is guided: push along u"
            )
    return tuple(
        checked_signal(force.signal, f"force on carriage {force.carriage}", duration, step)
        for force in forces
    )


def offsets_of(drive: Machine) -> list[float]:
    """Constant torque of each motor's own [N m]; 0 for a pulley that has none."""
    return [motor.offset_torque for motor in drive.motor] or [0.0 for _ in drive.turned]


def motor_torques(
    names: tuple[str, ...],
    torque: Mapping[str, Signal | float | Function] | Signal | float | Function,
    duration: float,
    step: float,
) -> tuple[Signal, ...]:
    """Torque of each motor by the name of its pulley; one torque is that of the first."""
    given = torque if isinstance(torque, Mapping) else ({names[0]: torque} if names else {})
    if not names and not isinstance(torque, Mapping) and torque != 0.0:
        raise InputRefused('kind = "route": there is no [[pulley]] on which a torque could act: add one')
    for name in given:
        if name not in names:
            raise InputRefused(f'torque on "{str(name)[:60]}": the motors are {", ".join(names) or "none"}')
    return tuple(checked_signal(given.get(name, 0.0), f"torque on {name}", duration, step) for name in names)
