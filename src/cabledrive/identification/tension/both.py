r"""Tensions of both spans: from one recording in which both sound, or from a load cell, section 4.1.

The cell carries the load pulley and holds it against both spans. Where a cable of mass :math:`\rho` per metre
runs with speed v, it takes momentum round the pulley: of each tension only :math:`T - \rho v^2` presses on
it. The turning of the load pulley gives the difference of both,

.. math:: F = (T_1 - \rho v^2) + (T_2 - \rho v^2) + W, \qquad
          r_2(T_2 - T_1) = J_2\ddot\theta_2 + b_2\dot\theta_2 + c_2 S(\dot\theta_2),

with the weight's part W along the line.
"""

from dataclasses import dataclass, replace
from math import hypot, pi, sqrt

import numpy as np
from scipy import stats

from cabledrive.answers.figures import Row
from cabledrive.answers.result import Result
from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.logs.time_check import quantum_of
from cabledrive.identification.signals import difference, zero_phase
from cabledrive.identification.tension import family_fit, recording
from cabledrive.identification.tension.families import OTHERWISE, Family, Proposal, matched, proposals
from cabledrive.identification.tension.family_fit import PingTension, SpanTension
from cabledrive.identification.tension.recording import PreparedRecording
from cabledrive.identification.tension.strings import channels_of, string_of
from cabledrive.identification.tension.tones import TonesFit
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.two_pulleys import two_pulleys_of

SPANS = ("upper", "lower")
SPLIT_EXCESS = 1.7
"""Density of what is left about the tones, over that elsewhere, from which one family may be two."""
BETTER = 0.8
"""Sum of squares of two families, over that of one, from which two are taken to be there."""
CLEARLY = 10.0
"""Units of the criterion by which an assignment must be better than any other."""
WHOLE = (2, 3)
BELOW = 0.5
"""Loudness of a tone at half or a third of a family's first mode, over that mode's, from which it is a first
mode itself: a plucked span has more speed in its first mode than in its second, most points hear it; of a
decaying tone of no family, over the fainter family's, from which it is a finding."""
LOUDER = 1.5
"""Ratio of the loudness of both families from which the louder one is that of the plucked span."""


def tension_of_both(
    log: Log, drive: Machine | Drive, *, plucked: str | None = None, section: int = 0
) -> PingTension:
    """Tension of each span from one recording in which both sound; one alone where it does not separate two.

    ``plucked``: which span was plucked harder, for labels where both have the same modes; ``section``: part
    between guided carriages. Raises `NotComputed` if no tone is found, or two assignments fit alike.
    """
    drive = drive.machine
    if drive.spans != SPANS:
        said = f"--span both is for the two spans of a loop, {drive.name} has {len(drive.spans)}"
        raise InputRefused(f"{said}: name each span that was plucked, a recording each")
    if plucked is not None and plucked not in drive.spans:
        raise InputRefused(f'plucked = "{plucked}": {drive.name} has {", ".join(drive.spans)}: choose one')
    carried = zip(drive.carriage_places, drive.carriage, strict=True)
    parted = {drive.spans[number] for (number, _), own in carried if own.guided}
    sections = {span: section if span in parted else 0 for span in drive.spans}
    strings = {span: string_of(drive, span, own) for span, own in sections.items()}
    teeth = {span: string.modes for span, string in strings.items()}
    prepared = recording.prepared_recording(log, drive, channels_of(log)[0], teeth)
    singles, pairs = proposals(prepared.peaks, prepared.teeth, prepared.factor, sqrt(recording.SEARCHED))
    if not singles:
        raise prepared.no_tone
    fitted = _two_families(prepared, pairs, plucked)
    if fitted is None:
        family = singles[0][1][0]
        one = family_fit.fit_families(prepared, (family,))
        if one is None:
            raise prepared.no_tone
        doubtful = family_fit.excess(prepared, one, 0) > SPLIT_EXCESS
        split = _split(prepared, family, one) if doubtful and prepared.alike else None
        if split is None or not _apart(prepared, split):
            overlapping = split.residual < BETTER * one.residual if split else doubtful and not prepared.alike
            tension = strings[family[0]].tension_of(prepared, one)
            return _of_one_family(prepared, one, tension, plucked, overlapping)
        fitted = split
    lines: tuple[str, ...] = ()
    names = _label(prepared, fitted, plucked)
    first, second = (strings[name].tension_of(prepared, fitted, k) for k, name in enumerate(names or SPANS))
    if names is None:
        shown = sorted((first, second), key=lambda one: -one.tension.value)
        found = dict(zip(("tauter", "looser"), shown, strict=True))
        why = "name the one plucked harder (--plucked)"
        if plucked:
            why = "both are about equally loud: pluck that one harder"
        lines = (f"which of both tensions is the upper span's: the spans have the same modes; {why}",)
    else:
        found = {one.span: one for one in sorted((first, second), key=lambda o: SPANS.index(o.span))}
    a, b = (one.tension for one in found.values())
    error, half = hypot(a.standard_error, b.standard_error), hypot(a.high - a.value, b.high - b.value)
    radius = drive.pulley[0].radius
    torque = radius * (b.value - a.value) * (-1.0 if names is None else 1.0)
    mean = Estimate.of(0.5 * (a.value + b.value), "N", 0.5 * error, 0.5 * half)
    held = Estimate.of(torque, "N m", radius * error, radius * half)
    return _answer(prepared, fitted, found, mean, held, lines)


