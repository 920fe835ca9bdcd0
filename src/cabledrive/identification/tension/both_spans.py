"""Tensions of both spans from one recording in which both sound."""

from dataclasses import replace
from math import nan, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import BothTensions, FamilyTension
from cabledrive.identification.tension.decaying_tones import Tones, TonesFit
from cabledrive.identification.tension.families import Family, Proposal, proposals
from cabledrive.identification.tension.family_fit import (
    LOUDER,
    MISSING_PRICE,
    SPANS,
    apart,
    criterion,
    excess,
    fit_families,
    has_tone_below,
    label,
    line_widths,
    partials_of,
    scale_error,
    strength,
)
from cabledrive.identification.tension.from_ping import channels_of, modes_of
from cabledrive.identification.tension.prepared_recording import (
    SEARCHED,
    PreparedRecording,
    prepared_recording,
)
from cabledrive.parameters import Drive, InputRefused, NotComputed


def of_two_families(
    prepared: PreparedRecording,
    log: Log,
    drive: Drive,
    fit: TonesFit,
    names: tuple[str, str] | None,
    plucked: str | None,
    errors: tuple[float, float],
) -> BothTensions:
    """The answer where two families are found.

    ``fit``: its first two families are those of the spans; ``names``: which span each is; ``errors``:
    relative standard errors of length and of mass per length.
    """
    spans = names or SPANS
    values = _tensions(drive, prepared, fit, spans)
    order = names or (("looser", "tauter") if values[0] < values[1] else ("tauter", "looser"))
    families = {order[k]: _family(prepared, drive, fit, k, order[k], values[k], errors) for k in (0, 1)}
    families = {name: families[name] for name in (SPANS if names else ("tauter", "looser"))}
    first, second = (families[name].tension for name in families)
    mean, torque = _mean_and_torque(drive, first, second, labelled=names is not None)
    lines: tuple[str, ...] = ()
    if names is None:
        why = (
            "both are about equally loud: pluck that one harder"
            if plucked
            else "name the one plucked harder (--plucked)"
        )
        lines = (f"which of both tensions is the upper span's: the spans have the same modes; {why}",)
    return BothTensions(
        families=families,
        pretension=mean,
        standing_torque=torque,
        labelled=names is not None,
        unidentifiable=lines,
        findings=tuple(_findings(families)),
        channel=prepared.channel,
        report=log.report,
        drive=drive.name,
    )


def of_one_family(
    prepared: PreparedRecording,
    log: Log,
    drive: Drive,
    span: str,
    fit: TonesFit,
    overlapping: bool,
    plucked: str | None,
    errors: tuple[float, float],
) -> BothTensions:
    """The answer where one family is found, or two within the width of a line.

    ``span``: whose modes fit it; ``overlapping``: whether two families fit better than one, though less than
    a line width apart; ``errors``: relative standard errors of length and of mass per length.
    """
    (value,) = _tensions(drive, prepared, fit, (span,))
    name = "heard" if prepared.alike and (plucked is None or overlapping) else (plucked or span)
    name = span if not prepared.alike else name
    one = _family(prepared, drive, fit, 0, name, value, errors)
    own = np.flatnonzero(fit.tones.family == 0)
    loudest = own[int(np.argmax(fit.amplitude[own]))]
    width = float(line_widths(fit, prepared.duration)[loudest])
    within = 2.0 * value * width / float(fit.tones.frequency[loudest])
    tone = f"{fit.tones.frequency[loudest]:.4g} Hz, lines {width:.2g} Hz wide"
    if name == "heard":
        one = replace(one, tension=_widened(one.tension, within))
    other = SPANS[1 - SPANS.index(span)]
    if overlapping and prepared.alike:
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
    elif prepared.alike:
        line = (
            f"one family of partials only ({tone}): either only one span vibrates, or both have the same "
            f"tension within {within:.2g} N; pluck the other span and record again"
        )
    else:
        line = f"the {other} span is not detected beside the {span} one ({tone}): pluck it and record again"
    unknown = Estimate(value=nan, unit="N", standard_error=np.inf, low=-np.inf, high=np.inf, reason=line)
    return BothTensions(
        families={name: one},
        pretension=unknown,
        standing_torque=replace(unknown, unit="N m"),
        labelled=False,
        unidentifiable=(line,),
        findings=tuple(_findings({name: one})),
        channel=prepared.channel,
        report=log.report,
        drive=drive.name,
    )


