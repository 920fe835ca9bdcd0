"""Tension of a span, or of any vibrating string, from its ping: of loops, lines, named spans of routes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot, pi, sqrt

import numpy as np
from scipy import optimize, stats

from cabledrive.identification.estimates import Estimate
from cabledrive.identification.logs.log import Log
from cabledrive.identification.tension import family_fit, recording
from cabledrive.identification.tension.families import proposals
from cabledrive.identification.tension.family_fit import PingTension, SpanTension
from cabledrive.identification.tension.recording import PreparedRecording
from cabledrive.identification.tension.tones import TonesFit
from cabledrive.mechanics.network import statics_of
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.modal import modes
from cabledrive.modal.tuning import section_frequencies
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route import Machine, RoutedDrive

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
TEETH = 16
"""Modes of a span that a peak may belong to."""
ROOM = 0.25
"""Largest relative distance of a mode of a route's span from that of a string between resting ends."""
COUPLED = 1e-3
"""The same from which a finding says that the ends of the span move with it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingedString:
    """A span, or a section of one, as its ping is read."""

    drive: Machine  # its pretension serves as a first guess
    span: str
    modes: Array  # (modes,): its first frequencies as the file has it [Hz]
    # tension [N] at which a mode, by its number from 1, has a frequency [Hz]
    tension_for: Callable[[int, float], float]
    bare: Callable[[float], float]  # tension [N] of a string of this length and mass with a fundamental [Hz]
    remedy: str  # what to do where a second tone is heard beside the first


def tension_of_string(log: Log, string: PingedString, channel: str) -> SpanTension:
    """Tension of a string from one channel of a recording."""
    prepared = recording.prepared_recording(log, string.drive, channel, {string.span: string.modes})
    peaks = prepared.peaks.only(prepared.falling)
    singles, _ = proposals(peaks, prepared.teeth, prepared.factor, sqrt(recording.SEARCHED))
    pings: list[tuple[bool, float, TonesFit]] = []
    for score, families in singles:
        tried = family_fit.fit_families(prepared, families)
        if tried is not None and tried.amplitude[tried.tones.family == 0].max() > prepared.least:
            cost = family_fit.criterion(tried, prepared.interval) - family_fit.MISSING_PRICE * score
            pings.append((_share(tried) < 0.5, cost, tried))
            if _share(tried) > ALONE and np.sum(tried.tones.family == 0) > 2:
                break
    if not pings:
        raise prepared.no_tone
    fit = family_fit.with_silent_partials(prepared, min(pings, key=lambda one: one[:2])[2])
    tones, own = fit.tones, fit.tones.family == 0
    first = float(tones.scale[0] * prepared.factor * string.modes[0])
    recording.require_ping(log.channel(channel), log.interval, first, f"{log.source}: {channel}")
    lowest = int(tones.number[own].min())
    hertz = float(tones.scale[0]) * float(string.modes[lowest - 1])
    value = string.tension_for(lowest, hertz)
    steep = 1e4 * (string.tension_for(lowest, hertz * 1.0001) / value - 1.0)
    bare = string.bare(float(tones.scale[0]) * float(string.modes[0]))
    found = family_fit.family_tension(prepared, fit, 0, string.span, (value, steep, bare))
    clear = float(np.sqrt(np.mean((fit.offset[own] / fit.offset_error[own]) ** 2))) > INCONSISTENT
    apart = found.spread if clear else 0.0
    _require_string(prepared, fit, apart)
    return replace(found, findings=tuple(_findings(string, prepared, fit, apart)))


def _share(fit: TonesFit) -> float:
    """Power of the first family that decays, over all that decays and over that of the family."""
    power, own = fit.amplitude**2, fit.tones.family == 0
    falling = power * fit.decays
    return float(falling[own].sum() / max(falling.sum(), power[own].sum()))


def _require_string(prepared: PreparedRecording, fit: TonesFit, apart: float) -> None:
    """Refuse a knock: one decaying tone alone, or decaying tones that are no partials of one string."""
    if prepared.channel.rpartition("_")[2] not in HEARD and not prepared.channel.startswith("sound"):
        return
    own, words, hertz, decays = fit.tones.family == 0, "", fit.tones.frequency, fit.decays
    second = float(fit.tones.scale[0] * np.sort(next(iter(prepared.teeth.values())))[1])
    falling, standing = own & decays, own & ~decays
    if own.sum() == 1 and second < prepared.band[1]:
        words = f"no string: one tone at {hertz[own][0]:.4g} Hz without partials, as of a knock: pluck the "
        words += "span nearer to an end, or record closer to it"
    elif falling.any() and np.any(hertz[standing] > hertz[falling].min()):
        words = f"the tone at {hertz[standing].max():.4g} Hz does not decay, that at "
        words += f"{hertz[falling].min():.4g} Hz does: hum beside the tones: record without it"
    elif _share(fit) < 0.5 or (own.sum() == 2 and apart > MATCHED):
        heard = ", ".join(f"{f:.4g}" for f in np.sort(hertz[decays | own]))
        words = f"no string: the tones ({heard} Hz) have not the ratios of the span's modes, as of a knock: "
        words += "pluck the span and damp the others"
    if words:
        raise NotComputed(f"{prepared.log.source}: {prepared.channel}: {words}")


def _findings(string: PingedString, prepared: PreparedRecording, fit: TonesFit, apart: float) -> list[str]:
    tones, own, found = fit.tones, fit.tones.family == 0, []
    if own.sum() == 1:
        assumed = f"assumed to be mode {tones.number[own][0]}: an overtone would give a wrong tension"
        found.append(f"from a single partial, {assumed}")
    if not fit.decays[own].all():
        found.append("the ping hardly decays: its frequency holds for its amplitude only")
    if apart > MATCHED:
        cause = "a stiff cable, a load on it, or two vibrating spans"
        found.append(f"partials disagree by {100 * apart:.2g} % of the tension: {cause}")
    first = int(np.argmin(np.where(own, tones.frequency, np.inf)))
    ratio = tones.frequency / tones.frequency[first]
    near = ~own & fit.decays & (ratio > 0.7) & (ratio < 1.4)
    others = near & (fit.amplitude > LOUD * fit.amplitude[first])
    if others.any() and prepared.factor == 1.0:
        loudest = tones.frequency[int(np.argmax(np.where(others, fit.amplitude, 0.0)))]
        beside = f"another tone at {loudest:.4g} Hz beside {tones.frequency[first]:.4g} Hz"
        found.append(f"{beside}: {string.remedy}")
    return [f"{prepared.channel}: {words}" for words in found]


def channels_of(log: Log) -> list[str]:
    """Channels of a recording that can contain a ping, the direct ones first."""
    swings = [c for c in log.channels if c.rpartition("_")[2] in ("position", "velocity", "acceleration")]
    direct = [c for c in swings if "along" not in c.split("_")]  # of a camera: across the cable
    felt = ("sound", "load_angle", "angle", "drive_angle", "tension", "force")
    if found := direct or [name for name in felt if name in log.channels][:1]:
        return found
    raise InputRefused(f"{log.source}: no channel of a ping (has {', '.join(log.channels)}): name one")


def tension_from_ping(log: Log, drive: Machine, *, span: str | None = None, section: int = 0) -> PingTension:
    """Tension of each span from its ping; the drive's is a guess good to a factor of 4.

    ``span``: default: as the channels are called, else the upper one; ``section``: between guided carriages.
    Raises `NotComputed` if no tone is found, or the recording has no onset and decay as a ping has.
    """
    if span is not None and span not in drive.spans:
        more = " and more" if len(drive.spans) > 6 else ""
        known = nearest(span[:80], drive.spans) or f": it has {', '.join(drive.spans[:6])}{more}"
        raise InputRefused(f'span "{span[:80]}" is no span of {drive.name}{known}')
    if isinstance(drive, RoutedDrive):
        if span is None:
            names = ", ".join(drive.spans[:6])
            raise InputRefused(f"--ping: name the span that was plucked with --span, such as {names}")
        if section:
            raise InputRefused("--section is for loops and lines: leave it out")
        return tension_of_route_span(log, drive, span)
    found: dict[str, SpanTension] = {}
    for name in channels_of(log):
        which = span or (name.split("_")[0] if name.split("_")[0] in drive.spans else "upper")
        found[which] = tension_of_string(log, _of_loop(drive, which, section), name)
    return PingTension(spans=found, report=log.report)


def _of_loop(drive: Drive, span: str, section: int) -> PingedString:
    """A section of a span of a loop or a line as its ping is read."""
    return PingedString(
        drive=drive,
        span=span,
        modes=section_modes(drive, span, section),
        tension_for=lambda number, hertz: tensions_for(drive, [(span, section, number, hertz)])[0],
        bare=lambda hertz: bare_tension(drive, hertz),
        remedy="does the other span vibrate? Damp it, or identify both (--span both)",
    )


def bare_tension(drive: Drive, hertz: float) -> float:
    """What the string formula says of a loop's span with a fundamental [Hz]: length and mass alone [N]."""
    return 4.0 * drive.cable.mass_per_length * (drive.span_length * hertz) ** 2


