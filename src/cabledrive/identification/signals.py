r"""Low-pass filters, differences and frequency responses of logs: H1, H2, Hv with coherence.

With the cross and auto spectra of Welch's method over segments with windows,

.. math:: H_1 = S_{uy}/S_{uu}, \qquad H_2 = S_{yy}/S_{yu}, \qquad \gamma^2 = |S_{uy}|^2/(S_{uu}S_{yy})

H1 is unbiased under noise of the output, H2 under noise of the input, Hv (the eigenvector of the 2 by 2
spectral matrix, both channels scaled to equal noise) under both. H1 is what MATLAB's ``tfestimate`` computes.

An output of large power is no fault: a sweep passes a resonance. Each record is judged by its innovations,
the part of the output that the past of input and output does not predict,

.. math:: e_k = y_k - \sum_{i=1}^{n} a_i y_{k-i} - \sum_{i=0}^{n} b_i u_{k-i},

with one set of coefficients for the whole log, at some samples per period of its fastest motion.

A window smooths every peak that is narrower than its lines. The spectra of the whole log obey, exactly,
:math:`AY = BU + T` with smooth A, B and the transient T; polynomials of order 2 about each line give a
response without that bias (T. McKelvey, G. Guerin, Non-parametric frequency response estimation using a
local rational model, 16th IFAC Symposium on System Identification, 2012).
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from math import exp, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.answers.result import Result
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array, Complex, Integers

DIFFERENCES = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
"""Weights of the central difference of order 8, by distance."""
FEWEST_SAMPLES = 24
"""Of a position whose bandwidth is searched: bands of it have to lie below a tenth of the sample rate."""


def causal_filter(values: Array, interval: float, natural_frequency: float, damping: float = 1.0) -> Array:
    r"""Second-order low-pass with two derivatives, (3, samples), Eqs. (4.1), (4.2), exact for lines.

    .. math:: \dot x_1 = x_2, \qquad \dot x_2 = -2\zeta_f\omega_f x_2 - \omega_f^2 (x_1 - \theta)
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


def rms(*parts: Array) -> float:
    """Root mean square of all values of some signals; infinite of a motion that diverges."""
    with np.errstate(over="ignore"):
        return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def lag_coefficients(time: float, interval: float) -> tuple[float, float, float]:
    """Shares of the newest and of the last value, and fading, of 1/(1 + T s) between samples."""
    if time == 0.0:
        return 1.0, 0.0, 0.0
    fading = exp(-interval / time)
    mean = time / interval * (1.0 - fading)
    return 1.0 - mean, mean - fading, fading


def lagged(values: Array, time: float, interval: float, axis: int = -1) -> Array:
    """Sampled values through :math:`1/(1 + Ts)`, exact for lines, at rest on the first before; T [s]."""
    if time == 0.0:
        return values
    newest, last, fading = lag_coefficients(time, interval)
    start = (values.take([0], axis) * (1.0 - newest)).astype(float)
    return np.asarray(signal.lfilter([newest, last], [1.0, -fading], values, axis=axis, zi=start)[0])


def ideal_low_pass(values: Array, interval: float, cutoff: float) -> Array:
    """Every frequency above the cutoff [Hz] removed, every other left, (samples,); ends continued oddly."""
    line = np.linspace(values[0], values[-1], values.size)
    rest = values - line
    odd = np.concatenate([rest, -rest[-2:0:-1]])
    spectrum = np.fft.rfft(odd)
    spectrum[np.fft.rfftfreq(odd.size, interval) > cutoff] = 0.0
    return np.fft.irfft(spectrum, odd.size)[: values.size] + line


@lru_cache(maxsize=64)
def butterworth(interval: float, cutoff: float, order: int = 4) -> Any:
    """Sections (sections, 6) of a Butterworth low-pass; the cutoff [Hz] lies below half the sample rate."""
    nyquist = 0.5 / interval
    if not 0.0 < cutoff < nyquist:
        raise InputRefused(f"bandwidth = {cutoff:.4g} Hz must lie in 0 to {nyquist:.4g} Hz, half the rate")
    return signal.butter(order, cutoff / nyquist, output="sos")


