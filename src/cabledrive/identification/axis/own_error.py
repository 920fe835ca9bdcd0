r"""What a method misses on logs of its own making: the part of its error that scores cannot show.

The rounding of an encoder and the instants of turns repeat from period to period; every segment of a log then
errs alike, and the spread of the segments' scores does not contain it. So the fitted axis is moved under the
measured torque, its angle is rounded at a few phases of the encoder, and the method is applied to that. What
the mean square of its misses has beyond the covariance that the scores claim there is added:

.. math:: C' = C + \Big[\frac1K\sum_k (m_k m_k^T - C_k)\Big]_+
"""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import cumulative_trapezoid

from cabledrive.identification.axis.axis import Axis, values_of
from cabledrive.identification.axis.observer import between_samples
from cabledrive.identification.estimates import Identification
from cabledrive.identification.logs.log import Log
from cabledrive.parameters import NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.friction_integration import integrate_rigid_axis

FARTHEST = 1e6
"""Strokes of the log beyond which a motion of the fitted axis counts as diverging."""
PHASES = 4
"""Positions of the encoder that are tried."""


def rounded_angles(speed: Array, interval: float, quantum: float) -> Array:
    """Angle of a motion as an encoder at several phases shows it, shape (samples, phases)."""
    angle = cumulative_trapezoid(speed, dx=interval, initial=0.0)[:, None]
    phases = np.arange(PHASES) / PHASES
    return quantum * np.floor(angle / quantum + phases) if quantum > 0.0 else angle + 0.0 * phases


def unseen(misses: Sequence[Array], claimed: Sequence[Array]) -> Array:
    """Mean products of misses beyond the covariance that was claimed for them."""
    off = np.array(misses)
    excess = off.T @ off / len(off) - np.mean(claimed, axis=0)
    size = np.sqrt(np.maximum(np.mean(off**2, axis=0), 1e-300))
    level, direction = np.linalg.eigh(excess / size[:, None] / size)
    kept = size[:, None] * direction * np.sqrt(np.maximum(level, 0.0))
    return np.asarray(kept @ kept.T)


def with_own_error(axis: Axis, found: Identification) -> Identification:
    """Inverse dynamics with the errors that it makes on logs of its own making in its intervals.

    As it was, and said, where the fitted axis cannot be moved or its own log is not identifiable.
    """
    try:
        angles = [_made(axis, log, values_of(found)) for log in axis.logs]
        fits = [
            axis.having(axis.position, (angle[:, k] for angle in angles)).regressed() for k in range(PHASES)
        ]
        misses = [fit.values - found.values for fit in fits]
        if not np.all(np.isfinite(misses)):
            raise NotComputed("not identifiable")
    except NotComputed as failure:
        return found.noting(own_error=f"not known: {failure}")
    return found.widened(unseen(misses, [fit.covariance for fit in fits]))


def _made(axis: Axis, log: Log, values: Array) -> Array:
    """Rounded angles of the fitted axis under the torque of one log; refused where it runs away."""
    driven = between_samples(log.channel(axis.torque))
    speed, _ = integrate_rigid_axis(values, driven, log.interval, start=axis.start(log), slope=axis.slope)
    farthest = FARTHEST * np.ptp(log.channel(axis.position))
    if np.abs(speed).max() * log.interval < farthest:  # before sums of it overflow
        angle = rounded_angles(speed, log.interval, log.report.quantum.get(axis.position, 0.0))
        if np.abs(angle).max() < farthest:
            return angle
    raise NotComputed("the motion of the fitted axis diverges under the measured torque")
