"""Forced motions of the nonlinear loop itself, as the rig would show them."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.simulation.run import whole


@dataclass(frozen=True, slots=True, kw_only=True)
class ForcedCase:
    """A forced motion of a loop without carriages from plucks."""

    drive: Drive
    torque: float  # amplitude [N m]
    plucks: tuple[float, float]  # of the upper and the lower span [m]
    duration: float = 1.0  # [s]
    shape: Literal["half-sine", "triangle"] = "half-sine"
    forcing: float | None = None  # Omega [rad/s]; the pulley mode's own unless given

    @property
    def omega(self) -> float:
        """Angular frequency of the torque [rad/s]."""
        return self.forcing or autoparametric_model(self.drive).natural


class SeenMotion(NamedTuple):
    """What the rig would show, each of shape (n,)."""

    time: Array  # [s]
    load_angle: Array  # [rad]
    midpoint: Array  # of the upper span, in w [m]


def exact_motion(case: ForcedCase, segments: int = 200, rate: float = 4000.0) -> SeenMotion:
    """The motion of the nonlinear loop itself; ``segments`` per span, ``rate`` of the records [Hz]."""
    heights = (pair for pair in zip(case.plucks, ("upper", "lower"), strict=True) if pair[0] != 0.0)
    start = Start(plucks=tuple(Pluck(height=height, span=span, shape=case.shape) for height, span in heights))
    torque = Sine(amplitude=case.torque, frequency=case.omega / (2 * np.pi))
    scheme, recorded = Scheme(segments=segments), Recording(rate=rate)
    run = simulate(case.drive, case.duration, torque=torque, start=start, scheme=scheme, recording=recorded)
    result = whole(run)
    angle, midpoint = result.channel("load_angle"), result.midpoint("upper")[:, 2]
    return SeenMotion(time=result.time, load_angle=angle, midpoint=midpoint)


def envelope(time: Array, signal: Array, window: float) -> Array:
    """Largest size of a signal in each window [s], its linear trend removed; shape (windows,)."""
    level = signal - np.polyval(np.polyfit(time, signal, 1), time)
    number = np.floor((time - time[0]) / window).astype(int)
    peaks = np.zeros(number.max() + 1)
    np.maximum.at(peaks, number, np.abs(level))
    return peaks[: int(np.floor((time[-1] - time[0]) / window))]
