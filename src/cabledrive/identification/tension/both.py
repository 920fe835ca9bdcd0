"""Tensions of both spans from one recording in which both sound."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import hypot, pi, sqrt

import numpy as np

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.families import Family, Proposal, proposals
from cabledrive.identification.tension.family_fit import (
    LOUDER,
    MISSING_PRICE,
    SPANS,
    PingTension,
    SpanTension,
    apart,
    criterion,
    excess,
    family_tension,
    fit_families,
    has_tone_below,
    label,
    strength,
)
from cabledrive.identification.tension.recording import SEARCHED, PreparedRecording, prepared_recording
from cabledrive.identification.tension.strings import bare_tension, channels_of, section_modes, tensions_for
from cabledrive.identification.tension.tones import Tones, TonesFit
from cabledrive.parameters import Drive, InputRefused, NotComputed

SPLIT_EXCESS = 1.5
"""Density of what is left about the tones, over that elsewhere, from which one family may be two."""
BETTER = 0.8
"""Sum of squares of two families, over that of one, from which two are taken to be there."""
CLEARLY = 10.0
"""Units of the criterion by which an assignment must be better than any other."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Asked:
    """A recording with what is known of it."""

    log: Log
    drive: Drive
    prepared: PreparedRecording
    sections: Mapping[str, int]  # which section of each span was plucked
    plucked: str | None


def tension_of_both(
    log: Log,
    drive: Drive,
    *,
    channel: str | None = None,
    plucked: str | None = None,
    section: int = 0,
) -> PingTension:
    """Tension of each span from one recording in which both sound; one alone where it does not separate two.

    The partials are parted into two families, each with the frequency ratios of the certified modes of its
    span, and fitted together. Unknown are the pretension, for which that of ``drive``, a loop, is a first
    guess good to a factor of four for either span, and a standing torque on the drive pulley; both keep the
    unstretched lengths of the spans.

    ``channel``: default: the first that hears a ping; ``plucked``, {"upper", "lower"}: which span was plucked
    harder, needed for labels where both have the same modes; ``section``: which section of a span was
    plucked, where guided carriages part it. Raises `InputRefused` if the drive has one span, or channel or
    section are not there; `NotComputed` if no tone is found, or two assignments fit equally well.
    """
    if len(drive.spans) < 2:
        raise InputRefused(f"{drive.name} has one span: read it without asking for both")
    if plucked is not None and plucked not in drive.spans:
        raise InputRefused(f'plucked = "{plucked}": {drive.name} has {", ".join(drive.spans)}: choose one')
    parted = {span: any(one.guided for one in drive.carriages_on(span)) for span in drive.spans}
    sections = {span: section if parted[span] else 0 for span in drive.spans}
    teeth = {span: section_modes(drive, span, own) for span, own in sections.items()}
    prepared = prepared_recording(log, drive, channel or channels_of(log)[0], teeth)
    asked = _Asked(
        log=log,
        drive=drive,
        prepared=prepared,
        sections=sections,
        plucked=plucked,
    )
    singles, pairs = proposals(prepared.peaks, prepared.teeth, prepared.factor, sqrt(SEARCHED))
    if not singles:
        raise prepared.no_tone
    fitted = _two_families(prepared, pairs, plucked)
    if fitted is None:
        family = singles[0].families[0]
        one = fit_families(prepared, (family,))
        if one is None:
            raise prepared.no_tone
        doubtful = excess(fit=one, family=0, prepared=prepared) > SPLIT_EXCESS
        split = _split(prepared, family, one) if doubtful and prepared.alike else None
        if split is None or not apart(prepared, split, SPANS):
            overlapping = split.residual < BETTER * one.residual if split else doubtful and not prepared.alike
            return _of_one_family(asked, one, family.span, overlapping)
        fitted = split
    return _of_two_families(asked, fitted)


