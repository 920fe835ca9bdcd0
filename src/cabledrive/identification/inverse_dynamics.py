"""The equation of motion of one rigid axis as rows of a regression, with its regressors of friction."""

from dataclasses import dataclass, field
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from scipy.integrate import cumulative_trapezoid

from cabledrive.identification.filters import (
    butterworth,
    causal_filter,
    difference,
    ideal_low_pass,
    zero_phase,
)
from cabledrive.identification.regression import Factors, factor
from cabledrive.parameters import InputRefused

Array = NDArray[np.float64]

FRICTIONS = ("coulomb", "tanh", "asymmetric", "asymmetric-offset", "stribeck", "viscous")
PRINTED_SLOPE = 0.5
"""K of (4.8) [s/rad]: wide; b and c mean something only together with it."""
DEAD_ZONE_DEVIATIONS = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionModel:
    """Which friction is fitted."""

    kind: str = "coulomb"  # one of `FRICTIONS`
    slope: float = PRINTED_SLOPE  # K of c tanh(K w) [s/rad]
    fading: float = 0.0  # speed at which the excess of Stribeck friction has fallen to 1/e [rad/s]

    def __post_init__(self) -> None:
        if self.kind not in FRICTIONS:
            raise InputRefused(f'friction "{self.kind}" is unknown: take one of {", ".join(FRICTIONS)}')


def dead_zone(quantum: float, interval: float, cutoff: float) -> float:
    """Speed below which its sign is not known: the deviation that the encoder's rounding makes, times 2.

    ``quantum``: step of the encoder [rad]; ``interval`` [s]; ``cutoff``: bandwidth of the speed [Hz].
    Returns [rad/s].
    """
    frequency, response = signal.freqz_sos(butterworth(interval, cutoff), worN=2048, fs=1 / interval)
    gain = np.abs(response) ** 2 * 2 * pi * frequency
    return DEAD_ZONE_DEVIATIONS * quantum / sqrt(12) * float(np.sqrt(np.mean(gain**2)))


def direction_of(speed: Array, zone: float, shortest: int = 1) -> Array:
    """Sign of the speed, zero while it rests inside the dead zone.

    ``speed`` [rad/s]; ``zone`` [rad/s]; ``shortest``: samples that a rest lasts at least; a turn that passes
    through the zone sooner is no rest.
    """
    inside = np.abs(speed) <= zone
    edges = np.flatnonzero(np.diff(np.concatenate(([0], inside.astype(np.int8), [0]))))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        if end - start < shortest:
            inside[start:end] = False
    return np.where(inside, 0.0, np.sign(speed))


def friction_columns(model: FrictionModel, speed: Array, sign: Array, offset: str) -> dict[str, Array]:
    r"""Regressors beside the acceleration, by the parameter that multiplies them, Eqs. (4.8), (4.11), (4.12).

    .. math:: \tau = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d

    ``speed``, shape (samples,) [rad/s]; ``sign``, shape (samples,): its direction, see `direction_of`;
    ``offset``: name of the offset: "offset_torque" or "offset_force".
    Returns the regressor of the offset is -1, as in (4.9).
    """
    plain = {"viscous_friction": speed, "coulomb_friction": sign, offset: np.full_like(speed, -1.0)}
    if model.kind == "coulomb":
        return plain
    if model.kind == "viscous":
        return {"viscous_friction": speed, offset: plain[offset]}
    if model.kind == "tanh":
        return plain | {"coulomb_friction": np.tanh(model.slope * speed)}
    if model.kind == "stribeck":
        return plain | {"stribeck_friction": sign * np.exp(-((speed / model.fading) ** 2))}
    forth, back = speed > 0.0, speed < 0.0
    sides = {
        "viscous_friction_positive": np.where(forth, speed, 0.0),
        "coulomb_friction_positive": np.maximum(sign, 0.0),
        "viscous_friction_negative": np.where(back, speed, 0.0),
        "coulomb_friction_negative": np.minimum(sign, 0.0),
    }
    return sides | {offset: plain[offset]} if model.kind == "asymmetric-offset" else sides


FILTERS = ("zero-phase", "causal", "ideal")


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisEquation:
    """How the regression of one axis is formed."""

    linear: bool  # whether the axis slides (mass, force) instead of turning (inertia, torque)
    bandwidth: float  # of the filter on both sides [Hz]
    # one of `FILTERS`: Butterworth of order 4 forwards and backwards; (4.1) with damping 1; ideal
    filter: str = "zero-phase"
    friction: FrictionModel = field(default_factory=FrictionModel)
    quantum: float = 0.0  # step of the position [rad or m]; 0: none
    # friction over inertia [rad/s^2 or m/s^2]: the jump of the acceleration at a turn is twice that. Known
    # roughly from a first pass; the speed whose sign is taken then keeps its kinks when it is smoothed
    kink: float = 0.0
    # whether the rate of the torque is the last column, see `cabledrive.identification.torque_timing`
    lag: bool = False

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


