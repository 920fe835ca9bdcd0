"""Tension of a span from its ping: the tones of the plucked span against its certified modes."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import PingTension, SpanTension
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
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal import longitudinal_modes
from cabledrive.modal.tuning import section_frequencies
from cabledrive.parameters import Drive, InputRefused, NotComputed

Array = NDArray[np.float64]

SQUARED = ("angle", "torque", "tension", "force", "current")
"""Channels that measure the stretch of a vibrating span, which has twice its frequency."""
PARTIALS = 6
SEARCHED = 4.0
"""Tensions are searched from the drive's over this to the drive's times this."""
INCONSISTENT = 3.0
NO_TONE = (
    "no tone between {low:.4g} and {high:.4g} Hz: pluck again, or correct the drive's length and tension"
)


def tension_from_ping(
    log: Log,
    drive: Drive,
    *,
    span: str | None = None,
    channel: str | None = None,
    section: int = 0,
    length_error: float = 0.0,
    density_error: float = 0.0,
) -> PingTension:
    """Tension of each span from a recording of its ping.

    A camera or a microphone hears the span itself; an encoder, a torque or a load cell feels its stretch,
    which has twice the frequency. Frequencies are taken at vanishing amplitude where the ping decays.

    Parameters
    ----------
    log : Log
        From `read_ping`, or any other.
    drive : Drive
        Its pretension serves as a first guess, good to a factor of four.
    span : {"upper", "lower"}, optional
        Default: as the channels are called ("upper position"), else the upper one.
    channel : str, optional
        Default: every position, velocity, acceleration or sound; else the load angle or angle.
    section : int, default 0
        Which section of the span was plucked, where guided carriages part it.
    length_error, density_error : float, default 0.0
        Relative standard errors of the file's length and mass per length; the interval grows by them.

    Returns
    -------
    PingTension

    Raises
    ------
    InputRefused
        If channel, span or section are not there.
    NotComputed
        If no tone is found, or the recording has no onset and decay as a ping has.
    """
    chosen = [channel] if channel is not None else _channels(log)
    found: dict[str, SpanTension] = {}
    for name in chosen:
        log.channel(name)
        which = span or (name.split("_")[0] if name.split("_")[0] in drive.spans else "upper")
        if which not in drive.spans:
            raise InputRefused(f'span "{which}": {drive.name} has {", ".join(drive.spans)}: choose one')
        one = _one_span(log, drive, which, name, section)
        extra = sqrt((2.0 * length_error) ** 2 + density_error**2) * one.tension.value
        found[which] = replace(one, tension=_widened(one.tension, extra))
    return PingTension(spans=found, report=log.report, drive=drive.name)


def _channels(log: Log) -> list[str]:
    swings = [c for c in log.channels if c.rpartition("_")[2] in ("position", "velocity", "acceleration")]
    direct = [c for c in swings if "along" not in c.split("_")]  # of a camera: across the cable
    direct = direct or [c for c in log.channels if c == "sound"]
    if direct:
        return direct
    for name in ("load_angle", "angle", "drive_angle", "tension", "force"):
        if name in log.channels:
            return [name]
    raise InputRefused(
        f"{log.source}: no channel that can contain a ping (has {', '.join(log.channels)}): name one"
    )


def _one_span(log: Log, drive: Drive, span: str, channel: str, section: int) -> SpanTension:
    values = log.channel(channel)
    if np.ptp(values) == 0.0:
        raise InputRefused(f"{log.source}: {channel} is constant: record the ping")
    squared = channel.rpartition("_")[2] in SQUARED
    factor = 2.0 if squared else 1.0
    modes = _section_modes(drive, span, section)
    frequency, amplitude = amplitude_spectrum(values, log.interval)
    top = 0.45 * log.sample_rate
    low, high = modes[0] / sqrt(SEARCHED), min(modes[0] * sqrt(SEARCHED), top / factor)
    if low >= high:
        raise InputRefused(
            f"{log.source}: {log.sample_rate:.4g} samples per second are too few for tones about "
            f"{factor * modes[0]:.4g} Hz: record faster"
        )
    if squared:
        amplitude = _without_pulley_modes(frequency, amplitude, drive, top)
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
    found = _tension(drive, span, section, channel, partials, factor)
    peak, apart = partials[0].peak, 6.0 / log.report.duration
    other = other_tone(frequency, amplitude, peak, (0.7 * peak, 1.4 * peak), apart)
    if other is None or squared:
        return found
    words = (
        f"{channel}: another tone at {other:.4g} Hz beside {peak:.4g} Hz: does the other span vibrate? "
        "Damp it, or identify both (--span both)"
    )
    return replace(found, findings=(*found.findings, words))


def _width(ratios: Array, place: int, first: float, duration: float) -> float:
    """Half of the band of a partial [Hz]: away from its neighbours, and no wider than it needs."""
    others = np.concatenate([[0.0], np.delete(ratios, place)])
    spacing = float(np.abs(others - ratios[place]).min())
    share = max(0.04, 8.0 / (duration * first))
    return min(0.3 * spacing, 0.2, share) * first


def _section_modes(drive: Drive, span: str, section: int, numbers: int = PARTIALS) -> Array:
    chains = [chain for chain in transverse_chains(drive) if chain.stretches[0].span == span]
    if not 0 <= section < len(chains):
        raise InputRefused(f"section {section}: the {span} span has {len(chains)}: count from 0")
    return np.array(section_frequencies(chains[section], numbers)) / (2 * pi)


def _without_pulley_modes(frequency: Array, amplitude: Array, drive: Drive, top: float) -> Array:
    """The spectrum without the drive's longitudinal modes, which do not depend on the tension.

    Their second and third harmonics are cut out as well: rounding and stretch make them.
    """
    cleared = amplitude.copy()
    for mode in longitudinal_modes(drive, below=top):
        for harmonic, share in ((1, 0.06), (2, 0.02), (3, 0.02)):
            reach = max(share * harmonic * mode.frequency, 3.0 * (frequency[4] - frequency[0]))
            cleared[np.abs(frequency - harmonic * mode.frequency) < reach] = 0.0
    return cleared


def tension_for(drive: Drive, span: str, number: int, frequency: float, section: int = 0) -> float:
    """Tension at which a certified mode of a span has a frequency.

    ``span``, {"upper", "lower"}; ``number``: which mode, from 1; ``frequency`` [Hz].
    Returns [N].
    Raises `NotComputed` if no tension below the cable's own stiffness gives it.
    """
    trial = drive
    for _ in range(60):
        cable = trial.cable
        mode = float(_section_modes(trial, span, section)[number - 1])
        reduced = cable.pretension / (1.0 + cable.prestrain) * (frequency / mode) ** 2
        if reduced >= cable.axial_rigidity:
            raise NotComputed(f"no tension makes mode {number} of the {span} span {frequency:.5g} Hz")
        tension = reduced / (1.0 - reduced / cable.axial_rigidity)
        if abs(tension / cable.pretension - 1.0) < 1e-12:
            return tension
        trial = replace(trial, cable=replace(cable, pretension=tension))
    return tension


def _tension(
    drive: Drive, span: str, section: int, channel: str, partials: list[Partial], factor: float
) -> SpanTension:
    values = np.array([tension_for(drive, span, p.number, p.frequency / factor, section) for p in partials])
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
    bare = 4.0 * drive.cable.mass_per_length * (drive.span_length * first) ** 2
    findings = []
    if not all(p.decays for p in partials):
        findings.append(f"{channel}: the ping hardly decays: its frequency holds for its amplitude only")
    if freedom and sqrt(chi) > INCONSISTENT and np.ptp(values) > 0.01 * tension:
        findings.append(
            f"{channel}: partials disagree by {100 * np.ptp(values) / tension:.2g} % of the tension: a "
            "stiff cable, a load on it, or two vibrating spans"
        )
    return SpanTension(
        span=span,
        channel=channel,
        tension=estimate,
        bare=bare,
        bias=bare / tension - 1.0,
        spread=float(np.ptp(values)) / tension,
        partials=tuple(partials),
        findings=tuple(findings),
    )


def _widened(estimate: Estimate, extra: float) -> Estimate:
    """An interval with one more independent standard error."""
    if extra == 0.0:
        return estimate
    error = sqrt(estimate.standard_error**2 + extra**2)
    half = (estimate.high - estimate.value) * error / estimate.standard_error
    return replace(estimate, standard_error=error, low=estimate.value - half, high=estimate.value + half)