def zero_phase(values: Array, interval: float, cutoff: float, order: int = 4) -> Array:
    """Butterworth low-pass forwards and backwards, of (samples, ...); the cutoff [Hz] is that of one pass."""
    pad = min(values.shape[0] - 2, int(2.0 / (cutoff * interval)) + 12)
    if pad < 12:
        raise InputRefused(f"{values.shape[0]} samples are few for a filter of {cutoff:.4g} Hz: record more")
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

    The highest frequency, in bands of a sixth of an octave, with ten times the power of that noise.
    """
    if position.size < FEWEST_SAMPLES:
        said = f"{position.size} samples are too few to separate motion from noise"
        raise InputRefused(f"{said}, {FEWEST_SAMPLES} the least: record longer")
    frequency, power, floor = noise_spectrum(position, interval)
    edges = frequency[1] * 2.0 ** (np.arange(0, 200) / 6)
    edges = edges[edges < 0.1 / interval]
    highest = edges[0]
    for low, high in pairwise(edges):
        band = (frequency >= low) & (frequency < high)
        if band.any() and power[band].mean() > 10.0 * floor:
            highest = high
    return float(min(highest, 0.1 / interval))


def noise_spectrum(position: Array, interval: float) -> tuple[Array, Array, float]:
    """Frequencies [Hz], one-sided power [unit^2/Hz] by differences, level of the noise in the upper half."""
    detrended = np.diff(position)
    segment = min(detrended.size, max(1024, int(8.0 / interval)))
    frequency, power = signal.welch(detrended, 1 / interval, nperseg=segment)
    with np.errstate(divide="ignore", invalid="ignore"):
        power = power / (2 - 2 * np.cos(2 * pi * frequency * interval))
    return frequency, power, float(np.median(power[frequency > 0.25 / interval]))


LOCAL_ORDER, LOCAL_LINES, LOCAL_WIDTH = 2, (16, 60), 2.0
"""Of A, B and T; lines of the whole log to either side, fewest and most, and lines of a window so covered."""
ESTIMATORS = ("H1", "H2", "Hv")
HANN_LINES = 2
"""Neighbouring lines under a Hann window share their noise; lines this far apart hardly do."""
ORDER = 10
SAMPLES_PER_PERIOD = 8.0
POWER = 0.999
"""Share of the power of the output below the frequency that counts as its fastest motion."""
ROUNDS = 5
FACTOR = 10.0
"""Power of the innovations, in medians over the records, below which no record is left out."""
DEVIATIONS = 5.0
LEAST_SHARE = 1e-9
"""Power of the innovations in that of the output that counts as none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """A record that was left out."""

    # start, end: [s], from the first sample of the log
    start: float
    end: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class FrequencyResponse(Result):
    """Response at discrete frequencies."""

    _table = "frequency: magnitude phase coherence deviation"

    frequency: Array  # (m,): [Hz]
    response: Complex  # (m,): output per input
    deviation: Array  # (m,): standard deviation of the response, of real and imaginary part together
    coherence: Array  # (m,): between 0 and 1; 1 where it is not estimated (one record)
    averages: float  # independent averages behind each value
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

    @property
    def noise(self) -> Array:
        """Standard deviation (m,) by noise alone, without what windows smooth away."""
        noisy = (1 - self.coherence) / np.maximum(self.coherence, 1e-12)
        return self.magnitude * np.sqrt(noisy / self.averages)

    def kept(self, keep: NDArray[np.bool_]) -> "FrequencyResponse":
        """Some of its lines, (m,)."""
        names = ("frequency", "response", "deviation", "coherence")
        return replace(self, **{name: getattr(self, name)[keep] for name in names})

    def between(self, low: float, high: float) -> "FrequencyResponse":
        """The part in a band [Hz]."""
        return self.kept((self.frequency >= low) & (self.frequency <= high))

    def independent(self, least_coherence: float = 0.0) -> "FrequencyResponse":
        """Lines that hardly share their noise under Hann windows, so that a fit counts each once."""
        lines = np.arange(self.frequency.size) % HANN_LINES == 0
        return self.kept(lines & (self.coherence > least_coherence))