def _of_one_family(
    prepared: PreparedRecording, fit: TonesFit, one: SpanTension, plucked: str | None, overlapping: bool
) -> PingTension:
    """One family, or two (``overlapping``: they fit better) within the width of a line."""
    alike, name = prepared.alike, one.span
    if alike:
        name = "heard" if plucked is None or overlapping else plucked
    own = np.flatnonzero(fit.tones.family == 0)
    loudest = float(fit.tones.frequency[own[int(np.argmax(fit.amplitude[own]))]])
    within = 2.0 * one.tension.value * one.line_width / loudest
    tone = f"{loudest:.4g} Hz, lines {one.line_width:.2g} Hz wide"
    other = SPANS[1 - SPANS.index(one.span)]
    remedy = "record longer, or damp one span and record the other alone"
    if overlapping and alike:
        line = (
            f"two families of partials within a line width ({tone}): both tensions lie within {within:.2g} N "
        )
        line += f"and cannot be separated; {remedy}"
    elif overlapping:
        line = f"the partials ({tone}) are those of the {one.span} span, but another tone lies within a line "
        line += f"width of them: the {other} span is not identifiable; {remedy}"
    elif alike:
        line = f"one family of partials only ({tone}): either only one span vibrates, "
        line += f"or both have the same tension within {within:.2g} N; pluck the other span and record again"
    else:
        line = f"the {other} span is not detected beside the {name} one ({tone}): pluck it and record again"
    if name == "heard":  # an interval for two tensions that differ by less than so much
        error = sqrt(one.tension.standard_error**2 + within**2 / 3.0)
        low, high = one.tension.low - within, one.tension.high + within
        one = replace(one, tension=replace(one.tension, standard_error=error, low=low, high=high))
    unknown = Estimate.unknown("N", line)
    return _answer(prepared, fit, {name: one}, unknown, replace(unknown, unit="N m"), (line,))


def _answer(
    prepared: PreparedRecording,
    fit: TonesFit,
    found: dict[str, SpanTension],
    mean: Estimate,
    torque: Estimate,
    lines: tuple[str, ...],
) -> PingTension:
    """The answer with what a single partial, one that hardly decays, or another loud tone leaves open."""
    spans, fainter = {}, min(fit.amplitude[fit.tones.family == k].max() for k in range(len(found)))
    beside = (fit.tones.number == 0) & fit.decays & (fit.amplitude > BELOW * fainter)
    others = ", ".join(f"{hertz:.4g}" for hertz in np.sort(fit.tones.frequency[beside]))
    for name, one in found.items():
        findings = []
        if len(one.partials) == 1:
            said = f"{name}: from a single partial, assumed to be mode {one.partials[0].number}"
            findings.append(f"{said}: an overtone or hum would give a wrong tension")
        if not any(partial.decays for partial in one.partials):
            findings.append(f"{name}: the ping hardly decays: its frequency holds for its amplitude only")
        if others:
            said = f"{name}: other tones decay as well, at {others} Hz, and are no partials of what was found"
            findings.append(f"{said}: damp what else vibrates, or pluck again, the tension may be another")
        spans[name] = replace(one, span=name, findings=tuple(findings))
    return PingTension(
        spans=spans, report=prepared.log.report, pretension=mean, standing_torque=torque, unidentifiable=lines
    )