def _of_two_families(asked: _Asked, fit: TonesFit) -> PingTension:
    """The answer where two families are found, the first two of the fit."""
    names = label(asked.prepared, fit, asked.plucked)
    first, second = _tensions(asked, fit, names or SPANS)
    order = names or (
        ("looser", "tauter") if first.tension.value < second.tension.value else ("tauter", "looser")
    )
    found = {name: replace(one, span=name) for name, one in zip(order, (first, second), strict=True)}
    found = {name: found[name] for name in (SPANS if names else ("tauter", "looser"))}
    lines: tuple[str, ...] = ()
    if names is None:
        why = "name the one plucked harder (--plucked)"
        if asked.plucked:
            why = "both are about equally loud: pluck that one harder"
        lines = (f"which of both tensions is the upper span's: the spans have the same modes; {why}",)
    a, b = (one.tension for one in found.values())
    error, half = (
        0.5 * hypot(*pair)
        for pair in ((a.standard_error, b.standard_error), (a.high - a.value, b.high - b.value))
    )
    radius = asked.drive.drive_pulley.radius
    torque = radius * (b.value - a.value) * (-1.0 if names is None else 1.0)
    return _answer(
        asked,
        found,
        Estimate.of(0.5 * (a.value + b.value), "N", error, half),
        Estimate.of(torque, "N m", 2.0 * radius * error, 2.0 * radius * half),
        lines,
    )


def _of_one_family(asked: _Asked, fit: TonesFit, span: str, overlapping: bool) -> PingTension:
    """The answer where one family is found, or two within the width of a line.

    ``span``: whose modes fit it; ``overlapping``: whether two families fit better than one, though less than
    a line width apart.
    """
    alike, plucked = asked.prepared.alike, asked.plucked
    (one,) = _tensions(asked, fit, (span,))
    name = "heard" if alike and (plucked is None or overlapping) else (plucked or span)
    name = span if not alike else name
    own = np.flatnonzero(fit.tones.family == 0)
    loudest = float(fit.tones.frequency[own[int(np.argmax(fit.amplitude[own]))]])
    within = 2.0 * one.tension.value * one.line_width / loudest
    tone = f"{loudest:.4g} Hz, lines {one.line_width:.2g} Hz wide"
    if name == "heard":  # an interval for two tensions that differ by less than so much
        error = sqrt(one.tension.standard_error**2 + within**2 / 3.0)
        low, high = one.tension.low - within, one.tension.high + within
        one = replace(one, tension=replace(one.tension, standard_error=error, low=low, high=high))
    other = SPANS[1 - SPANS.index(span)]
    if overlapping and alike:
        line = (
            f"two families of partials within a line width ({tone}): both tensions lie within {within:.2g} N "
            "and cannot be separated; record longer, or damp one span and record the other alone"
        )
    elif overlapping:
        line = (
            f"the partials ({tone}) are those of the {span} span, but another tone lies within a line "
            f"width of them: the {other} span is not identifiable; record longer, or damp one and record "
            "the other alone"
        )
    elif alike:
        line = (
            f"one family of partials only ({tone}): either only one span vibrates, or both have the same "
            f"tension within {within:.2g} N; pluck the other span and record again"
        )
    else:
        line = f"the {other} span is not detected beside the {span} one ({tone}): pluck it and record again"
    unknown = Estimate.unknown("N", line)
    return _answer(asked, {name: replace(one, span=name)}, unknown, replace(unknown, unit="N m"), (line,))


def _tensions(asked: _Asked, fit: TonesFit, spans: tuple[str, ...]) -> list[SpanTension]:
    """Tension of each of the first families, whose spans have these names."""
    prepared, drive, tones, wanted = asked.prepared, asked.drive, fit.tones, []
    for k, span in enumerate(spans):
        place = int(np.flatnonzero(tones.family == k)[0])
        hertz = float(tones.frequency[place]) / prepared.factor
        wanted.append((span, asked.sections[span], int(tones.number[place]), hertz))
    found = []
    for k, (span, value) in enumerate(zip(spans, tensions_for(drive, wanted), strict=True)):
        steep = 2.0 * (1.0 + value / drive.cable.axial_rigidity)
        bare = bare_tension(drive, float(tones.scale[k]) * float(prepared.teeth[span][0]))
        found.append(family_tension(prepared, fit, k, span, (value, steep, bare)))
    return found