def section_modes(drive: Drive, span: str, section: int, count: int = TEETH) -> Array:
    """First frequencies of a section of a span, shape (count,) [Hz]."""
    chains = [chain for chain in transverse_chains(drive) if chain.stretches[0].span == span]
    if not 0 <= section < len(chains):
        raise InputRefused(f"section {section}: the {span} span has {len(chains)}: count from 0")
    strings = np.array(section_frequencies(chains[section], count)) / (2 * pi)
    if drive.cable.bending_stiffness is None:
        return strings
    part = (chains[section].stretches[0].start, chains[section].stretches[-1].end)
    even = replace(drive, layout=replace(drive.layout, gravity=0.0))
    found, below = list[float](), float(strings[-1])
    while len(found) < count:
        below *= 1.5
        across = [own for own in modes(even, below=below).transverse if own.plane == "w"]
        found = [own.frequency for own in across if own.span == span and own.section == part]
    return np.array(found[:count])


def tensions_for(drive: Drive, wanted: Sequence[tuple[str, int, int, float]]) -> list[float]:
    """Tensions [N] at which certified modes have frequencies, given as span, section, number, [Hz].

    All spans keep their unstretched lengths; between pulleys at a given distance those of the mean tension.
    """
    rigidity, trial, values = drive.cable.axial_rigidity, drive, [drive.cable.pretension] * len(wanted)
    for _ in range(60):
        before, values, cable = values, [], trial.cable
        for span, section, number, hertz in wanted:
            ratio = hertz / float(section_modes(trial, span, section, number)[-1])
            reduced = cable.pretension / (1.0 + cable.prestrain) * ratio**2
            if reduced >= rigidity:
                raise NotComputed(f"no tension makes mode {number} of the {span} span {hertz:.5g} Hz")
            values.append(reduced / (1.0 - reduced / rigidity))
        if np.allclose(values, before, rtol=1e-12, atol=0.0):
            break
        trial = replace(drive, cable=replace(drive.cable, pretension=float(np.mean(values))))
    return values


