"""Tension of one vibrating string from a ping: its tones against its modes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import SpanTension
from cabledrive.identification.tension.onset import require_ping
from cabledrive.identification.tension.partials import (
    LEAST_COUNT,
    Partial,
    amplitude_spectrum,
    count_of,
    fundamental,
    noise_level,
    other_tone,
    partial_at,
    peak_near,
)
from cabledrive.modal import longitudinal_modes
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.route import RoutedDrive

Array = NDArray[np.float64]

SQUARED = ("angle", "torque", "tension", "force", "current")
"""Channels that measure the stretch of a vibrating span, which has twice its frequency."""
SEARCHED = 4.0
"""Tensions are searched from the drive's over this to the drive's times this."""
INCONSISTENT = 3.0
NO_TONE = (
    "no tone between {low:.4g} and {high:.4g} Hz: pluck again, or correct the drive's length and tension"
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingedString:
    """A span, or a section of one, as its ping is read.

    Attributes
    ----------
    drive : Drive or RoutedDrive
        Its pretension serves as a first guess.
    span : str
    modes : ndarray, shape (partials,)
        Its first frequencies as the file has it [Hz].
    tension_for : callable
        Tension [N] at which a mode, by its number from 1, has a frequency [Hz].
    bare : callable
        Tension [N] of a string of this length and mass with a fundamental [Hz].
    remedy : str
        What to do where a second tone is heard beside the first.
    """

    drive: Drive | RoutedDrive
    span: str
    modes: Array
    tension_for: Callable[[int, float], float]
    bare: Callable[[float], float]
    remedy: str


def tension_of_string(log: Log, string: PingedString, channel: str) -> SpanTension:
    """Tension of a string from one channel of a recording."""
    values = log.channel(channel)
    if np.ptp(values) == 0.0:
        raise InputRefused(f"{log.source}: {channel} is constant: record the ping")
    squared = channel.rpartition("_")[2] in SQUARED
    factor = 2.0 if squared else 1.0
    modes = string.modes
    frequency, amplitude = amplitude_spectrum(values, log.interval)
    top = 0.45 * log.sample_rate
    low, high = modes[0] / sqrt(SEARCHED), min(modes[0] * sqrt(SEARCHED), top / factor)
    if low >= high:
        raise InputRefused(
            f"{log.source}: {log.sample_rate:.4g} samples per second are too few for tones about "
            f"{factor * modes[0]:.4g} Hz: record faster"
        )
    if squared:
        amplitude = without_pulley_modes(frequency, amplitude, string.drive, top)
    ratios, noise = modes / modes[0], noise_level(amplitude)
    first = fundamental(frequency, amplitude, factor * ratios, low, high)
    partials, least = [], LEAST_COUNT * count_of(values) if squared else 0.0
    for number, ratio in enumerate(ratios, start=1):
        near = factor * ratio * first
        width = _width(ratios, number - 1, first * factor, log.report.duration)
        peak = peak_near(frequency, amplitude, near, 0.04 * near) if near + width < top else None
        power = 1 if squared else 2
        partial = peak and partial_at(values, log.interval, number, peak, width, power, noise)
        if partial and partial.amplitude > least:
            partials.append(partial)
    if not partials or partials[0].number != 1:
        raise NotComputed(f"{log.source}: {channel}: " + NO_TONE.format(low=factor * low, high=factor * high))
    require_ping(values, log.interval, partials[0].peak, f"{log.source}: {channel}")
    found = _tension(string, channel, partials, factor)
    peak, apart = partials[0].peak, 6.0 / log.report.duration
    other = other_tone(frequency, amplitude, peak, (0.7 * peak, 1.4 * peak), apart)
    if other is None or squared:
        return found
    words = f"{channel}: another tone at {other:.4g} Hz beside {peak:.4g} Hz: {string.remedy}"
    return replace(found, findings=(*found.findings, words))


def _width(ratios: Array, place: int, first: float, duration: float) -> float:
    """Half of the band of a partial [Hz]: away from its neighbours, and no wider than it needs."""
    others = np.concatenate([[0.0], np.delete(ratios, place)])
    spacing = float(np.abs(others - ratios[place]).min())
    share = max(0.04, 8.0 / (duration * first))
    return min(0.3 * spacing, 0.2, share) * first


def without_pulley_modes(frequency: Array, amplitude: Array, drive: Drive | RoutedDrive, top: float) -> Array:
    """The spectrum without the drive's longitudinal modes, which do not depend on the tension.

    Their second and third harmonics are cut out as well: rounding and stretch make them.
    """
    cleared = amplitude.copy()
    for mode in longitudinal_modes(drive, below=top):
        for harmonic, share in ((1, 0.06), (2, 0.02), (3, 0.02)):
            reach = max(share * harmonic * mode.frequency, 3.0 * (frequency[4] - frequency[0]))
            cleared[np.abs(frequency - harmonic * mode.frequency) < reach] = 0.0
    return cleared


def _tension(string: PingedString, channel: str, partials: list[Partial], factor: float) -> SpanTension:
    values = np.array([string.tension_for(p.number, p.frequency / factor) for p in partials])
    errors = np.array(
        [2.0 * v * p.standard_error / p.frequency for v, p in zip(values, partials, strict=True)]
    )
    errors = np.maximum(errors, 1e-9 * values)
    weights = errors**-2 / np.sum(errors**-2)
    tension = float(weights @ values)
    freedom = len(partials) - 1
    chi = float(np.sum(((values - tension) / errors) ** 2) / freedom) if freedom else 1.0
    error = float(np.sum(errors**-2) ** -0.5) * sqrt(max(1.0, chi))
    half = error * float(stats.t.ppf(0.975, freedom if freedom and chi > 1.0 else 12))
    estimate = Estimate(
        value=tension, unit="N", standard_error=error, low=tension - half, high=tension + half
    )
    first = partials[0].peak / factor / partials[0].number
    bare = string.bare(first)
    findings = []
    if not all(p.decays for p in partials):
        findings.append(f"{channel}: the ping hardly decays: its frequency holds for its amplitude only")
    if freedom and sqrt(chi) > INCONSISTENT and np.ptp(values) > 0.01 * tension:
        findings.append(
            f"{channel}: partials disagree by {100 * np.ptp(values) / tension:.2g} % of the tension: a "
            "stiff cable, a load on it, or two vibrating spans"
        )
    return SpanTension(
        span=string.span,
        channel=channel,
        tension=estimate,
        bare=bare,
        bias=bare / tension - 1.0,
        spread=float(np.ptp(values)) / tension,
        partials=tuple(partials),
        findings=tuple(findings),
    )


def widened(estimate: Estimate, extra: float) -> Estimate:
    """An interval with one more independent standard error."""
    if extra == 0.0:
        return estimate
    error = sqrt(estimate.standard_error**2 + extra**2)
    half = (estimate.high - estimate.value) * error / estimate.standard_error
    return replace(estimate, standard_error=error, low=estimate.value - half, high=estimate.value + half)
