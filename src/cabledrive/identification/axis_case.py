r"""One log of a rigid axis, ready to be simulated and weighed by its own spectrum.

Noise of a torque comes out of a simulated axis as :math:`1/\omega`, rounding of an encoder goes into a speed
as :math:`\omega`. Unweighted, the slow drift of the first hides what the log knows, and neighbouring segments
depend on one another. The weight :math:`1/\sqrt{S(\omega)}` of the smoothed spectrum S makes the residual
white in its band; the estimating equations have the same solution on average under any such weight.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.inverse_dynamics import AxisEquation, quick_speed, settling
from cabledrive.identification.logs.log import Log
from cabledrive.identification.torque_timing import spectral_lines
from cabledrive.parameters import NotComputed
from cabledrive.reduction.friction_integration import integrate_rigid_axis

Array = NDArray[np.float64]

BANDS = 24
LONGEST_SEGMENT = 8.0
"""Of the records whose spectra are averaged [s]."""
REACH = 4.0
"""Half of the filter's length [s]; a short one cannot follow the corner, some tenths of a hertz, below which
noise of the torque no longer grows."""
SHARE = 1 / 16
"""Of the shortest log, that half of the filter's length at most."""
INSIDE = 0.8
"""Share of the bandwidth of the compared signals that is used: above, their filter leaves too little."""


