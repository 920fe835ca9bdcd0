"""Tensions of both spans from one recording in which both sound."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.both_answers import BothTensions
from cabledrive.identification.tension.decaying_tones import Tones, TonesFit
from cabledrive.identification.tension.families import Family, Proposal, proposals
from cabledrive.identification.tension.family_fit import MISSING_PRICE, criterion, fit_families
from cabledrive.identification.tension.family_tensions import of_one_family, of_two_families
from cabledrive.identification.tension.from_ping import channels_of, modes_of
from cabledrive.identification.tension.prepared_recording import (
    SEARCHED,
    PreparedRecording,
    prepared_recording,
)
from cabledrive.identification.tension.span_assignment import (
    LOUDER,
    SPANS,
    apart,
    excess,
    has_tone_below,
    label,
    strength,
)
from cabledrive.parameters import Drive, InputRefused, NotComputed

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