def _two_families(
    prepared: PreparedRecording, pairs: tuple[Proposal, ...], plucked: str | None
) -> TonesFit | None:
    """The best of some assignments; None where there is none whose families are apart."""
    clear: list[tuple[float, TonesFit]] = []
    for score, families in pairs:
        fit = family_fit.fit_families(prepared, families)
        factor = np.ones(2) if fit is None else _misread(prepared, fit)
        if np.any(factor != 1.0):
            families = tuple((span, x * by) for (span, x), by in zip(families, factor.tolist(), strict=True))
            fit = family_fit.fit_families(prepared, families)
            factor = np.ones(2) if fit is None else _misread(prepared, fit)
        if fit is None or np.any(factor != 1.0) or not _apart(prepared, fit):
            continue
        clear.append((family_fit.criterion(fit, prepared.interval) - family_fit.MISSING_PRICE * score, fit))
    clear.sort(key=lambda one: one[0])
    rivals = [fit for cost, fit in clear if cost < clear[0][0] + CLEARLY]
    like = [np.allclose(fit.tones.scale[:2], rivals[0].tones.scale[:2], OTHERWISE) for fit in rivals]
    rivals = rivals[:1] + [fit for fit, same in zip(rivals, like, strict=True) if not same]
    if prepared.alike or len(rivals) < 2:
        return clear[0][1] if clear else None
    firsts = prepared.factor * np.array([prepared.teeth[span][0] for span in SPANS])
    words = "first modes at {:.4g} Hz (upper) and {:.4g} Hz (lower)".format
    listed = " or ".join(words(*(fit.tones.scale[:2] * firsts)) for fit in rivals[:2])
    if plucked is not None:
        index = SPANS.index(plucked)
        rivals = [one for one in rivals if _strength(one, index) > LOUDER * _strength(one, 1 - index)]
        if len(rivals) == 1:
            return rivals[0]
    said = f"{prepared.channel}: two assignments of the partials fit equally well, {listed}"
    raise NotComputed(f"{said}: pluck so that more partials sound, or name the plucked span (--plucked)")


def _strength(fit: TonesFit, family: int) -> float:
    """Loudness of a family: root of the sum of squares of its amplitudes."""
    return float(np.linalg.norm(fit.amplitude[fit.tones.family == family]))


def _apart(prepared: PreparedRecording, fit: TonesFit) -> bool:
    """Whether each of two families has a partial more than a line width from every mode of the other."""
    tones, width = fit.tones, family_fit.line_widths(fit, prepared.duration)
    for one, two in ((0, 1), (1, 0)):
        own, others = tones.family == one, tones.scale[two] * prepared.factor * prepared.teeth[SPANS[two]]
        distance = np.abs(tones.frequency[own][:, None] - others).min(axis=1)
        if not np.any(distance > width[own]):
            return False
    return True


def _misread(prepared: PreparedRecording, fit: TonesFit) -> Array:
    """Factor on each family, shape (2,): other tones are modes of a lower one, or numbers have a divisor."""
    tones, factor, free = fit.tones, np.ones(2), fit.tones.number == 0
    hertz, width = tones.frequency[free], family_fit.line_widths(fit, prepared.duration)[free]
    for place in (0, 1):
        own = np.flatnonzero(tones.family == place)
        modes = tones.scale[place] * prepared.factor * prepared.teeth[SPANS[place]]
        heard = 1 + np.flatnonzero(matched(prepared.peaks, modes) >= 0)
        factor[place] = np.gcd.reduce(heard) if heard.size > 1 else 1.0
        for first in own[tones.number[own] == 1]:
            loud = fit.amplitude[free] > BELOW * fit.amplitude[first]
            for whole in WHOLE:
                order = np.rint(whole * hertz / tones.frequency[first])
                near = np.abs(hertz - order * tones.frequency[first] / whole) < width
                if np.any(loud & near & (order % whole > 0) & (order <= recording.PARTIALS)):
                    factor[place] = 1.0 / whole
    return factor


def _label(prepared: PreparedRecording, fit: TonesFit, plucked: str | None) -> tuple[str, str] | None:
    """Which span each of two families belongs to; None where modes are alike and loudness does not decide."""
    if not prepared.alike:
        return SPANS
    first, second = _strength(fit, 0), _strength(fit, 1)
    if plucked is None or max(first, second) < LOUDER * min(first, second):
        return None
    return SPANS if (plucked == "upper") == (first > second) else (SPANS[1], SPANS[0])


def _split(prepared: PreparedRecording, family: Family, one: TonesFit) -> TonesFit | None:
    """Two families in the place of one, less than the spectrum parts; the best of a few beginnings."""
    own = one.tones.family == 0
    lowest = float(one.tones.frequency[own].min())
    width = (float(np.median(one.tones.decay[own])) / pi + 1.0 / prepared.duration) / lowest
    loudest = one.tones.number[own][int(np.argmax(one.amplitude[own]))]
    first, rest, place = one.tones.only(own), one.tones.only(~own), one.tones.scale[0]
    families = np.concatenate([first.family, first.family + 1, rest.family + 1])
    best: TonesFit | None = None
    for share in (0.25, 1.0):
        # the family twice, half a distance below and above its place
        scale = np.concatenate([place * (1 + np.array([-0.5, 0.5]) * (share * width)), one.tones.scale[1:]])
        begin = replace(first.beside(first).beside(rest), family=families, scale=scale)
        fit = family_fit.fit_families(prepared, (family, family), begin)
        if fit is None or abs(fit.tones.scale[1] / fit.tones.scale[0] - 1.0) > 4.0 * width:
            continue
        both = all(loudest in fit.tones.number[fit.tones.family == k] for k in (0, 1))
        if both and (best is None or fit.residual < best.residual):
            best = fit
    return best