def tension_of_route_span(log: Log, drive: RoutedDrive, span: str) -> PingTension:
    """Tension of a span of a machine with routes by its ping; its interval covers ratios that change."""
    number = drive.spans.index(span)
    tension = float(statics_of(drive).mean[number])
    string, ratios = _of_route(drive, number, tension)
    found = tension_of_string(log, string, channels_of(log)[0])
    coupled = float(np.abs(ratios - 1.0).max())
    away = abs(found.tension.value / tension - 1.0)
    extra = 2.0 * coupled * away * found.tension.value / float(stats.norm.ppf(0.975))
    words = f"the ends of {found.span} move with it: "
    words += f"its modes are off those of a string between resting ends by up to {100 * coupled:.2g} %"
    findings = (*found.findings, words) if coupled > COUPLED else found.findings
    found = replace(found, tension=family_fit.widened(found.tension, extra), findings=findings)
    return PingTension(spans={span: found}, report=log.report)


def _of_route(drive: RoutedDrive, number: int, tension: float) -> tuple[PingedString, Array]:
    """A span as its ping is read, and its modes over those of a string between resting ends."""
    span = drive.free_spans[number]
    rope, speed = drive.ropes[span.route], drive.route[span.route].speed
    if any(own == number for own, _ in drive.carriage_places):
        raise InputRefused(f"span {span.name} has a carriage on it: its ping is not read; pluck another span")

    def clamped(own: float) -> float:
        """Fundamental between resting ends [Hz], which rises with the tension."""
        wave = rope.wave_speed(own)
        return (wave**2 - speed**2) / wave / (2.0 * span.length)

    first = clamped(tension)
    ratios = _ratios(drive, span.name, first)

    def tension_for(mode: int, hertz: float) -> float:
        wanted, rigidity = hertz / (mode * ratios[mode - 1]), rope.axial_rigidity
        low, high = 1e-12 * rigidity, 0.5 * rigidity
        if not clamped(low) < wanted < clamped(high):
            raise NotComputed(f"no tension of this rope makes its fundamental {wanted:.5g} Hz")
        return float(optimize.brentq(lambda own: clamped(own) - wanted, low, high, rtol=1e-13, xtol=1e-12))

    return PingedString(
        drive=drive,
        span=span.name,
        modes=first * ratios * np.arange(1, ratios.size + 1),
        tension_for=tension_for,
        bare=lambda hertz: rope.density * (2.0 * span.length * hertz) ** 2,
        remedy="does another span vibrate? Damp it",
    ), ratios


