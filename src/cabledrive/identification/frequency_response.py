r"""Frequency responses from logs: H1, H2, Hv with coherence, and averages over the periods of a multisine.

With the cross and auto spectra of Welch's method over segments with windows,

.. math:: H_1 = S_{uy}/S_{uu}, \qquad H_2 = S_{yy}/S_{yu}, \qquad \gamma^2 = |S_{uy}|^2/(S_{uu}S_{yy})

H1 is unbiased under noise of the output, H2 under noise of the input, Hv (the eigenvector of the 2 by 2
spectral matrix, both channels scaled to equal noise) under both. H1 is what MATLAB's ``tfestimate`` computes.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import signal

from cabledrive.identification.filters import LeftOut, explained_records, ordinary_records
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Complex, Integers

ESTIMATORS = ("H1", "H2", "Hv")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FrequencyResponse:
    """Response at discrete frequencies."""

    frequency: Array  # (m,): [Hz]
    response: Complex  # (m,): output per input
    deviation: Array  # (m,): standard deviation of the response, of real and imaginary part together
    coherence: Array  # (m,): between 0 and 1; 1 where it is not estimated (one record)
    averages: float  # independent averages behind each value
    # (m,): level of the nonlinear distortion in the output at each frequency, from lines that are not excited
    nonlinear: Array | None = None
    # (m,): level of the noise in the output at each frequency, from the spread over periods
    noise: Array | None = None
    left_out: int = 0  # records that were left out as outliers
    blows: tuple[LeftOut, ...] = ()  # these records, where they are parts of a log

    @property
    def magnitude(self) -> Array:
        """Absolute value."""
        return np.abs(self.response)

    @property
    def phase(self) -> Array:
        """Phase [deg], between -180 and 180."""
        return np.degrees(np.angle(self.response))

    def between(self, low: float, high: float) -> "FrequencyResponse":
        """The part in a band [Hz]."""
        keep = (self.frequency >= low) & (self.frequency <= high)
        return replace(
            self,
            frequency=self.frequency[keep],
            response=self.response[keep],
            deviation=self.deviation[keep],
            coherence=self.coherence[keep],
            nonlinear=None if self.nonlinear is None else self.nonlinear[keep],
            noise=None if self.noise is None else self.noise[keep],
        )


def response_by_segments(
    input_: Array,
    output: Array,
    interval: float,
    *,
    segment: float = 1.0,
    overlap: float = 0.2,
    estimator: str = "H1",
    robust: bool = True,
) -> FrequencyResponse:
    """Response by windowed segments, what `tfestimate` does, Eq. (4.15).

    ``segment``, ``overlap``: of the Hann windows [s]; ``estimator``, {"H1", "H2", "Hv"}; ``robust``: leave
    out records in which the output does what neither its past nor the input explains. Refused if windows do
    not advance, the log is shorter than two of them, or the input stands still.
    """
    if estimator not in ESTIMATORS:
        raise InputRefused(f'estimator "{estimator}" is unknown: take one of {", ".join(ESTIMATORS)}')
    if segment <= 0.0:
        raise InputRefused(f"segment = {segment:.4g} s must be above 0: give the length of a window")
    if not 0.0 <= overlap < segment:
        raise InputRefused(
            f"overlap = {overlap:.4g} s must lie from 0 to below the segment of {segment:.4g} s: correct one"
        )
    length = round(segment / interval)
    hop = max(1, length - round(overlap / interval))
    starts = np.arange(0, input_.size - length + 1, hop)
    if length < 8 or starts.size < 2:
        raise InputRefused(
            f"{input_.size * interval:.4g} s hold {starts.size} windows of {segment:.4g} s: shorten them"
        )
    if np.ptp(input_) == 0.0:
        raise InputRefused("the input is constant: a response needs an excitation")
    window = signal.get_window("hann", length)
    rows = starts[:, None] + np.arange(length)
    u = np.fft.rfft(_centred(input_[rows]) * window, axis=1)[:, 1:]
    y = np.fft.rfft(_centred(output[rows]) * window, axis=1)[:, 1:]
    keep, excess = explained_records(input_, output, starts, length)
    keep = keep | (not robust)
    averages = _independent(int(keep.sum()), length, hop, window)
    frequency = np.asarray(np.fft.rfftfreq(length, interval)[1:], dtype=float)
    spectra = _spectra(u[keep], y[keep])
    found = _estimated(frequency, *spectra, averages, estimator, int((~keep).sum()))
    reason = "the output moves as neither the input nor its own past explains, {:.3g} times as much as usual"
    blows = tuple(
        LeftOut(
            start=float(starts[k] * interval),
            end=float((starts[k] + length) * interval),
            reason=reason.format(np.sqrt(excess[k])),
        )
        for k in np.flatnonzero(~keep)
    )
    return replace(found, blows=blows)


def response_by_periods(
    input_: Array, output: Array, interval: float, period: int, lines: Integers, skipped: int = 1
) -> FrequencyResponse:
    """Response to a periodic multisine: means over periods, no leakage, noise and distortion distinguished.

    ``period``: samples of one period; ``lines``: excited lines; ``skipped``: periods in which the motion
    settles. Distortion is that at lines in the excited band that are not excited.
    """
    count = input_.size // period - skipped
    if count < 2:
        raise InputRefused(
            f"{input_.size / period:.2g} periods, {skipped} skipped: record at least {skipped + 2}"
        )
    part = slice(skipped * period, (skipped + count) * period)
    u = np.fft.rfft(input_[part].reshape(count, period), axis=1) / period
    y = np.fft.rfft(output[part].reshape(count, period), axis=1) / period
    keep = ordinary_records(y)
    u, y = u[keep], y[keep]
    mean_u, mean_y = u.mean(axis=0), y.mean(axis=0)
    h = mean_y[lines] / mean_u[lines]
    noise = y.std(axis=0, ddof=1)
    error = (y[:, lines] - h * u[:, lines]).std(axis=0, ddof=1) / np.sqrt(len(y))
    return FrequencyResponse(
        frequency=lines / (period * interval),
        response=h,
        deviation=error / np.abs(mean_u[lines]),
        coherence=1.0 / (1.0 + (error / np.maximum(np.abs(mean_y[lines]), 1e-300)) ** 2),
        averages=float(len(y)),
        nonlinear=_distortion(mean_y, noise, lines, len(y)),
        noise=noise[lines],
        left_out=int((~keep).sum()),
    )


def _centred(rows: Array) -> Array:
    return signal.detrend(rows, axis=1, type="linear")


def _independent(records: int, length: int, hop: int, window: Array) -> float:
    """Number of independent averages behind overlapping windows."""
    shared = 0.0
    power = float(window @ window)
    for k in range(1, records):
        if k * hop >= length:
            break
        shared += (1 - k / records) * (float(window[k * hop :] @ window[: length - k * hop]) / power) ** 2
    return records / (1 + 2 * shared)


def _spectra(u: Complex, y: Complex) -> tuple[Array, Array, Complex]:
    return (np.abs(u) ** 2).mean(axis=0), (np.abs(y) ** 2).mean(axis=0), (np.conj(u) * y).mean(axis=0)


def _estimated(
    frequency: Array,
    uu: Array,
    yy: Array,
    uy: Complex,
    averages: float,
    estimator: str,
    left_out: int,
) -> FrequencyResponse:
    tiny = 1e-300
    coherence = np.clip(np.abs(uy) ** 2 / np.maximum(uu * yy, tiny), 0.0, 1.0)
    h1: Complex = uy / np.maximum(uu, tiny)
    if estimator == "H2":
        h = np.asarray(yy / np.where(np.abs(uy) > 0, np.conj(uy), tiny), dtype=complex)
    else:
        h = h1 if estimator == "H1" else _total_least_squares(uu, yy, uy)
    relative = np.sqrt((1 - coherence) / np.maximum(coherence, 1e-12) / averages)
    return FrequencyResponse(
        frequency=frequency,
        response=h,
        deviation=np.abs(h) * relative,
        coherence=coherence,
        averages=averages,
        left_out=left_out,
    )


def _total_least_squares(uu: Array, yy: Array, uy: Complex) -> Complex:
    """Hv: noise in both channels, alike once each is scaled by its mean spectrum."""
    scale = np.sqrt(yy / np.maximum(uu, 1e-300))
    scaled, power = yy / np.maximum(scale, 1e-300) ** 2, uu
    cross = np.abs(uy) / np.maximum(scale, 1e-300)
    gain = (scaled - power + np.sqrt((scaled - power) ** 2 + 4 * cross**2)) / (2 * np.maximum(cross, 1e-300))
    return gain * scale * np.exp(1j * np.angle(uy))


def _distortion(mean: Complex, noise: Array, lines: Integers, periods: int) -> Array | None:
    """Power at lines that are not excited, beyond the noise, carried over to the excited ones."""
    silent = np.setdiff1d(np.arange(lines.min(), lines.max() + 1), lines)
    if silent.size < 3:
        return None
    power = np.maximum(np.abs(mean[silent]) ** 2 - noise[silent] ** 2 / periods, 0.0)
    width = max(3, silent.size // 20)
    smooth = np.convolve(power, np.ones(width), "same") / np.convolve(
        np.ones_like(power), np.ones(width), "same"
    )
    return np.sqrt(np.interp(lines, silent, smooth))
