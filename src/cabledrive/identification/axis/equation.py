"""The equation of motion of one rigid axis as rows of a regression, with its regressors of friction."""

from dataclasses import dataclass, field
from math import pi, sqrt

import numpy as np
from scipy import signal
from scipy.integrate import cumulative_trapezoid

from cabledrive.identification.filters import (
    butterworth,
    causal_filter,
    difference,
    ideal_low_pass,
    zero_phase,
)
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

FRICTIONS = ("coulomb", "tanh", "asymmetric", "asymmetric-offset", "stribeck", "viscous")
FILTERS = ("zero-phase", "causal", "ideal")
"""Butterworth of order 4 forwards and backwards; (4.1) with damping 1; ideal."""
PRINTED_SLOPE = 0.5
"""K of (4.8) [s/rad]: wide; b and c mean something only together with it."""
DEAD_ZONE_DEVIATIONS = 2.0
SIGN_BANDWIDTHS = 2.5
"""Bandwidth of the speed whose sign is taken, in bandwidths of the regression."""
LAG = "lag"
"""Name of the column of the time by which the torque acts later than it is logged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionModel:
    """Which friction is fitted."""

    kind: str = "coulomb"  # one of `FRICTIONS`
    slope: float = PRINTED_SLOPE  # K of c tanh(K w) [s/rad]
    fading: float = 0.0  # speed at which the excess of Stribeck friction has fallen to 1/e [rad/s]

    def __post_init__(self) -> None:
        if self.kind not in FRICTIONS:
            raise InputRefused(f'friction "{self.kind}" is unknown: take one of {", ".join(FRICTIONS)}')

    def columns(self, speed: Array, sign: Array, offset: str) -> dict[str, Array]:
        r"""Regressors beside the acceleration, by their parameter, Eqs. (4.8), (4.11), (4.12).

        .. math:: \tau = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d

        ``sign``: direction of the speed [rad/s], both (samples,); ``offset``: name of the parameter whose
        regressor is -1, as in (4.9).
        """
        plain = {"viscous_friction": speed, "coulomb_friction": sign, offset: np.full_like(speed, -1.0)}
        if self.kind == "coulomb":
            return plain
        if self.kind == "viscous":
            return {"viscous_friction": speed, offset: plain[offset]}
        if self.kind == "tanh":
            return plain | {"coulomb_friction": np.tanh(self.slope * speed)}
        if self.kind == "stribeck":
            return plain | {"stribeck_friction": sign * np.exp(-((speed / self.fading) ** 2))}
        sides = {
            "viscous_friction_positive": np.where(speed > 0.0, speed, 0.0),
            "coulomb_friction_positive": np.maximum(sign, 0.0),
            "viscous_friction_negative": np.where(speed < 0.0, speed, 0.0),
            "coulomb_friction_negative": np.minimum(sign, 0.0),
        }
        return sides | {offset: plain[offset]} if self.kind == "asymmetric-offset" else sides


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisEquation:
    """How the regression of one axis is formed."""

    linear: bool  # whether the axis slides (mass, force) instead of turning (inertia, torque)
    bandwidth: float  # of the filter on both sides [Hz]
    filter: str = "zero-phase"  # one of `FILTERS`
    friction: FrictionModel = field(default_factory=FrictionModel)
    quantum: float = 0.0  # step of the position [rad or m]; 0: none
    # friction over inertia [rad/s^2 or m/s^2]: the jump of the acceleration at a turn is twice that. Known
    # roughly from a first pass; the speed whose sign is taken then keeps its kinks when it is smoothed
    kink: float = 0.0
    lag: bool = False  # whether the rate of the torque is the last column, see `axis.timing`

    def __post_init__(self) -> None:
        if self.filter not in FILTERS:
            raise InputRefused(f'filter "{self.filter}" is unknown: take one of {", ".join(FILTERS)}')

    @property
    def offset(self) -> str:
        """Name of the constant torque or force."""
        return "offset_force" if self.linear else "offset_torque"

    @property
    def inertia(self) -> str:
        """Name of the inertia."""
        return "mass" if self.linear else "inertia"

    def filtered(self, values: Array, interval: float) -> Array:
        """One signal (samples,) through the filter of the regression, Eqs. (4.4), (4.5)."""
        if self.filter == "causal":
            return causal_filter(values, interval, self.bandwidth)[0]
        if self.filter == "ideal":
            return ideal_low_pass(values, interval, self.bandwidth)
        return zero_phase(values, interval, self.bandwidth)

    def motion(self, position: Array, interval: float) -> tuple[Array, Array]:
        """Filtered speed and acceleration (samples,)."""
        if self.filter == "causal":
            _, speed, acceleration = causal_filter(position, interval, self.bandwidth)
            return speed, acceleration
        speed = difference(self.filtered(position, interval), interval)
        return speed, difference(speed, interval)

    def sign_band(self, interval: float) -> float:
        """Bandwidth of the speed whose sign makes the friction [Hz]."""
        return min(SIGN_BANDWIDTHS * self.bandwidth, 0.4 / interval)

    def quick_speed(self, position: Array, interval: float) -> Array:
        """Speed whose sign makes the friction: quicker than the regression's, and with its kinks kept.

        At a turn Coulomb friction makes the acceleration jump. Smoothing the kink of the speed would see
        every turn too late. So the motion that friction alone makes is taken away first, and put back
        afterwards.
        """
        band = self.sign_band(interval)
        speed = difference(zero_phase(position, interval, band), interval)
        if self.kink <= 0.0:
            return speed
        by_friction = cumulative_trapezoid(-self.kink * np.sign(speed), dx=interval, initial=0.0)
        moved = cumulative_trapezoid(by_friction, dx=interval, initial=0.0)
        return difference(zero_phase(position - moved, interval, band), interval) + by_friction

    def columns(
        self, position: Array, torque: Array, interval: float
    ) -> tuple[dict[str, Array], Array, Array]:
        """Regressors by their parameter, left side and speed (samples,), Eqs. (4.9), (4.10)."""
        speed, acceleration = self.motion(position, interval)
        quick, band = self.quick_speed(position, interval), self.sign_band(interval)
        zone = 0.0
        if self.quantum > 0.0 and not self.friction.kind.startswith("asymmetric"):
            zone = dead_zone(self.quantum, interval, band)
        sign = direction_of(quick, zone, int(0.5 / (band * interval)))
        found = {self.inertia: acceleration}
        for name, column in self.friction.columns(quick, sign, self.offset).items():
            if name == "viscous_friction":
                found[name] = speed
            else:
                found[name] = column if np.ptp(column) == 0.0 else self.filtered(column, interval)
        left = self.filtered(torque, interval)
        return found | ({LAG: difference(left, interval)} if self.lag else {}), left, speed


def dead_zone(quantum: float, interval: float, cutoff: float) -> float:
    """Speed [rad/s] below which its sign is not known: twice the deviation that the encoder's rounding makes.

    ``quantum``: step of the encoder [rad]; ``cutoff``: bandwidth of the speed [Hz].
    """
    frequency, response = signal.freqz_sos(butterworth(interval, cutoff), worN=2048, fs=1 / interval)
    gain = np.abs(response) ** 2 * 2 * pi * frequency
    return DEAD_ZONE_DEVIATIONS * quantum / sqrt(12) * float(np.sqrt(np.mean(gain**2)))


def direction_of(speed: Array, zone: float, shortest: int = 1) -> Array:
    """Sign of the speed, zero while it rests inside the dead zone.

    ``shortest``: samples that a rest lasts at least; a turn that passes through the zone sooner is no rest.
    """
    inside = np.abs(speed) <= zone
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside.astype(np.int8), [0]))))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start < shortest:
            inside[start:end] = False
    return np.where(inside, 0.0, np.sign(speed))


def settling(bandwidth: float, interval: float) -> int:
    """Samples at each end that a filter of a bandwidth [Hz] has not settled for."""
    return int(np.ceil(2.0 / (bandwidth * interval)))
