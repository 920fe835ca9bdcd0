"""From two fitted families to two tensions with intervals, labelled where there is a way to do so."""

from dataclasses import replace
from math import nan, sqrt

import numpy as np

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.both_answers import BothTensions, FamilyTension
from cabledrive.identification.tension.decaying_tones import TonesFit
from cabledrive.identification.tension.family_fit import partials_of, scale_error
from cabledrive.identification.tension.from_ping import modes_of
from cabledrive.identification.tension.prepared_recording import PreparedRecording
from cabledrive.identification.tension.span_assignment import SPANS, line_widths
from cabledrive.parameters import Drive, NotComputed


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
