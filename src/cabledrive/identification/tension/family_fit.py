"""A recording fitted by families of partials, by what a family is known, and the tension that each says."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from math import pi, sqrt
from typing import Any

import numpy as np
from scipy import stats

from cabledrive.answers.keys import Keys
from cabledrive.identification.estimates import ESTIMATE, Estimate
from cabledrive.identification.logs.log import DataReport
from cabledrive.identification.tension.families import FAINTEST, Family, matched
from cabledrive.identification.tension.recording import PARTIALS, PreparedRecording
from cabledrive.identification.tension.tones import Tones, TonesFit, fit_tones, with_decays
from cabledrive.parameters.arrays import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Partial:
    """One tone of a ping."""

    number: int  # which mode of the span, from 1
    frequency: float  # at vanishing amplitude where ``decays``, else at its own [Hz]
    standard_error: float  # [Hz]
    rise: float  # by how much the frequency was higher at its largest envelope [Hz]; 0 where not determined
    decays: bool  # whether the envelope falls enough to identify the effect of amplitude


@dataclass(frozen=True, slots=True, kw_only=True)
class SpanTension:
    """Tension of one span."""

    # the span; where labels cannot be assigned "tauter" or "looser"; "heard" for a single family of partials
    span: str
    channel: str
    tension: Estimate  # [N]
    # what the string formula, 4 rho_0 (L f_1)^2, says: length and mass of the file, no stretch, carriage [N]
    bare: float
    spread: float  # largest difference of the tensions that the partials say, over the tension; 0 with one
    line_width: float  # of its strongest partial: half-power width of its decay and of the record [Hz]
    # relative change of the tension by the file's mass per length (by its length: twice); in no interval
    of_mass: float
    partials: tuple[Partial, ...]
    findings: tuple[str, ...] = ()

    @property
    def bias(self) -> float:
        """What the string formula says minus the tension, over the tension."""
        return self.bare / self.tension.value - 1.0

    @property
    def of_length_and_mass(self) -> dict[str, float]:
        """How far 1 % of the file's length, and of its mass per length, moves the tension [N]."""
        one = 0.01 * self.of_mass * self.tension.value
        return {"of_1_percent_of_length": 2.0 * one, "of_1_percent_of_mass_per_length": one}


