"""Tension of a span, or of any vibrating string, from its ping."""

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
from cabledrive.identification.tension.recording import PARTIALS, PreparedRecording
from cabledrive.identification.tension.tones import TonesFit
from cabledrive.mechanics.chain import Chain, own_chain
from cabledrive.mechanics.network import statics_of
from cabledrive.modal.elements import ACROSS, OUT
from cabledrive.modal.natural import spectrum_of
from cabledrive.modal.spectrum import Spectrum
from cabledrive.modal.tuning import section_frequencies
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import nearest

HEARD = ("sound", "acceleration")
"""Channels that hear a knock on the machine as well as a span."""
SHARED = 0.1
"""Share of the strain energy from which a mode in the plane is one of the span."""
LOUD = 0.3
"""Share of the first partial above which another tone near it is resolved."""
MATCHED = 0.01
"""Relative disagreement of the tensions of partials from which it is a finding, or no string."""
INCONSISTENT = 3.0
"""The same over its standard error."""
ALONE = 0.9
"""Share of the power that decays, from which no other family is tried."""
FAR = 2.0
"""Tension over that of the file, or the reverse, from which a note says so."""
MOST_SHORT = 200.0
"""Length of all spans over that of a part, above which it has too few of the modes of the machine."""
TEETH = 16
"""Modes of a span that a peak may belong to."""
ROOM = 0.25
"""Relative distance of a mode in the plane of the machine from one across it that is more than much."""
COUPLED = 1e-3
"""The same from which a finding says that the ends of the span move, or that it sags."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PingedString:
    """A span, or a section of one, as its ping is read."""

    drive: Machine  # its pretension serves as a first guess
    span: str
    modes: Array  # (modes,): its first frequencies as the file has it [Hz]
    # tension [N] at which a mode, by its number from 1, has a frequency [Hz]
    tension_for: Callable[[int, float], float]
    bare: Callable[[float], float]  # tension [N] of a string of this length and mass with a fundamental [Hz]
    known: float  # tension as the file has it [N]
    raised: float  # by what share of itself bending raises a mode there, at most
    finding: str  # that its modes in the plane of the machine are others

    def tension_of(self, prepared: PreparedRecording, fit: TonesFit, family: int = 0) -> SpanTension:
        """The tension that a family of partials says; its interval covers what bending makes of another."""
        tones = fit.tones
        scale, lowest = float(tones.scale[family]), int(tones.number[tones.family == family].min())
        hertz = scale * float(self.modes[lowest - 1])
        value = self.tension_for(lowest, hertz)
        steep = 1e4 * (self.tension_for(lowest, hertz * 1.0001) / value - 1.0)
        known = value, steep, self.bare(scale * float(self.modes[0]))
        found = family_fit.family_tension(prepared, fit, family, self.span, known)
        extra = 2.0 * self.raised * abs(value - self.known) * value / self.known
        return replace(found, tension=family_fit.widened(found.tension, extra / float(stats.norm.ppf(0.975))))


def tension_of_string(log: Log, string: PingedString, channel: str) -> SpanTension:
    """Tension of a string from one channel of a recording."""
    prepared = recording.prepared_recording(log, string.drive, channel, {string.span: string.modes})
    peaks = prepared.peaks.only(prepared.falling)
    singles, _ = proposals(peaks, prepared.teeth, prepared.factor, sqrt(recording.SEARCHED))
    pings: list[tuple[bool, float, TonesFit, float]] = []
    for score, families in singles:
        tried, octave = family_fit.fit_families(prepared, families), 0.0
        if tried is not None and (common := _common(tried)) > 1:  # those of a string at a higher tension
            octave = string.tension_of(prepared, tried).tension.value
            raised = tuple((span, common * scale) for span, scale in families)
            tried = family_fit.fit_families(prepared, raised)
        if tried is not None and tried.amplitude[tried.tones.family == 0].max() > prepared.least:
            cost = family_fit.criterion(tried, prepared.interval) - family_fit.MISSING_PRICE * score
            pings.append((_share(tried) < 0.5, cost, tried, octave))
            if _share(tried) > ALONE and np.sum(tried.tones.family == 0) > 2:
                break
    if not pings:
        raise prepared.no_tone
    *_, fit, octave = min(pings, key=lambda one: one[:2])
    fit = family_fit.with_silent_partials(prepared, fit)
    own, first = fit.tones.family == 0, float(fit.tones.scale[0] * prepared.factor * string.modes[0])
    recording.require_ping(log.channel(channel), log.interval, first, f"{log.source}: {channel}")
    found = string.tension_of(prepared, fit)
    clear = float(np.sqrt(np.mean((fit.offset[own] / fit.offset_error[own]) ** 2))) > INCONSISTENT
    apart = found.spread if clear else 0.0
    _require_string(prepared, fit, apart)
    findings = _findings(string, prepared, fit, apart)
    if octave > 0.0:
        words = f"of every second or third mode they would say {octave:.4g} N: compare with the rope's sag"
        findings.append(f"{channel}: the partials are taken for modes without gaps; {words}")
    return replace(found, findings=tuple(findings))


def _common(fit: TonesFit) -> int:
    """Largest common divisor of the numbers of several partials of the first family; 1 of one partial."""
    numbers = fit.tones.number[fit.tones.family == 0]
    return int(np.gcd.reduce(numbers)) if numbers.size > 1 else 1


def _share(fit: TonesFit) -> float:
    """Power of a string that decays, its overtones included, over all that decays and over that of it."""
    power, own = fit.amplitude**2, fit.tones.number > 0
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
        both = ", or identify both (--span both)" if len(string.drive.spans) == 2 else ""
        found.append(f"{beside}: does another span vibrate? Damp it{both}")
    found += [string.finding] if string.finding else []
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

    ``span``: default: as the channels are called, else the first of at most two; ``section``: part between
    guided carriages.
    Raises `NotComputed` if no tone is found, or the recording has no onset and decay as a ping has.
    """
    if span is not None and span not in drive.spans:
        more = " and more" if len(drive.spans) > 6 else ""
        known = nearest(span[:80], drive.spans) or f": it has {', '.join(drive.spans[:6])}{more}"
        raise InputRefused(f'span "{span[:80]}" is no span of {drive.name}{known}')
    channels = channels_of(log)
    named = {own: name for name in channels for own in drive.spans if name.startswith(f"{own}_")}
    if span is not None:
        named = {span: named.get(span, channels[0])}
    elif not named and len(drive.spans) > 2:
        names = ", ".join(drive.spans[:6])
        raise InputRefused(f"--ping: name the span that was plucked with --span, such as {names}")
    named = named or {drive.spans[0]: channels[0]}
    found, notes = dict[str, SpanTension](), list(log.report.findings)
    for own, name in named.items():
        string = string_of(drive, own, section)
        found[own] = tension_of_string(log, string, name)
        if not 1.0 / FAR < (value := found[own].tension.value) / string.known < FAR:
            notes.append(f"{own}: {value:.4g} N, the file has {string.known:.4g} N: is it another octave?")
    return PingTension(spans=found, report=replace(log.report, findings=tuple(notes)))