def _widened(estimate: Estimate, within: float) -> Estimate:
    """An interval for two tensions that differ by less than so much."""
    return replace(
        estimate,
        standard_error=sqrt(estimate.standard_error**2 + within**2 / 3.0),
        low=estimate.low - within,
        high=estimate.high + within,
    )


def _findings(families: dict[str, FamilyTension]) -> list[str]:
    found = []
    for name, one in families.items():
        if len(one.partials) == 1:
            number = one.partials[0].number
            found.append(
                f"{name}: from a single partial, assumed to be mode {number}: an overtone or hum would "
                "give a wrong tension"
            )
        if not any(partial.decays for partial in one.partials):
            found.append(f"{name}: the ping hardly decays: its frequency holds for its amplitude only")
    return found


def _tensions(
    drive: Drive, prepared: PreparedRecording, fit: TonesFit, spans: tuple[str, ...]
) -> list[float]:
    """Tensions at which certified modes have the frequencies, both spans keeping their unstretched length.

    Where the file gives the distance of the pulleys that length is the one at the mean tension, which is
    repeated until it stands.
    """
    tones, rigidity = fit.tones, drive.cable.axial_rigidity
    lowest = [int(np.flatnonzero(tones.family == k)[0]) for k in range(len(spans))]
    values, trial = [drive.cable.pretension], drive
    for _ in range(60):
        before, values, cable = values, [], trial.cable
        for place, span in zip(lowest, spans, strict=True):
            number = int(tones.number[place])
            own = float(modes_of(trial, span, prepared.section)[number - 1])
            ratio = float(tones.frequency[place]) / prepared.factor / own
            reduced = cable.pretension / (1.0 + cable.prestrain) * ratio**2
            if reduced >= rigidity:
                raise NotComputed(f"no tension makes mode {number} of the {span} span {ratio * own:.5g} Hz")
            values.append(reduced / (1.0 - reduced / rigidity))
        if len(before) == len(values) and np.allclose(before, values, rtol=1e-12):
            break
        trial = replace(drive, cable=replace(drive.cable, pretension=float(np.mean(values))))
    return values


def _family(
    prepared: PreparedRecording,
    drive: Drive,
    fit: TonesFit,
    family: int,
    name: str,
    value: float,
    errors: tuple[float, float],
) -> FamilyTension:
    """One tension with its interval: what the noise leaves open, wider where the partials disagree."""
    own = np.flatnonzero(fit.tones.family == family)
    steep = 2.0 * (1.0 + value / drive.cable.axial_rigidity)
    relative = fit.offset[own] / fit.tones.frequency[own]
    spread, quantile = scale_error(prepared, fit, family)
    error = steep * value * spread
    wider = sqrt(1.0 + ((2.0 * errors[0]) ** 2 + errors[1] ** 2) * (value / error) ** 2)
    half = error * wider * quantile
    loudest = own[int(np.argmax(fit.amplitude[own]))]
    return FamilyTension(
        name=name,
        tension=Estimate(
            value=value, unit="N", standard_error=error * wider, low=value - half, high=value + half
        ),
        spread=steep * float(np.ptp(relative)),
        line_width=float(line_widths(fit, prepared.duration)[loudest]),
        of_mass=0.5 * steep,
        partials=partials_of(fit, family),
    )


def _mean_and_torque(
    drive: Drive, first: Estimate, second: Estimate, *, labelled: bool
) -> tuple[Estimate, Estimate]:
    """Pretension and standing torque, the errors of both tensions being independent."""
    error = 0.5 * sqrt(first.standard_error**2 + second.standard_error**2)
    half = 0.5 * sqrt((first.high - first.value) ** 2 + (second.high - second.value) ** 2)
    mean = 0.5 * (first.value + second.value)
    radius = drive.drive_pulley.radius
    torque = radius * (second.value - first.value) * (1.0 if labelled else -1.0)
    reach = 2.0 * radius * half
    return (
        Estimate(value=mean, unit="N", standard_error=error, low=mean - half, high=mean + half),
        Estimate(
            value=torque,
            unit="N m",
            standard_error=2.0 * radius * error,
            low=torque - reach,
            high=torque + reach,
        ),
    )


Array = NDArray[np.float64]

SPLIT_EXCESS = 1.5
"""Density of what is left about the tones, over that elsewhere, from which one family may be two."""
BETTER = 0.8
"""Sum of squares of two families, over that of one, from which two are taken to be there."""
CLEARLY = 10.0
"""Units of the criterion by which an assignment must be better than any other."""