def filtered(values: Array, equation: AxisEquation, interval: float) -> Array:
    """One signal through the filter of the regression, Eqs. (4.4), (4.5).

    ``values``, shape (samples,); ``interval`` [s].
    Returns shape (samples,).
    """
    if equation.filter == "causal":
        return causal_filter(values, interval, equation.bandwidth)[0]
    if equation.filter == "ideal":
        return ideal_low_pass(values, interval, equation.bandwidth)
    return zero_phase(values, interval, equation.bandwidth)


LAG = "lag"
"""Name of the column of the time by which the torque acts later than it is logged."""
SIGN_BANDWIDTHS = 2.5
"""Bandwidth of the speed whose sign is taken, in bandwidths of the regression."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Rows of the regression."""

    names: tuple[str, ...]
    regressors: Array  # (rows, p)
    left: Array  # (rows,): filtered torque or force
    speed: Array  # (rows,)
    keep: NDArray[np.bool_]  # (samples,): which samples of the log became rows


def settling(bandwidth: float, interval: float) -> int:
    """Samples at each end that the filter has not settled for.

    ``bandwidth`` [Hz]; ``interval`` [s].
    """
    return int(np.ceil(2.0 / (bandwidth * interval)))


def motion(position: Array, equation: AxisEquation, interval: float) -> tuple[Array, Array]:
    """Filtered speed and acceleration.

    ``position``, shape (samples,); ``interval`` [s].
    Returns ``speed, acceleration``, shape (samples,).
    """
    if equation.filter == "causal":
        _, speed, acceleration = causal_filter(position, interval, equation.bandwidth)
        return speed, acceleration
    speed = difference(filtered(position, equation, interval), interval)
    return speed, difference(speed, interval)


def quick_band(equation: AxisEquation, interval: float) -> float:
    """Bandwidth of the speed whose sign makes the friction.

    ``interval`` [s].
    Returns [Hz].
    """
    return min(SIGN_BANDWIDTHS * equation.bandwidth, 0.4 / interval)


def quick_speed(position: Array, equation: AxisEquation, interval: float) -> Array:
    """Speed whose sign makes the friction: quicker than the regression's, and with its kinks kept.

    At a turn Coulomb friction makes the acceleration jump. Smoothing the kink of the speed would see every
    turn too late. So the motion that friction alone makes is taken away first, and put back afterwards.

    ``position``, shape (samples,); ``interval`` [s].
    Returns shape (samples,).
    """
    band = quick_band(equation, interval)
    speed = difference(zero_phase(position, interval, band), interval)
    if equation.kink <= 0.0:
        return speed
    by_friction = cumulative_trapezoid(-equation.kink * np.sign(speed), dx=interval, initial=0.0)
    moved = cumulative_trapezoid(by_friction, dx=interval, initial=0.0)
    return difference(zero_phase(position - moved, interval, band), interval) + by_friction


def rows_of(
    position: Array,
    torque: Array,
    equation: AxisEquation,
    interval: float,
    masked: NDArray[np.bool_] | None = None,
    every: int = 1,
) -> Rows:
    """Rows of the regression of one axis, Eqs. (4.9), (4.10).

    ``position``, ``torque``, shape (samples,): angle [rad] and torque [N m], or position [m] and force [N];
    ``interval`` [s]; ``masked``: samples that must not be used, with the filter's reach around them (a
    saturated torque); ``every``: take every so many-th row; filtered rows need not be closer than a tenth of
    the bandwidth's period.
    """
    speed, acceleration = motion(position, equation, interval)
    quick = quick_speed(position, equation, interval)
    zone = 0.0
    if equation.quantum > 0.0 and not equation.friction.kind.startswith("asymmetric"):
        zone = dead_zone(equation.quantum, interval, quick_band(equation, interval))
    sign = direction_of(quick, zone, int(0.5 / (quick_band(equation, interval) * interval)))
    columns = {equation.inertia: acceleration}
    for name, column in friction_columns(equation.friction, quick, sign, equation.offset).items():
        smooth = name == "viscous_friction" or np.ptp(column) == 0.0
        columns[name] = (
            (speed if name == "viscous_friction" else column)
            if smooth
            else filtered(column, equation, interval)
        )
    left = filtered(torque, equation, interval)
    if equation.lag:
        columns[LAG] = difference(left, interval)
    keep = np.ones(position.size, dtype=bool)
    edge = settling(equation.bandwidth, interval)
    keep[:edge] = keep[keep.size - edge :] = False
    if masked is not None and masked.any():
        keep &= ~(np.convolve(masked, np.ones(edge), "same") > 0.5)
    keep &= np.arange(keep.size) % every == 0
    return Rows(
        names=tuple(columns),
        regressors=np.column_stack([column[keep] for column in columns.values()]),
        left=left[keep],
        speed=speed[keep],
        keep=keep,
    )


def factors_of(rows: Rows, segments: int) -> Factors:
    """Rows reduced to triangles."""
    return factor(rows.regressors, rows.left, rows.names, segments)
