"""The equation of motion of one rigid axis as rows of a regression, filtered alike on both sides."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from cabledrive.identification.axis_equation import AxisEquation, filtered
from cabledrive.identification.filters import causal_filter, difference, zero_phase
from cabledrive.identification.friction_regressors import dead_zone, direction_of, friction_columns
from cabledrive.identification.regression import Factors, factor

Array = NDArray[np.float64]

LAG = "lag"
"""Name of the column of the time by which the torque acts later than it is logged."""
SIGN_BANDWIDTHS = 2.5
"""Bandwidth of the speed whose sign is taken, in bandwidths of the regression."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rows:
    """Rows of the regression.

    Attributes
    ----------
    names : tuple of str
    regressors : ndarray, shape (rows, p)
    left : ndarray, shape (rows,)
        Filtered torque or force.
    speed : ndarray, shape (rows,)
    keep : ndarray of bool, shape (samples,)
        Which samples of the log became rows.
    """

    names: tuple[str, ...]
    regressors: Array
    left: Array
    speed: Array
    keep: NDArray[np.bool_]


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