def _answer(
    asked: _Asked, found: dict[str, SpanTension], mean: Estimate, torque: Estimate, lines: tuple[str, ...]
) -> PingTension:
    """The answer with what a single partial, or one that hardly decays, leaves open."""
    spans = {}
    for name, one in found.items():
        findings = []
        if len(one.partials) == 1:
            findings.append(
                f"{name}: from a single partial, assumed to be mode {one.partials[0].number}: an overtone or "
                "hum would give a wrong tension"
            )
        if not any(partial.decays for partial in one.partials):
            findings.append(f"{name}: the ping hardly decays: its frequency holds for its amplitude only")
        spans[name] = replace(one, findings=tuple(findings))
    return PingTension(
        spans=spans,
        report=asked.log.report,
        drive=asked.drive.name,
        pretension=mean,
        standing_torque=torque,
        unidentifiable=lines,
    )


def _two_families(
    prepared: PreparedRecording, pairs: tuple[Proposal, ...], plucked: str | None
) -> TonesFit | None:
    """The best of some assignments; None where there is none whose families are apart."""
    tried = [(fit_families(prepared, pair.families), pair.score) for pair in pairs]
    clear = [
        (criterion(fit, prepared.interval) - MISSING_PRICE * score, fit)
        for fit, score in tried
        if fit is not None and apart(prepared, fit, SPANS) and not has_tone_below(prepared, fit)
    ]
    clear.sort(key=lambda one: one[0])
    rivals = [fit for cost, fit in clear if cost < clear[0][0] + CLEARLY]
    if prepared.alike or len(rivals) < 2:
        return clear[0][1] if clear else None
    alike = rivals[:2]
    if plucked is not None:
        index = SPANS.index(plucked)
        rivals = [one for one in rivals if strength(one, index) > LOUDER * strength(one, 1 - index)]
        if len(rivals) == 1:
            return rivals[0]
    listed = " or ".join(_assigned(prepared, fit) for fit in alike)
    raise NotComputed(
        f"{prepared.channel}: two assignments of the partials fit equally well, {listed}: "
        "pluck so that more partials are excited, or name the plucked span "
        "(--plucked)"
    )


def _assigned(prepared: PreparedRecording, fit: TonesFit) -> str:
    first = [fit.tones.scale[k] * prepared.factor * prepared.teeth[span][0] for k, span in enumerate(SPANS)]
    return f"first modes at {first[0]:.4g} Hz (upper) and {first[1]:.4g} Hz (lower)"


def _split(prepared: PreparedRecording, family: Family, one: TonesFit) -> TonesFit | None:
    """Two families in the place of one, less than the spectrum parts; the best of a few beginnings."""
    own = one.tones.family == 0
    lowest = float(one.tones.frequency[own].min())
    width = (float(np.median(one.tones.decay[own])) / pi + 1.0 / prepared.duration) / lowest
    loudest = one.tones.number[own][int(np.argmax(one.amplitude[own]))]
    best: TonesFit | None = None
    for share in (0.25, 1.0):
        fit = fit_families(prepared, (family, family), _doubled(one.tones, share * width))
        if fit is None or abs(fit.tones.scale[1] / fit.tones.scale[0] - 1.0) > 4.0 * width:
            continue
        both = all(loudest in fit.tones.number[fit.tones.family == k] for k in (0, 1))
        if both and (best is None or fit.residual < best.residual):
            best = fit
    return best


def _doubled(tones: Tones, distance: float) -> Tones:
    """The first family twice, half a distance below and above its place."""
    own = tones.family == 0
    first, rest, x = tones.only(own), tones.only(~own), tones.scale[0]
    both = {
        name: np.concatenate([getattr(first, name), getattr(first, name), getattr(rest, name)])
        for name in ("tooth", "number", "decay", "rise")
    }
    zero = np.zeros(first.tooth.size, dtype=np.intp)
    family = np.concatenate([zero, zero + 1, rest.family + 1])
    scale = np.concatenate([[x * (1 - 0.5 * distance), x * (1 + 0.5 * distance)], tones.scale[1:]])
    return replace(tones, family=family, scale=scale, **both)