def whitener(residuals: Sequence[Array], interval: float, bandwidth: float) -> Array:
    """Symmetric filter that makes residuals white below a bandwidth.

    ``residuals``, shape (rows,); ``interval`` [s]; ``bandwidth``: of the residuals [Hz].
    Returns shape (2 m + 1,): weights; the filtered residual has a power density of 1 [1/Hz].
    """
    shortest = min(r.size for r in residuals)
    length = min(round(LONGEST_SEGMENT / interval), shortest)
    spectra = [signal.welch(r, 1.0 / interval, nperseg=length, detrend=False) for r in residuals]
    frequency, power = spectra[0][0], np.mean([s[1] for s in spectra], axis=0)
    top = INSIDE * bandwidth
    edges = np.geomspace(frequency[1], top, BANDS + 1)
    bands = [(frequency >= a) & (frequency < b) for a, b in pairwise(edges)]
    filled = [band for band in bands if band.any()]
    middles = [float(np.mean(np.log(frequency[band]))) for band in filled]
    levels = [float(np.mean(np.log(power[band] + 1e-300))) for band in filled]
    smooth = np.interp(np.log(np.maximum(frequency, frequency[1])), middles, levels)
    gain = np.exp(-0.5 * smooth) * np.clip((bandwidth - frequency) / (bandwidth - top), 0.0, 1.0)
    impulse = np.fft.fftshift(np.fft.irfft(gain))
    reach = min(round(REACH / interval), round(SHARE * shortest), impulse.size // 2 - 1)
    middle = impulse.size // 2
    window = np.hanning(2 * reach + 3)[1:-1]
    return np.asarray(impulse[middle - reach : middle + reach + 1] * window)


def whitened(rows: Array, weights: Array) -> Array:
    """Columns through the filter of `whitener`.

    ``rows``, shape (rows, columns); ``weights``, shape (2 m + 1,).
    Returns shape (rows, columns): nothing is assumed beyond both ends.
    """
    return np.asarray(signal.oaconvolve(rows, weights[:, None], mode="same", axes=0))


BANDWIDTH = 50.0
"""Of the compared speeds [Hz]."""
FORGOTTEN = 1e-3
"""Remainder of an initial change of the speed, when the comparison begins, below which it has no effect."""
LATER = 0.05
"""Step of the torque's instant by which its sensitivity is taken [intervals]."""
CORNER, CORNER_DOUBT = 6 / 48, 2 / 48
"""Means over the interval of a smooth torque; 4/48 for its point samples, 8/48 where the command stands from
sample to sample. The doubt is the distance to both."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """One log, ready to be simulated."""

    # torque, lines: (samples,): as measured, and its spectral lines alone
    torque: Array
    lines: Array
    speed: Array  # (samples,): Measured, filtered
    start: float  # measured speed at the first sample
    interval: float
    inner: slice  # samples for which the filter has settled
    bandwidth: float  # [Hz]
    slope: float  # of smooth friction; 0: set-valued
    quantum: float = 0.0  # step of the encoder [rad or m]; 0: none
    weights: Array | None = None  # filter that makes the residual white
    lag: bool = False  # whether the instant at which the torque acts is free

    def filtered(self, values: Array) -> Array:
        """Signals below the bandwidth.

        ``values``, shape (samples, ...).
        """
        return zero_phase(values, self.interval, self.bandwidth)

    def compared(self, rows: Array) -> Array:
        """Filtered signals as they are compared: without the filter's ends, weighted.

        ``rows``, shape (samples, columns).
        Returns shape (rows, columns).
        """
        inner = rows[self.inner]
        return inner if self.weights is None else whitened(inner, self.weights)


def between_samples(values: Array, share: float = CORNER) -> Array:
    r"""Corners of a polygon that runs through the band of a signal without loss.

    A polygon through point samples loses :math:`(\omega T)^2/12` of every sine, a mean over the interval
    :math:`(\omega T)^2/24` more, and where a command stands from sample to sample the mean that much again:
    its corners are moved out by that. What a channel holds is seldom known.

    ``values``, shape (samples,); ``share``: of the second difference that is taken off; default: that of
    means of a smooth torque.
    Returns shape (samples,).
    """
    moved = values.copy()
    moved[1:-1] -= share * np.diff(values, 2)
    return moved


def case_of(log: Log, torque: str, position: str, equation: AxisEquation) -> Case:
    """Prepare one log.

    ``torque``, ``position``: channels.
    """
    bandwidth = min(BANDWIDTH, 0.2 * log.sample_rate)
    angle = log.channel(position)
    edge = settling(bandwidth, log.interval)
    slope = equation.friction.slope if equation.friction.kind == "tanh" else 0.0
    return Case(
        torque=between_samples(log.channel(torque)),
        lines=between_samples(spectral_lines(log.channel(torque))),
        speed=zero_phase(difference(angle, log.interval), log.interval, bandwidth),
        start=float(quick_speed(angle, equation, log.interval)[0]),
        interval=log.interval,
        inner=slice(edge, len(log) - edge),
        bandwidth=bandwidth,
        slope=slope,
        quantum=equation.quantum,
        lag=equation.lag,
    )


def observed(case: Case, angle: Array) -> Array:
    """Filtered speed from a measured angle.

    ``angle``, shape (samples,).
    Returns shape (samples,).
    """
    return case.filtered(difference(angle, case.interval))


def simulated_speed(case: Case, values: Array) -> Array:
    """Speed of the model under the torque's spectral lines.

    ``values``, shape (4,).
    Returns shape (samples,).
    """
    return integrate_rigid_axis(values, case.lines, case.interval, start=case.start, slope=case.slope)[0]


def simulated(case: Case, values: Array, start: float) -> tuple[Array, Array]:
    """Filtered, weighted difference of speeds, and sensitivities alike.

    ``values``, shape (4,); ``start``: speed at the first sample.
    Returns ``residual``, shape (rows,); ``sensitivities``, shape (rows, 5 or 6): by the four parameters, the
    speed at the start and, where it is free, the instant of the torque. By the speed at the start: zero where
    the axis stops before the comparison begins, since what is left of it then is the filter's tail alone.
    Raises `NotComputed` if the motion or a sensitivity leaves the finite numbers.
    """
    moved, _ = integrate_rigid_axis(values, case.torque, case.interval, start=start, slope=case.slope)
    before, along = integrate_rigid_axis(values, case.lines, case.interval, start=start, slope=case.slope)
    if np.abs(along[case.inner, 4]).max() < FORGOTTEN:
        along[:, 4] = 0.0
    columns = [moved, along]
    if case.lag:
        later = case.lines - LATER * np.gradient(case.lines)
        after, _ = integrate_rigid_axis(values, later, case.interval, start=start, slope=case.slope)
        with np.errstate(invalid="ignore", over="ignore"):  # a motion that runs away: refused below
            columns.append((after - before) / (LATER * case.interval))
    filtered = case.filtered(np.column_stack(columns))
    rows = case.compared(np.column_stack([case.speed - filtered[:, 0], filtered[:, 1:]]))
    if not np.all(np.isfinite(rows)):
        raise NotComputed("the model does not reproduce the log in open loop: its motion diverges")
    return rows[:, 0], rows[:, 1:]


def columns_of(sensitivities: Array, number: int, count: int) -> Array:
    """Sensitivities of one of several logs: each has its own speed at the start.

    ``sensitivities``, shape (rows, 5 or 6): of `simulated`; ``number``, ``count``: of the log, and how many
    there are.
    Returns shape (rows, 4 + count or 5 + count).
    """
    rows, shared = sensitivities.shape
    columns = np.zeros((rows, shared - 1 + count))
    columns[:, :4] = sensitivities[:, :4]
    columns[:, 4 + number] = sensitivities[:, 4]
    columns[:, 4 + count :] = sensitivities[:, 5:]
    return columns


def weighed(cases: Sequence[Case], values: Array, speeds: Array) -> list[Case]:
    """Cases whose residuals are weighted by their spectrum at given parameters.

    ``cases``: of one sample rate; others stay as they are; ``values``, shape (4,); ``speeds``, shape
    (cases,): at the start.
    """
    if len({case.interval for case in cases}) > 1:
        return list(cases)
    residuals = [simulated(case, values, v)[0] for case, v in zip(cases, speeds, strict=True)]
    weights = whitener(residuals, cases[0].interval, cases[0].bandwidth)
    return [replace(case, weights=weights) for case in cases]