def tension_of_both(
    log: Log,
    drive: Drive,
    *,
    channel: str | None = None,
    plucked: str | None = None,
    section: int = 0,
    length_error: float = 0.0,
    density_error: float = 0.0,
) -> BothTensions:
    """Tension of each span from one recording in which both sound.

    The partials are parted into two families, each with the frequency ratios of the certified modes of its
    span, and fitted together. Unknown are the pretension and a standing torque on the drive pulley, which
    keep the unstretched lengths of the spans.

    Parameters
    ----------
    log : Log
    drive : Drive
        A loop; its pretension serves as a first guess, good to a factor of four for either span.
    channel : str, optional
        Default: the first that hears a ping.
    plucked : {"upper", "lower"}, optional
        Which span was plucked harder: its family is the louder one. Needed for labels where both spans have
        the same modes.
    section : int, default 0
        Which section of a span was plucked, where guided carriages part it; a span in one piece has one.
    length_error, density_error : float, default 0.0
        Relative standard errors of the file's length and mass per length; the intervals grow by them.

    Returns
    -------
    BothTensions
        With one family alone where the recording does not separate two.

    Raises
    ------
    InputRefused
        If the drive has one span, or channel or section are not there.
    NotComputed
        If no tone is found, or two assignments fit equally well.
    """
    if len(drive.spans) < 2:
        raise InputRefused(f"{drive.name} has one span: read it without asking for both")
    if plucked is not None and plucked not in drive.spans:
        raise InputRefused(f'plucked = "{plucked}": {drive.name} has {", ".join(drive.spans)}: choose one')
    name = channel or channels_of(log)[0]
    teeth = {span: modes_of(drive, span, section) for span in drive.spans}
    prepared = prepared_recording(log, drive, name, teeth, section)
    singles, pairs = proposals(prepared.peaks, prepared.teeth, prepared.factor, sqrt(SEARCHED))
    if not singles:
        raise prepared.no_tone
    fitted = _two_families(prepared, pairs, plucked)
    errors = (length_error, density_error)
    if fitted is None:
        single, one = singles[0], fit_families(prepared, singles[0].families)
        if one is None:
            raise prepared.no_tone
        doubtful = excess(fit=one, family=0, prepared=prepared) > SPLIT_EXCESS
        split = _split(prepared, single.families[0], one) if doubtful and prepared.alike else None
        if split is None or not apart(prepared, split, SPANS):
            overlapping = split.residual < BETTER * one.residual if split else doubtful and not prepared.alike
            span = single.families[0].span
            return of_one_family(prepared, log, drive, span, one, overlapping, plucked, errors)
        fitted = split
    return of_two_families(prepared, log, drive, fitted, label(prepared, fitted, plucked), plucked, errors)


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
    first, second = rivals[:2]
    if plucked is not None:
        index = SPANS.index(plucked)
        rivals = [one for one in rivals if strength(one, index) > LOUDER * strength(one, 1 - index)]
        if len(rivals) == 1:
            return rivals[0]
    raise NotComputed(
        f"{prepared.channel}: two assignments of the partials fit equally well, "
        f"{_assigned(prepared, first)} or {_assigned(prepared, second)}: "
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
        fit = fit_families(prepared, (family, family), _doubled(one.tones, own, share * width))
        if fit is None or abs(fit.tones.scale[1] / fit.tones.scale[0] - 1.0) > 4.0 * width:
            continue
        both = all(loudest in fit.tones.number[fit.tones.family == k] for k in (0, 1))
        if both and (best is None or fit.residual < best.residual):
            best = fit
    return best


def _doubled(tones: Tones, own: NDArray[np.bool_], distance: float) -> Tones:
    """The first family twice, half a distance below and above its place."""
    rest = tones.only(~own)
    first = tones.only(own)
    x = tones.scale[0]
    both = {
        name: np.concatenate([getattr(first, name), getattr(first, name), getattr(rest, name)])
        for name in ("tooth", "number", "decay", "rise")
    }
    zero = np.zeros(first.tooth.size, dtype=np.intp)
    family = np.concatenate([zero, zero + 1, rest.family + 1])
    scale = np.concatenate([[x * (1 - 0.5 * distance), x * (1 + 0.5 * distance)], tones.scale[1:]])
    return replace(tones, family=family, scale=scale, **both)