def response_by_segments(
    input_: Array,
    output: Array,
    interval: float,
    window: tuple[float, float] = (1.0, 0.2),
    *,
    estimator: str = "H1",
    robust: bool = True,
) -> FrequencyResponse:
    """Response by windowed segments [s], Eq. (4.15); ``robust``: without records that nothing explains."""
    segment, overlap = window
    if estimator not in ESTIMATORS:
        raise InputRefused(f'estimator "{estimator}" is unknown: take one of {", ".join(ESTIMATORS)}')
    if segment <= 0.0:
        raise InputRefused(f"segment = {segment:.4g} s must be above 0: give the length of a window")
    if not 0.0 <= overlap < segment:
        raise InputRefused(f"overlap = {overlap:.4g} s must lie from 0 to below {segment:.4g} s: lower it")
    length = round(segment / interval)
    hop = max(1, length - round(overlap / interval))
    starts = np.arange(0, input_.size - length + 1, hop)
    if length < 8:
        said = f"segment = {segment:.4g} s holds {length} samples, 8 are the least"
        raise InputRefused(f"{said}: lengthen it to {8 * interval:.4g} s or more")
    if starts.size < 2:
        raise InputRefused(
            f"{input_.size * interval:.4g} s hold {starts.size} windows of {segment:.4g} s: shorten it"
        )
    if np.ptp(input_) == 0.0:
        raise InputRefused("the input is constant: a response needs an excitation")
    hann = signal.get_window("hann", length)
    rows = starts[:, None] + np.arange(length)
    windows = (signal.detrend(values[rows], axis=1) * hann for values in (input_, output))
    u, y = (np.fft.rfft(own, axis=1)[:, 1:] for own in windows)
    keep, excess = explained_records(input_, output, starts, length)
    keep = keep | (not robust)
    records, shared = int(keep.sum()), 0.0  # of overlapping windows, so many averages are independent
    for k in range(1, min(records, -(-length // hop))):
        overlapping = float(hann[k * hop :] @ hann[: length - k * hop]) / float(hann @ hann)
        shared += (1 - k / records) * overlapping**2
    averages = records / (1 + 2 * shared)
    frequency = np.asarray(np.fft.rfftfreq(length, interval)[1:], dtype=float)
    h, coherence = _estimated(u[keep], y[keep], estimator)
    reason, blows = "the output moves as neither the input nor its own past explains", []
    used = np.ones(input_.size, dtype=bool)
    for number in np.flatnonzero(~keep):
        used[starts[number] : starts[number] + length] = False
        begin, end = float(starts[number] * interval), float((starts[number] + length) * interval)
        words = f"{reason}, {np.sqrt(excess[number]):.3g} times as much as usual"
        blows.append(LeftOut(start=begin, end=end, reason=words))
    part = max(np.split(np.arange(used.size), np.flatnonzero(~used)), key=len)
    pair = input_[part], output[part]
    near = local_response(*pair, interval * frequency, segment / interval)
    if estimator != "H1":  # with the noise where the estimator has it: at the input, or at both
        back = 1.0 / local_response(*pair[::-1], interval * frequency, segment / interval)
        near = back if estimator == "H2" else near * np.sqrt(np.abs(back / near))
    found = FrequencyResponse(
        frequency=frequency,
        response=h,
        deviation=np.abs(near - h),
        coherence=coherence,
        averages=averages,
        left_out=len(blows),
        blows=tuple(blows),
    )
    return replace(found, deviation=np.hypot(found.noise, found.deviation))


def _estimated(u: Complex, y: Complex, estimator: str) -> tuple[Complex, Array]:
    """Response and coherence, each (m,), from the spectra of records, each (records, m)."""
    uu, yy = (np.abs(u) ** 2).mean(axis=0), (np.abs(y) ** 2).mean(axis=0)
    uy = (np.conj(u) * y).mean(axis=0)
    tiny = 1e-300
    coherence = np.clip(np.abs(uy) ** 2 / np.maximum(uu * yy, tiny), 0.0, 1.0)
    h: Complex = uy / np.maximum(uu, tiny)
    if estimator == "H2":
        h = np.asarray(yy / np.where(np.abs(uy) > 0, np.conj(uy), tiny), dtype=complex)
    elif estimator == "Hv":  # noise in both channels, alike once each is scaled by its mean spectrum
        scale = np.sqrt(yy / np.maximum(uu, tiny))
        more, cross = yy / np.maximum(scale, tiny) ** 2 - uu, np.abs(uy) / np.maximum(scale, tiny)
        gain = (more + np.sqrt(more**2 + 4 * cross**2)) / (2 * np.maximum(cross, tiny))
        h = gain * scale * np.exp(1j * np.angle(uy))
    return h, coherence


def local_response(input_: Array, output: Array, frequency: Array, segment: float) -> Complex:
    """Response (m,) at frequencies per sample by local rational models; ``segment``: samples of a window."""
    u, y = (np.fft.rfft(values - values.mean()) for values in (input_, output))
    half = int(np.clip(round(LOCAL_WIDTH * input_.size / segment), *LOCAL_LINES))
    half, found = min(half, (u.size - 2) // 2), np.empty(frequency.size, dtype=complex)
    for k, place in enumerate(input_.size * frequency):
        rows = int(np.clip(round(place) - half, 1, u.size - 1 - 2 * half)) + np.arange(2 * half + 1)
        powers = ((rows - place) / half)[:, None] ** np.arange(LOCAL_ORDER + 1)
        columns = np.hstack([powers * u[rows, None], powers, -powers[:, 1:] * y[rows, None]])
        sizes = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        found[k] = np.linalg.lstsq(columns / sizes, y[rows], rcond=1e-12)[0][0] / sizes[0]
    return found


def explained_records(
    input_: Array, output: Array, starts: Integers, length: int
) -> tuple[NDArray[np.bool_], Array]:
    """Records with innovations like the others', and their power in medians, from their first samples."""
    # Samples that show the fastest motion of the output, of what a thinner grid can show.
    power = np.cumsum(np.abs(np.fft.rfft(output - output.mean())) ** 2)
    fastest = int(np.searchsorted(power, POWER * power[-1])) / output.size
    step = max(1, int(1.0 / (SAMPLES_PER_PERIOD * max(fastest, 1.0 / output.size))))
    step = min(step, max(1, length // (2 * ORDER)))
    u, y = (values - values.mean() for values in (input_, output))
    if step > 1:
        u, y = (zero_phase(values, 1.0, 0.4 / step)[::step] for values in (u, y))
    keep, excess = np.ones(starts.size, dtype=bool), np.ones(starts.size)
    if y.size < 6 * ORDER:
        return keep, excess
    rows = np.arange(ORDER, y.size)
    past = [*(y[rows - k] for k in range(1, ORDER + 1)), *(u[rows - k] for k in range(ORDER + 1))]
    table = np.column_stack([*past, np.ones(rows.size)])
    parts = [slice(start // step, (start + length) // step) for start in starts]
    for _ in range(ROUNDS):
        used = np.zeros(y.size, dtype=bool)
        for k in np.flatnonzero(keep):
            used[parts[k]] = True
        fitted = used[rows]
        coefficients = np.linalg.lstsq(table[fitted], y[rows[fitted]], rcond=1e-10)[0]
        innovations = np.concatenate([np.zeros(ORDER), y[rows] - table @ coefficients])
        power = np.array([np.mean(innovations[part] ** 2) for part in parts])
        power = np.maximum(power, LEAST_SHARE * float(np.var(y)))
        excess = power / np.median(power)
        spread = 1.4826 * float(np.median(np.abs(np.log(excess))))
        ordinary = np.log(excess) <= max(DEVIATIONS * spread, np.log(FACTOR))
        if (ordinary == keep).all() or ordinary.sum() < 2:
            break
        keep = ordinary
    return keep, excess