BANDWIDTH = 40.0
"""Of the filter without phase on force and angle [Hz]."""
MEAN_WORDS = "{0[0]:.4g} N, {0[1]:.4g} to {0[2]:.4g} N".format


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class SpanTensions(Result):
    """Tension at the load pulley over time."""

    _table = "time: upper lower"
    _shown = tuple(Row(f"mean_{span}", f"Mean tension of the {span} span", "N", MEAN_WORDS) for span in SPANS)
    time: Array  # (samples,) [s]
    # upper, lower: (samples,) [N]
    upper: Array
    lower: Array
    deviation: float  # of each at one instant, from the noise of the cell and of the angle [N]
    # mean over the log with its 95 % bounds [N]; they cover what the log shows, not the cell's calibration
    mean_upper: tuple[float, float, float]
    mean_lower: tuple[float, float, float]
    findings: tuple[str, ...] = ()


def tensions_from_load_cell(log: Log, drive: Machine | Drive, *, zero: float = 0.0) -> SpanTensions:
    """Tension of the upper and the lower span from their combined pull on the load cell.

    Parameters
    ----------
    log : Log
        With "load_cell_force" or "force" [N]; without "load_angle" [rad] the pulley is taken to rest.
    drive : Machine or Drive
        Loop whose load pulley leans against the cell.
    zero : float, default 0.0
        What the cell says without cable: its zero and the weight's part [N].

    Returns
    -------
    SpanTensions

    Raises
    ------
    InputRefused
        If the drive is no loop, or the log lacks the force.
    """
    drive = two_pulleys_of(drive, "a load cell behind the load pulley")
    if not drive.closed:
        raise InputRefused(f'{drive.name}: kind = "{drive.kind}" has one span: give a loop')
    bandwidth, h, pulley = min(BANDWIDTH, 0.2 * log.sample_rate), log.interval, drive.load_pulley
    force = "load_cell_force" if "load_cell_force" in log.channels else "force"
    pull = zero_phase(log.channel(force), h, bandwidth) - zero
    findings, speed, turning, rounding = [], np.zeros(len(log)), np.zeros(len(log)), 0.0
    if "load_angle" in log.channels:
        angle = log.channel("load_angle")
        speed = zero_phase(difference(angle, h), h, bandwidth)
        friction = pulley.viscous_friction * speed + pulley.coulomb_friction * np.sign(speed)
        turning = pulley.inertia * difference(speed, h) + friction
        # The difference of tensions from the rounding of the angle, taken for white noise.
        density = quantum_of(angle) ** 2 / 12.0 * 2.0 * h
        rounding = pulley.inertia / pulley.radius * sqrt(density * (2 * pi) ** 4 * bandwidth**5 / 5.0)
    else:
        findings.append("no angle of the load pulley: assumed at rest, equal tensions in both spans")
    momentum = drive.cable.mass_per_length / (1.0 + drive.cable.prestrain) * (pulley.radius * speed) ** 2
    mean, half = 0.5 * pull + momentum, 0.5 * turning / pulley.radius
    edge = min(len(log) // 4, round(1.0 / (bandwidth * h)))
    part = slice(edge, len(log) - edge)
    upper, lower = (mean - half)[part], (mean + half)[part]
    if min(float(upper.min()), float(lower.min())) <= 0.0:
        findings.append("a tension falls to zero: a span goes slack, or the cell's zero is wrong")
    noise = log.channel(force) - zero - pull
    cell = float(noise[part].std()) * sqrt(2.0 * bandwidth * h)
    return SpanTensions(
        time=log.time[part],
        upper=upper,
        lower=lower,
        deviation=0.5 * hypot(cell, rounding),
        mean_upper=_mean(upper),
        mean_lower=_mean(lower),
        findings=tuple(findings),
    )


def _mean(values: Array, blocks: int = 20) -> tuple[float, float, float]:
    """Mean and its 95 % bounds from means of blocks, which forget one another."""
    means = np.array([part.mean() for part in np.array_split(values, blocks)])
    half = float(stats.t.ppf(0.975, blocks - 1) * means.std(ddof=1) / sqrt(blocks))
    return float(values.mean()), float(values.mean() - half), float(values.mean() + half)
