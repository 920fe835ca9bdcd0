"""Low-pass filters and differences for logs."""

from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from scipy import signal

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

DIFFERENCES = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
"""Weights of the central difference of order 8, by distance."""
FEWEST_SAMPLES = 24
"""Of a position whose bandwidth is searched: bands of it have to lie below a tenth of the sample rate."""


def causal_filter(values: Array, interval: float, natural_frequency: float, damping: float = 1.0) -> Array:
    r"""Second-order low-pass with its two derivatives, Eqs. (4.1), (4.2).

    .. math:: \dot x_1 = x_2, \qquad \dot x_2 = -2\zeta_f\omega_f x_2 - \omega_f^2 (x_1 - \theta)

    ``values``, shape (samples,): on straight lines between samples, for which the discrete filter is exact;
    ``interval`` [s]; ``natural_frequency``: :math:`\omega_f / 2\pi` [Hz]; ``damping``: :math:`\zeta_f`.
    Returns shape (3, samples): :math:`H_f\theta`, :math:`sH_f\theta`, :math:`s^2H_f\theta`; at rest on the
    first value before.
    """
    omega = 2 * pi * natural_frequency
    a = np.array([[0.0, 1.0], [-(omega**2), -2 * damping * omega]])
    b = np.array([[0.0], [omega**2]])
    c = np.vstack([np.eye(2), a[1]])
    d = np.array([[0.0], [0.0], [omega**2]])
    discrete = signal.cont2discrete((a, b, c, d), interval, method="foh")
    numerators, denominator = signal.ss2tf(*discrete[:4])
    base = values[0]
    filtered = np.array([signal.lfilter(row, denominator, values - base) for row in numerators])
    filtered[0] += base
    return filtered


def ideal_low_pass(values: Array, interval: float, cutoff: float) -> Array:
    """Every frequency above the cutoff [Hz] removed, every other left as it is, without phase, (samples,).

    The straight line through both ends is set aside and the rest continued oddly, so that nothing jumps.
    """
    line = np.linspace(values[0], values[-1], values.size)
    rest = values - line
    odd = np.concatenate([rest, -rest[-2:0:-1]])
    spectrum = np.fft.rfft(odd)
    spectrum[np.fft.rfftfreq(odd.size, interval) > cutoff] = 0.0
    return np.fft.irfft(spectrum, odd.size)[: values.size] + line


def butterworth(interval: float, cutoff: float, order: int = 4) -> Any:
    """Sections (sections, 6) of a Butterworth low-pass; the cutoff [Hz] lies below half the sample rate."""
    nyquist = 0.5 / interval
    if not 0.0 < cutoff < nyquist:
        raise InputRefused(
            f"bandwidth = {cutoff:.4g} Hz must lie between 0 and {nyquist:.4g} Hz, half the sample rate"
        )
    return signal.butter(order, cutoff / nyquist, output="sos")


def zero_phase(values: Array, interval: float, cutoff: float, order: int = 4) -> Array:
    """Butterworth low-pass forwards and backwards, of (samples, ...); the cutoff [Hz] is that of one pass."""
    pad = min(values.shape[0] - 2, int(2.0 / (cutoff * interval)) + 12)
    if pad < 12:
        raise InputRefused(
            f"{values.shape[0]} samples are too few for a filter of {cutoff:.4g} Hz: record longer"
        )
    return signal.sosfiltfilt(butterworth(interval, cutoff, order), values, axis=0, padlen=pad)


def difference(values: Array, interval: float) -> Array:
    """Derivative (samples,) by central differences of order 8; one-sided of order 1 at both ends."""
    found = np.gradient(values, interval)
    reach = len(DIFFERENCES)
    inner = np.zeros(values.size - 2 * reach)
    for distance, weight in enumerate(DIFFERENCES, start=1):
        ahead = values[reach + distance : values.size - reach + distance]
        inner += weight * (ahead - values[reach - distance : values.size - reach - distance])
    found[reach:-reach] = inner / interval
    return found


def chosen_bandwidth(position: Array, interval: float) -> float:
    """Bandwidth [Hz] of a motion (samples,): up to where it stands out of the noise of its measurement.

    The noise of a position is nearly white (an encoder's rounding); its level is the median of the upper half
    of the spectrum. The bandwidth is the highest frequency, in bands of a sixth of an octave, whose mean
    power is ten times that, and not more than a tenth of the sample rate.
    """
    if position.size < FEWEST_SAMPLES:
        raise InputRefused(
            f"{position.size} samples are too few to separate motion from noise, {FEWEST_SAMPLES} the least: "
            "record longer"
        )
    frequency, power, floor = _spectrum(position, interval)
    edges = frequency[1] * 2.0 ** (np.arange(0, 200) / 6)
    edges = edges[edges < 0.1 / interval]
    highest = edges[0]
    for low, high in pairwise(edges):
        band = (frequency >= low) & (frequency < high)
        if band.any() and power[band].mean() > 10.0 * floor:
            highest = high
    return float(min(highest, 0.1 / interval))


def noise_level(position: Array, interval: float) -> float:
    """Level of a channel's white noise by the upper half of its spectrum, one-sided [its unit^2 / Hz]."""
    return _spectrum(position, interval)[2]


def _spectrum(position: Array, interval: float) -> tuple[Array, Array, float]:
    """Frequencies [Hz], power of a position, from its difference, and its median in the upper half."""
    detrended = np.diff(position)
    segment = min(detrended.size, max(1024, int(8.0 / interval)))
    frequency, power = signal.welch(detrended, 1 / interval, nperseg=segment)
    with np.errstate(divide="ignore", invalid="ignore"):
        power = power / (2 - 2 * np.cos(2 * pi * frequency * interval))
    return frequency, power, float(np.median(power[frequency > 0.25 / interval]))