def _ratios(drive: RoutedDrive, span: str, first: float) -> Array:
    """Each of the first modes of a span in the plane over that of a string between resting ends."""
    listed = [
        mode.frequency
        for mode in modes(drive, below=(recording.PARTIALS + 0.5) * first).transverse
        if mode.span == span and mode.plane == "w"
    ]
    found = []
    for number in range(1, recording.PARTIALS + 1):
        near = min(listed, key=lambda own: abs(own - number * first), default=np.inf)
        if abs(near / (number * first) - 1.0) > ROOM / number:
            break
        found.append(near / (number * first))
    if not found:
        raise NotComputed(f"span {span} has no first mode of its own near {first:.5g} Hz: pluck another span")
    return np.array(found)


def tensions_of_spans(
    logs: Sequence[Log], drive: Machine, spans: Sequence[str], section: int = 0
) -> list[PingTension]:
    """Tension of each span from its own recording, in order; of one recording the span may be left out."""
    if (len(logs), len(spans)) != (1, 0) and (len(logs) != len(spans) or len(set(spans)) < len(spans)):
        said = f"--ping: {len(logs)} recordings and {len(set(spans))} different spans"
        raise InputRefused(f"{said}: give one --span for each recording, in their order")
    both = zip(logs, spans or (None,), strict=True)
    return [tension_from_ping(log, drive, span=span, section=section) for log, span in both]


def compared(found: Mapping[str, SpanTension]) -> tuple[Estimate, float]:
    """Tension of the first of two spans less that of the second [N], and the same over their mean."""
    a, b = (one.tension for one in list(found.values())[:2])
    error = hypot(a.standard_error, b.standard_error)
    difference = Estimate.of(a.value - b.value, "N", error, hypot(a.high - a.value, b.high - b.value))
    return difference, 2.0 * difference.value / (a.value + b.value)
