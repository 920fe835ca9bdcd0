"""Tension of one vibrating string from a ping: its tones against its modes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import SpanTension
from cabledrive.identification.tension.decaying_tones import TonesFit
from cabledrive.identification.tension.families import proposals
from cabledrive.identification.tension.family_fit import (
    MISSING_PRICE,
    criterion,
    fit_families,
    partials_of,
    scale_error,
    with_silent_partials,
)
from cabledrive.identification.tension.onset import require_ping
from cabledrive.identification.tension.prepared_recording import (
    SEARCHED,
    PreparedRecording,
    prepared_recording,
)
from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.route import RoutedDrive

Array = NDArray[np.float64]

HEARD = ("sound", "acceleration")
"""Channels that hear a knock on the machine as well as a span."""
LOUD = 0.3
"""Share of the first partial above which another tone near it is resolved."""
MATCHED = 0.01
"""Relative disagreement of the tensions of partials from which it is a finding, or no string."""
INCONSISTENT = 3.0
"""The same over its standard error."""
ALONE = 0.9
"""Share of the power that decays, from which no other family is tried."""
DECAYING = 0.7
"""Logarithm of the fall of an envelope from which a tone is no hum."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingedString:
    """A span, or a section of one, as its ping is read.

    Attributes
    ----------
    drive : Drive or RoutedDrive
        Its pretension serves as a first guess.
    span : str
    modes : ndarray, shape (modes,)
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
    prepared = prepared_recording(log, string.drive, channel, {string.span: string.modes})
    peaks = prepared.peaks.only(prepared.falling)
    singles, _ = proposals(peaks, prepared.teeth, prepared.factor, sqrt(SEARCHED))
    pings: list[tuple[bool, float, TonesFit]] = []
    for one in singles:
        tried = fit_families(prepared, one.families)
        if tried is not None and tried.amplitude[tried.tones.family == 0].max() > prepared.least:
            cost = criterion(tried, prepared.interval) - MISSING_PRICE * one.score
            pings.append((_share(tried) < 0.5, cost, tried))
            if _share(tried) > ALONE and np.sum(tried.tones.family == 0) > 2:
                break
    if not pings:
        raise prepared.no_tone
    fit = with_silent_partials(prepared, min(pings, key=lambda one: one[:2])[2])
    first = float(fit.tones.scale[0] * prepared.factor * string.modes[0])
    require_ping(log.channel(channel), log.interval, first, f"{log.source}: {channel}")
    return _tension(string, prepared, fit)


def _decays(fit: TonesFit) -> NDArray[np.bool_]:
    """Whether each tone falls enough to be no hum."""
    return fit.tones.decay * fit.duration > 0.5 * DECAYING


def _share(fit: TonesFit) -> float:
    """Power of the first family that decays, over all that decays and over that of the family."""
    power, own = fit.amplitude**2, fit.tones.family == 0
    falling = power * _decays(fit)
    return float(falling[own].sum() / max(falling.sum(), power[own].sum()))


def _tension(string: PingedString, prepared: PreparedRecording, fit: TonesFit) -> SpanTension:
    channel, tones = prepared.channel, fit.tones
    own = tones.family == 0
    lowest = int(tones.number[own].min())
    hertz = float(tones.scale[0]) * float(string.modes[lowest - 1])
    value = string.tension_for(lowest, hertz)
    steep = 1e4 * (string.tension_for(lowest, hertz * 1.0001) / value - 1.0)
    relative = fit.offset[own] / tones.frequency[own]
    apart = steep * float(np.ptp(relative))
    clear = float(np.sqrt(np.mean((fit.offset[own] / fit.offset_error[own]) ** 2))) > INCONSISTENT
    _require_string(prepared, fit, apart if clear else 0.0)
    spread, quantile = scale_error(prepared, fit, 0)
    error = steep * value * spread
    bare = string.bare(float(tones.scale[0]) * float(string.modes[0]))
    return SpanTension(
        span=string.span,
        channel=channel,
        tension=Estimate(
            value=value,
            unit="N",
            standard_error=error,
            low=value - quantile * error,
            high=value + quantile * error,
        ),
        bare=bare,
        bias=bare / value - 1.0,
        spread=apart,
        of_mass=0.5 * steep,
        partials=partials_of(fit, 0),
        findings=tuple(_findings(string, prepared, fit, apart if clear else 0.0)),
    )


def _require_string(prepared: PreparedRecording, fit: TonesFit, apart: float) -> None:
    """Refuse a knock: one decaying tone alone, or decaying tones that are no partials of one string."""
    if prepared.channel.rpartition("_")[2] not in HEARD and not prepared.channel.startswith("sound"):
        return
    own, name = fit.tones.family == 0, f"{prepared.source}: {prepared.channel}"
    second = float(fit.tones.scale[0] * np.sort(next(iter(prepared.teeth.values())))[1])
    if own.sum() == 1 and second < prepared.band[1]:
        raise NotComputed(
            f"{name}: no string: one tone at {fit.tones.frequency[own][0]:.4g} Hz without partials, as of a "
            "knock: pluck the span nearer to an end, or record closer to it"
        )
    falling, standing = own & _decays(fit), own & ~_decays(fit)
    if falling.any() and np.any(fit.tones.frequency[standing] > fit.tones.frequency[falling].min()):
        raise NotComputed(
            f"{name}: the tone at {fit.tones.frequency[standing].max():.4g} Hz does not decay, that at "
            f"{fit.tones.frequency[falling].min():.4g} Hz does: hum beside the tones: record without it"
        )
    heard = np.sort(fit.tones.frequency[_decays(fit) | own])
    if _share(fit) < 0.5 or (own.sum() == 2 and apart > MATCHED):
        raise NotComputed(
            f"{name}: no string: the tones ({', '.join(f'{f:.4g}' for f in heard)} Hz) "
            " have not the ratios of the span's modes, as of a knock: pluck the span and damp the others"
        )


def _findings(string: PingedString, prepared: PreparedRecording, fit: TonesFit, apart: float) -> list[str]:
    channel, tones = prepared.channel, fit.tones
    own = tones.family == 0
    found = []
    if own.sum() == 1:
        found.append(
            f"{channel}: from a single partial, assumed to be mode {tones.number[own][0]}: an overtone would "
            "give a wrong tension"
        )
    if not _decays(fit)[own].all():
        found.append(f"{channel}: the ping hardly decays: its frequency holds for its amplitude only")
    if apart > MATCHED:
        found.append(
            f"{channel}: partials disagree by {100 * apart:.2g} % of the tension: a stiff cable, a load on "
            "it, or two vibrating spans"
        )
    first = int(np.argmin(np.where(own, tones.frequency, np.inf)))
    ratio = tones.frequency / tones.frequency[first]
    near = ~own & _decays(fit) & (ratio > 0.7) & (ratio < 1.4)
    others = near & (fit.amplitude > LOUD * fit.amplitude[first])
    if others.any() and prepared.factor == 1.0:
        loudest = tones.frequency[int(np.argmax(np.where(others, fit.amplitude, 0.0)))]
        found.append(
            f"{channel}: another tone at {loudest:.4g} Hz beside {tones.frequency[first]:.4g} Hz: "
            f"{string.remedy}"
        )
    return found


def widened(estimate: Estimate, extra: float) -> Estimate:
    """An interval with one more independent standard error."""
    if extra == 0.0:
        return estimate
    error = sqrt(estimate.standard_error**2 + extra**2)
    half = (estimate.high - estimate.value) * error / estimate.standard_error
    return replace(estimate, standard_error=error, low=estimate.value - half, high=estimate.value + half)
