"""Tension of a span, or of any vibrating string, from its ping."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension.answers import PingTension, SpanTension
from cabledrive.identification.tension.decaying_tones import TonesFit, require_ping
from cabledrive.identification.tension.families import proposals
from cabledrive.identification.tension.family_fit import (
    MISSING_PRICE,
    criterion,
    fit_families,
    partials_of,
    scale_error,
    with_silent_partials,
)
from cabledrive.identification.tension.prepared_recording import (
    SEARCHED,
    PreparedRecording,
    prepared_recording,
)
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal.tuning import section_frequencies
from cabledrive.parameters import Drive, InputRefused, NotComputed
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
    """A span, or a section of one, as its ping is read."""

    drive: Drive | RoutedDrive  # its pretension serves as a first guess
    span: str
    modes: Array  # (modes,): its first frequencies as the file has it [Hz]
    # tension [N] at which a mode, by its number from 1, has a frequency [Hz]
    tension_for: Callable[[int, float], float]
    bare: Callable[[float], float]  # tension [N] of a string of this length and mass with a fundamental [Hz]
    remedy: str  # what to do where a second tone is heard beside the first


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


TEETH = 16
"""Modes of a span that a peak may belong to."""


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
    chosen = [channel] if channel is not None else channels_of(log)
    found: dict[str, SpanTension] = {}
    for name in chosen:
        log.channel(name)
        which = span or (name.split("_")[0] if name.split("_")[0] in drive.spans else "upper")
        if which not in drive.spans:
            raise InputRefused(f'span "{which}": {drive.name} has {", ".join(drive.spans)}: choose one')
        one = tension_of_string(log, _string(drive, which, section), name)
        extra = sqrt((2.0 * length_error) ** 2 + density_error**2) * one.tension.value
        found[which] = replace(one, tension=widened(one.tension, extra))
    return PingTension(spans=found, report=log.report, drive=drive.name)


def channels_of(log: Log) -> list[str]:
    """Channels of a recording that can contain a ping, the direct ones first."""
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


def _string(drive: Drive, span: str, section: int) -> PingedString:
    """A section of a span of a loop or a line as its ping is read."""
    return PingedString(
        drive=drive,
        span=span,
        modes=section_modes(drive, span, section),
        tension_for=lambda number, hertz: tension_for(drive, span, number, hertz, section),
        bare=lambda hertz: 4.0 * drive.cable.mass_per_length * (drive.span_length * hertz) ** 2,
        remedy="does the other span vibrate? Damp it, or identify both (--span both)",
    )


def section_modes(drive: Drive, span: str, section: int, numbers: int = TEETH) -> Array:
    """First frequencies of a section of a span, shape (numbers,) [Hz]."""
    chains = [chain for chain in transverse_chains(drive) if chain.stretches[0].span == span]
    if not 0 <= section < len(chains):
        raise InputRefused(f"section {section}: the {span} span has {len(chains)}: count from 0")
    return np.array(section_frequencies(chains[section], numbers)) / (2 * pi)


def tension_for(drive: Drive, span: str, number: int, frequency: float, section: int = 0) -> float:
    """Tension at which a certified mode of a span has a frequency.

    ``span``, {"upper", "lower"}; ``number``: which mode, from 1; ``frequency`` [Hz].
    Returns [N].
    Raises `NotComputed` if no tension below the cable's own stiffness gives it.
    """
    trial = drive
    for _ in range(60):
        cable = trial.cable
        mode = float(section_modes(trial, span, section)[number - 1])
        reduced = cable.pretension / (1.0 + cable.prestrain) * (frequency / mode) ** 2
        if reduced >= cable.axial_rigidity:
            raise NotComputed(f"no tension makes mode {number} of the {span} span {frequency:.5g} Hz")
        tension = reduced / (1.0 - reduced / cable.axial_rigidity)
        if abs(tension / cable.pretension - 1.0) < 1e-12:
            return tension
        trial = replace(trial, cable=replace(cable, pretension=tension))
    return tension


def modes_of(drive: Drive, span: str, section: int) -> Array:
    """First frequencies of a section of a span that guided carriages part; one in a single piece has one."""
    parted = any(carriage.guided for carriage in drive.carriages_on(span))
    return section_modes(drive, span, section if parted else 0)