def string_of(drive: Machine | Drive, span: str, section: int = 0) -> PingedString:
    """A span, or its part between guided carriages, as its ping is read: across the plane of the machine."""
    machine = drive.machine
    number = machine.spans.index(span)
    way = machine.free_spans[number]
    rope, speed = machine.ropes[way.route], machine.route[way.route].speed
    own = [(at, machine.carriage[i]) for i, (on, at) in enumerate(machine.carriage_places) if on == number]
    cuts = sorted((0.0, *(at for at, carriage in own if carriage.guided), way.length))
    if not 0 <= section < len(cuts) - 1:
        raise InputRefused(f"section {section}: the {span} span has {len(cuts) - 1}: count from 0")
    start, end = cuts[section], cuts[section + 1]
    loads = sorted((at, carriage.mass) for at, carriage in own if start < at < end)
    if loads and speed:
        raise InputRefused(f"span {span} runs and carries a mass: its ping is not read; pluck another span")
    rest, rigidity = statics_of(machine).stretches[number], rope.axial_rigidity
    places = (0.0, *sorted(at for at, _ in own))
    pieces = [piece for piece, at in zip(rest, places, strict=True) if start <= at < end]
    ends = pieces[0].tensions[0], pieces[-1].tensions[1]
    known, hung = 0.5 * (ends[0] + ends[1]), 0.5 * abs(ends[1] - ends[0])  # of a rope by its weight
    # as the file has the length: between pulleys, or cut and stretched
    strain = (
        (rope.pretension or 0.0) / rigidity if getattr(machine.listed.layout, "span_length", None) else None
    )
    length = (end - start) / (1.0 + (strain or 0.0))

    def strings(tension: float, count: int) -> Array:
        """Frequencies of the limp string between ends at rest, with what hangs on it [Hz]."""
        stretch, wave = 1.0 + tension / rigidity, rope.wave_speed(tension)
        longer = 1.0 if strain is None else stretch / (1.0 + strain)
        if not loads:
            first = (wave**2 - speed**2) / wave / (2.0 * longer * (end - start))
            return first * _heavy_string(count, hung / tension)
        chain = Chain(
            rigidity=tension / stretch,
            density=rope.density,
            lengths=np.diff([start, *(at for at, _ in loads), end]) * longer / stretch,
            masses=np.array([0.0, *(mass for _, mass in loads), 0.0]),
            fixed=(True, True),
        )
        return np.array(section_frequencies(own_chain(chain), count)) / (2.0 * pi)

    first = strings(known, TEETH)
    part, stiff = (start / way.length, end / way.length), np.ones(TEETH)
    if rope.bending_stiffness is not None:
        stiff = _stiffened(machine, span, part, first)

    def tension_for(mode: int, hertz: float) -> float:
        def above(tension: float) -> float:
            """What a stiff rope adds falls with the root of the tension."""
            raised = (stiff[mode - 1] - 1.0) * sqrt(known / tension)
            return float(strings(tension, mode)[-1]) * (1.0 + raised) - hertz

        low, high = 1e-12 * rigidity, 0.5 * rigidity
        if speed:
            low = max(low, (1.0 + 1e-9) * rope.density * speed**2)
        if above(low) > 0.0 or above(high) < 0.0:
            raise NotComputed(f"no tension of this rope makes mode {mode} of the {span} span {hertz:.5g} Hz")
        return float(optimize.brentq(above, low, high, rtol=1e-13, xtol=1e-12))

    return PingedString(
        drive=machine,
        span=span,
        modes=first * stiff,
        tension_for=tension_for,
        bare=lambda hertz: 4.0 * rope.density * (length * hertz) ** 2,
        known=known,
        raised=float(np.abs(stiff - 1.0).max()),
        finding=(
            f"{span}: its modes in the plane of the machine, where its ends may move, were not compared"
            if sum(own.length for own in machine.free_spans) > MOST_SHORT * (end - start)
            else _in_plane(machine, span, (first * stiff)[:PARTIALS])
        ),
    )