SPAN = Keys(
    "channel string_formula=bare string_formula_bias=bias line_width_hz=line_width "
    "of_length_and_mass partials",
    parts={
        "partials": Keys(
            "number frequency_hz=frequency standard_error_hz=standard_error rise_with_amplitude_hz=rise",
            of=Partial,
        )
    },
    of=SpanTension,
)
PINGED = Keys(
    "text: model map: parameters spans flag: identifiable texts: unidentifiable findings rows: data object: "
    "residual{number: relative text: of}",
    parts={"parameters": ESTIMATE, "spans": SPAN, "data": DataReport},
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingTension:
    """Tension of the spans of a drive."""

    spans: Mapping[str, SpanTension]
    report: DataReport
    # where both spans sound in one recording: mean of both tensions [N]; torque on the drive pulley that
    # holds their difference, positive where the lower span is tauter; its size without labels [N m]
    pretension: Estimate | None = None
    standing_torque: Estimate | None = None
    unidentifiable: tuple[str, ...] = ()  # what the recording does not determine, one line each

    def __getitem__(self, span: str) -> float:
        return self.spans[span].tension.value

    @property
    def identifiable(self) -> bool:
        """Whether each tension that was asked for has a value."""
        return self.pretension is None or len(self.spans) == 2

    def as_dict(self) -> dict[str, Any]:
        """The tensions as JSON has them."""
        parameters = {f"tension_{span}": one.tension.as_dict() for span, one in self.spans.items()}
        both = {"pretension": self.pretension, "standing_torque": self.standing_torque}
        parameters |= {name: one.as_dict() for name, one in both.items() if one is not None}
        spread = max(one.spread for one in self.spans.values())
        return {
            "model": "tension-from-ping" + ("" if self.pretension is None else "-of-both-spans"),
            "parameters": parameters,
            "identifiable": self.identifiable,
            "unidentifiable": list(self.unidentifiable),
            "residual": {"relative": spread, "of": "tensions of partials"},
            "spans": {span: SPAN(one) for span, one in self.spans.items()},
            "findings": [finding for one in self.spans.values() for finding in one.findings],
            "data": [asdict(self.report)],
        }


ABOUT = 4.0
"""Line widths about a tone within which what is left is its noise."""
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
    fitted = 2.0 + 0.5 * fit.resolved[own]  # lines that amplitude, frequency, decay and rise take with them
    about = (density @ near) / np.maximum(near.sum(axis=0) - fitted, 1.0)
    weights = (fit.amplitude[own] * fit.tones.frequency[own]) ** 2
    return float(weights @ about / weights.sum() / density.mean())


def _tones(prepared: PreparedRecording, families: tuple[Family, ...]) -> Tones:
    """The tones to begin with: modes that have a peak, and the loudest peaks that belong to none."""
    rows, peaks, explained = [], prepared.peaks, np.zeros(prepared.peaks.frequency.size, dtype=bool)
    teeth = [prepared.factor * prepared.teeth[span] for span, _ in families]
    scale = [factor for _, factor in families]
    taken = [matched(peaks, x * own) for x, own in zip(scale, teeth, strict=True)]
    taken = [np.where((one >= 0) & prepared.falling[one], one, -1) for one in taken]
    shared = np.intersect1d(taken[0][:PARTIALS], taken[-1][:PARTIALS])  # of one family: all
    for place, (one, own) in enumerate(zip(taken, teeth, strict=True)):
        found = np.flatnonzero(one[:PARTIALS] >= 0)
        explained[one[found]] = True
        rows += [(place, own[k], k + 1) for k in found.tolist()]
        found = found[~np.isin(one[found], shared)]
        if found.size:  # a peak of the other family may have proposed the factor
            ratios, loud = peaks.frequency[one[found]] / own[found], peaks.amplitude[one[found]]
            scale[place] = float(np.quantile(ratios, 0.5, weights=loud, method="inverted_cdf"))
    others = np.flatnonzero(~explained)
    others = others[np.argsort(peaks.amplitude[others])[::-1][:MOST_OTHERS]]
    scale += [1.0] * others.size
    rows += [(len(families) + k, peaks.frequency[p], 0) for k, p in enumerate(others)]
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
    clear = fit.amplitude > np.maximum(AUDIBLE * fit.amplitude_error, FAINTEST * fit.amplitude.max())
    if not clear.all():
        if not all(np.any(clear & (fit.tones.family == k)) for k in range(len(families))):
            return None
        fit = fit_tones(prepared.values, prepared.interval, fit.tones.only(clear), prepared.power)
    for k in range(len(families)):  # which decays or has several partials: a single tone that stays is hum
        own = fit.tones.family == k
        if not (np.sum(own) > 1 or fit.resolved[own].any()):
            return None
    return with_overtones(prepared, fit, families)


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
    silent = Tones(
        family=np.zeros(numbers.size, dtype=np.intp),
        tooth=prepared.factor * teeth[numbers - 1],
        number=numbers,
        scale=one.scale,
        decay=np.full(numbers.size, np.median(one.decay[own])),
        rise=np.zeros(numbers.size),
    )
    more = fit_tones(prepared.values, prepared.interval, one.beside(silent), prepared.power)
    kept = more.amplitude > np.maximum(SILENT * more.amplitude_error, FAINTEST * more.amplitude.max())
    kept &= more.tones.decay < LIKE * one.decay[own].max()
    kept[: own.size] = True
    if not kept[own.size :].any():
        return fit
    if kept.all():
        return more
    return fit_tones(prepared.values, prepared.interval, more.tones.only(kept), prepared.power)


def with_overtones(prepared: PreparedRecording, fit: TonesFit, families: tuple[Family, ...]) -> TonesFit:
    """The fit with tones beside its families that are modes above `PARTIALS` of one, within a line width."""
    tones, number = fit.tones, fit.tones.number.copy()
    width = float(np.median(line_widths(fit, prepared.duration)[number > 0]))
    for scale, (span, _) in zip(tones.scale, families, strict=False):
        distance = np.abs(
            tones.frequency[:, None] - scale * prepared.factor * prepared.teeth[span][PARTIALS:]
        )
        near = (tones.number == 0) & (distance.min(axis=1) < width)
        number[near] = PARTIALS + 1 + np.argmin(distance[near], axis=1)
    return replace(fit, tones=replace(tones, number=number))


def criterion(fit: TonesFit, interval: float) -> float:
    """Bayesian information criterion, tones of no span counting as not explained."""
    tones, samples = fit.tones, fit.left.size
    free = tones.number == 0
    lasting = -np.expm1(-2.0 * tones.decay * interval * samples) / (4.0 * tones.decay * interval)
    unexplained = fit.residual + float(np.sum((fit.amplitude**2 * lasting)[free]))
    parameters = 4 * int(np.sum(~free)) + 2
    return float(samples * np.log(unexplained) + parameters * np.log(samples))


def family_tension(
    prepared: PreparedRecording, fit: TonesFit, family: int, span: str, known: tuple[float, float, float]
) -> SpanTension:
    """Tension and error of a family; ``known``: it [N], its relative slope, by the string formula [N]."""
    value, steep, bare = known
    tones, own = fit.tones, np.flatnonzero(fit.tones.family == family)
    # larger where the noise about its tones is louder than elsewhere, or its partials disagree
    spread = sqrt(fit.scale_covariance[family, family]) / float(tones.scale[family])
    spread *= sqrt(max(1.0, excess(prepared, fit, family)))
    freedom, quantile = own.size - 1, float(stats.norm.ppf(0.975))
    squares = float(np.sum((fit.offset[own] / fit.offset_error[own]) ** 2))
    if freedom > 0 and squares >= stats.chi2.ppf(DISAGREEING, freedom):
        spread, quantile = spread * sqrt(squares / freedom), float(stats.t.ppf(0.975, freedom))
    error = steep * value * spread
    loudest = own[int(np.argmax(fit.amplitude[own]))]
    partials = tuple(
        Partial(
            number=int(tones.number[k]),
            frequency=float(tones.frequency[k] + fit.offset[k]),
            standard_error=float(fit.offset_error[k]),
            rise=float(tones.rise[k] * tones.frequency[k]),
            decays=bool(fit.resolved[k]),
        )
        for k in own
    )
    return SpanTension(
        span=span,
        channel=prepared.channel,
        tension=Estimate.of(value, "N", error, quantile * error),
        bare=bare,
        spread=steep * float(np.ptp(fit.offset[own] / tones.frequency[own])),
        line_width=float(line_widths(fit, prepared.duration)[loudest]),
        of_mass=0.5 * steep,
        partials=partials,
    )


def widened(estimate: Estimate, extra: float) -> Estimate:
    """An interval with one more independent standard error."""
    if extra == 0.0:
        return estimate
    error = sqrt(estimate.standard_error**2 + extra**2)
    half = (estimate.high - estimate.value) * error / estimate.standard_error
    return replace(estimate, standard_error=error, low=estimate.value - half, high=estimate.value + half)
