"""A recording fitted by families of partials, and by what a family is known."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
from scipy import stats

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.tension.answers import Partial, SpanTension
from cabledrive.identification.tension.families import Family, matched
from cabledrive.identification.tension.recording import PARTIALS, PreparedRecording
from cabledrive.identification.tension.tones import Tones, TonesFit, fit_tones, with_decays
from cabledrive.parameters.arrays import Array

SPANS = ("upper", "lower")
ABOUT = 4.0
"""Line widths about a tone within which what is left is its noise."""
WHOLE = (2, 3)
BELOW = 0.5
"""Loudness of a tone at half or a third of a family's first mode, over that mode's, from which it is a first
mode itself: a plucked span has more speed in its first mode than in its second, most points hear it."""
LOUDER = 1.5
"""Ratio of the loudness of both families from which the louder one is that of the plucked span."""


def strength(fit: TonesFit, family: int) -> float:
    """Loudness of a family: root of the sum of squares of its amplitudes."""
    return float(np.linalg.norm(fit.amplitude[fit.tones.family == family]))


def line_widths(fit: TonesFit, duration: float) -> Array:
    """Width of each tone: at half power by its decay, and of the record, shape (tones,) [Hz]."""
    return np.asarray(fit.tones.decay / pi + 1.0 / duration)


def excess(prepared: PreparedRecording, fit: TonesFit, family: int) -> float:
    """Density of what is left about the tones of a family, over its mean: 1 in white noise."""
    density = np.abs(np.fft.rfft(fit.left)) ** 2
    frequency = np.fft.rfftfreq(fit.left.size, prepared.interval)
    own = fit.tones.family == family
    reach = ABOUT * line_widths(fit, prepared.duration)[own]
    near = np.abs(frequency[:, None] - fit.tones.frequency[own]) < reach
    about = np.array([density[column].mean() if column.any() else 0.0 for column in near.T])
    weights = (fit.amplitude[own] * fit.tones.frequency[own]) ** 2
    return float(weights @ about / weights.sum() / density.mean())


def apart(prepared: PreparedRecording, fit: TonesFit, spans: tuple[str, str]) -> bool:
    """Whether each of two families has a partial more than a line width from every mode of the other."""
    tones, width = fit.tones, line_widths(fit, prepared.duration)
    for one, two in ((0, 1), (1, 0)):
        own = np.flatnonzero(tones.family == one)
        others = tones.scale[two] * prepared.factor * prepared.teeth[spans[two]]
        distance = np.abs(tones.frequency[own][:, None] - others).min(axis=1)
        if not np.any(distance > width[own]):
            return False
    return True


def has_tone_below(prepared: PreparedRecording, fit: TonesFit) -> bool:
    """Whether a family may be every second or third mode of a lower one, whose first is among other tones.

    Split partials of one frequency and two tensions look so where their first is not split.
    """
    tones = fit.tones
    free = tones.number == 0
    reach = ABOUT * line_widths(fit, prepared.duration)[free]
    for first in np.flatnonzero(tones.number == 1):
        loud = fit.amplitude[free] > BELOW * fit.amplitude[first]
        for whole in WHOLE:
            distance = np.abs(tones.frequency[free] - tones.frequency[first] / whole)
            if np.any(loud & (distance < reach)):
                return True
    return False


def label(prepared: PreparedRecording, fit: TonesFit, plucked: str | None) -> tuple[str, str] | None:
    """Which span each of two families belongs to; None where modes are alike and loudness does not decide."""
    if not prepared.alike:
        return SPANS
    first, second = strength(fit, 0), strength(fit, 1)
    if plucked is None or max(first, second) < LOUDER * min(first, second):
        return None
    return SPANS if (plucked == "upper") == (first > second) else (SPANS[1], SPANS[0])


AUDIBLE = 8.0
"""Amplitude of a tone over its standard error from which it is kept."""
ENOUGH = 3
"""Partials with which a family is well known: no other is sought below the noise."""
SILENT = 6.0
"""The same for a partial whose frequency is known from the others."""
LIKE = 5.0
"""Its decay over that of the others, above which it is none."""
MISSING_PRICE = 10.0
"""Units of the information criterion for one of the score: the same tones may be read as those of a lower
family of which every other one is missing."""
DISAGREEING = 0.95
"""Quantile of the sum of squares of the partials' offsets from which they disagree by more than noise."""
MOST_OTHERS = 6
"""Tones of no span that are fitted beside the families."""


def _tones(prepared: PreparedRecording, families: tuple[Family, ...]) -> Tones:
    """The tones to begin with: modes that have a peak, and the loudest peaks that belong to none."""
    rows, explained = [], np.zeros(prepared.peaks.frequency.size, dtype=bool)
    for place, one in enumerate(families):
        teeth = prepared.factor * prepared.teeth[one.span]
        taken = matched(prepared.peaks, one.scale * teeth)
        taken = np.where((taken >= 0) & prepared.falling[taken], taken, -1)[:PARTIALS]
        explained[taken[taken >= 0]] = True
        rows += [(place, teeth[k], k + 1) for k in range(PARTIALS) if taken[k] >= 0]
    others = np.flatnonzero(~explained)
    others = others[np.argsort(prepared.peaks.amplitude[others])[::-1][:MOST_OTHERS]]
    scale = [one.scale for one in families] + [1.0] * others.size
    rows += [(len(families) + k, prepared.peaks.frequency[p], 0) for k, p in enumerate(others)]
    family, tooth, number = zip(*rows, strict=True)
    return Tones(
        family=np.array(family, dtype=np.intp),
        tooth=np.array(tooth, dtype=float),
        number=np.array(number, dtype=np.intp),
        scale=np.array(scale, dtype=float),
        decay=np.zeros(len(rows)),
        rise=np.zeros(len(rows)),
    )