def _heavy_string(count: int, share: float) -> Array:
    """First frequencies of a string whose tension falls along it from 1 + ``share`` to 1 - ``share``.

    Over the first where it is 1 all along; by Ritz from half sines.
    """
    number = np.arange(1.0, count + 17.0)
    apart, sums = np.abs(number[:, None] - number), number[:, None] + number
    coupled = sum((1.0 - (-1.0) ** k) / np.maximum(np.pi * k, 1.0) ** 2 for k in (apart, sums))
    stiffness = np.outer(number, number) * (np.eye(number.size) + 2.0 * share * coupled)
    return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(stiffness)[:count], 0.0)))


def _stiffened(drive: Machine, span: str, share: tuple[float, float], strings: Array) -> Array:
    """Each of the first modes of a part of a span, in shares of its length, over that of the limp string."""
    whole = spectrum_of(drive)[0].network
    numbers = [i for i, piece in enumerate(whole.pieces) if piece.span == span]
    parts = [own for own in whole.waves if own.tag in {(i, OUT) for i in numbers}]
    ropes = [own for own in whole.ropes if own.tags[-1] in {(i, OUT) for i in numbers}]
    rows = [row for wave in parts for row in wave.rows] + [row for rope in ropes for row in rope.rows]
    moved = {column for row in rows for column, _ in row}
    fixed = [own for own in whole.fixed if moved & {column for column, _ in own.row}]
    length, top = whole.pieces[numbers[-1]].end, 2.0 * pi * float(strings[-1])
    spectrum = Spectrum(replace(whole, waves=tuple(parts), ropes=tuple(ropes), fixed=tuple(fixed)))
    for _ in range(6):
        top *= 1.5
        listed = [(own.frequency, np.divide(own.section or 0.0, length)) for own in spectrum.below(top)]
        found = [hertz for hertz, section in listed if np.allclose(section, share)]
        if len(found) >= TEETH:
            return np.array(found[:TEETH]) / strings
    raise NotComputed(f"part of the {span} span: no modes of its own are found: pluck another span")


def _in_plane(drive: Machine, span: str, across: Array) -> str:
    """That a span has other modes in the plane of the machine than across it [Hz]; empty where it has not."""
    spectrum, top = spectrum_of(drive)[0], 2.2 * pi * float(across[-1])
    found = [
        mode.frequency
        for mode in spectrum.below(top)
        if mode.plane == "w" and mode.strain_by_span.get((span, ACROSS), 0.0) > SHARED
    ]
    off = float(np.abs(np.append(found, np.inf)[:, None] / across - 1.0).min(axis=0).max())
    if off <= COUPLED:
        return ""
    by = f"by up to {100 * off:.2g} %" if off < ROOM else "by much"
    said = f"in the plane of the machine its ends move or weights act: its modes there are off {by}"
    return f"{span}: {said}; the ping is taken for one across that plane"


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