def fit_families(
    prepared: PreparedRecording, families: tuple[Family, ...], tones: Tones | None = None
) -> TonesFit | None:
    """Fit of families, without tones that drown in the noise; None where one of them falls silent."""
    begin = tones or _tones(prepared, families)
    if not np.isin(np.arange(len(families)), begin.family).all():
        return None
    start = with_decays(prepared.values, prepared.interval, begin, prepared.power)
    fit = fit_tones(prepared.values, prepared.interval, start, prepared.power)
    clear = fit.amplitude > AUDIBLE * fit.amplitude_error
    if not clear.all():
        if not all(np.any(clear & (fit.tones.family == k)) for k in range(len(families))):
            return None
        fit = fit_tones(prepared.values, prepared.interval, fit.tones.only(clear), prepared.power)
    return fit if all(_is_a_ping(fit, k) for k in range(len(families))) else None


def with_silent_partials(prepared: PreparedRecording, fit: TonesFit) -> TonesFit:
    """The fit with those partials of its first family as well that stand out of the noise without a peak."""
    own = fit.tones.family == 0
    (teeth,) = prepared.teeth.values()
    numbers = np.setdiff1d(np.arange(1, min(PARTIALS, teeth.size) + 1), fit.tones.number[own])
    top = prepared.band[1] / (fit.tones.scale[0] * prepared.factor)
    numbers = numbers[teeth[numbers - 1] < top]
    if numbers.size == 0 or own.sum() >= ENOUGH:
        return fit
    one = fit.tones
    start = Tones(
        family=np.append(one.family, np.zeros(numbers.size, dtype=np.intp)),
        tooth=np.append(one.tooth, prepared.factor * teeth[numbers - 1]),
        number=np.append(one.number, numbers),
        scale=one.scale,
        decay=np.append(one.decay, np.full(numbers.size, np.median(one.decay[own]))),
        rise=np.append(one.rise, np.zeros(numbers.size)),
    )
    more = fit_tones(prepared.values, prepared.interval, start, prepared.power)
    kept = more.amplitude > SILENT * more.amplitude_error
    kept &= more.tones.decay < LIKE * one.decay[own].max()
    kept[: own.size] = True
    if not kept[own.size :].any():
        return fit
    if kept.all():
        return more
    return fit_tones(prepared.values, prepared.interval, more.tones.only(kept), prepared.power)


def _is_a_ping(fit: TonesFit, family: int) -> bool:
    """Whether a family decays, or has several partials: a single tone that stays is hum."""
    own = fit.tones.family == family
    return bool(np.sum(own) > 1 or fit.resolved[own].any())


def criterion(fit: TonesFit, interval: float) -> float:
    """Bayesian information criterion, tones of no span counting as not explained."""
    tones, samples = fit.tones, fit.left.size
    free = tones.number == 0
    lasting = -np.expm1(-2.0 * tones.decay * interval * samples) / (4.0 * tones.decay * interval)
    unexplained = fit.residual + float(np.sum((fit.amplitude**2 * lasting)[free]))
    parameters = 4 * int(np.sum(~free)) + 2
    return float(samples * np.log(unexplained) + parameters * np.log(samples))


def scale_error(prepared: PreparedRecording, fit: TonesFit, family: int) -> tuple[float, float]:
    """Relative standard error of a family's factor, and the quantile of its 95 % interval.

    Larger where the noise about its tones is louder than elsewhere, or its partials disagree.
    """
    own = fit.tones.family == family
    freedom = int(own.sum()) - 1
    squares = float(np.sum((fit.offset[own] / fit.offset_error[own]) ** 2))
    error = sqrt(fit.scale_covariance[family, family]) / float(fit.tones.scale[family])
    error *= sqrt(max(1.0, excess(prepared, fit, family)))
    if freedom == 0 or squares < stats.chi2.ppf(DISAGREEING, freedom):
        return error, float(stats.norm.ppf(0.975))
    return error * sqrt(squares / freedom), float(stats.t.ppf(0.975, freedom))


def family_tension(
    prepared: PreparedRecording, fit: TonesFit, family: int, span: str, known: tuple[float, float, float]
) -> SpanTension:
    """The tension that a family says, with what the noise leaves open, wider where its partials disagree.

    ``known``: the tension [N], its relative change with the frequency's, and what the string formula says
    [N].
    """
    value, steep, bare = known
    tones, own = fit.tones, np.flatnonzero(fit.tones.family == family)
    spread, quantile = scale_error(prepared, fit, family)
    error = steep * value * spread
    loudest = own[int(np.argmax(fit.amplitude[own]))]
    partials = [
        Partial(
            number=int(tones.number[k]),
            frequency=float(tones.frequency[k] + fit.offset[k]),
            standard_error=float(fit.offset_error[k]),
            rise=float(tones.rise[k] * tones.frequency[k]),
            decays=bool(fit.resolved[k]),
        )
        for k in own
    ]
    return SpanTension(
        span=span,
        channel=prepared.channel,
        tension=Estimate.of(value, "N", error, quantile * error),
        bare=bare,
        spread=steep * float(np.ptp(fit.offset[own] / tones.frequency[own])),
        line_width=float(line_widths(fit, prepared.duration)[loudest]),
        of_mass=0.5 * steep,
        partials=tuple(partials),
    )


def widened(estimate: Estimate, extra: float) -> Estimate:
    """An interval with one more independent standard error."""
    if extra == 0.0:
        return estimate
    error = sqrt(estimate.standard_error**2 + extra**2)
    half = (estimate.high - estimate.value) * error / estimate.standard_error
    return replace(estimate, standard_error=error, low=estimate.value - half, high=estimate.value + half)
