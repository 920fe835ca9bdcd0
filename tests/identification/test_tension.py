"""The tension of a span from a ping."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import special
from scipy.io import wavfile
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.identification.logs.log import log_of
from cabledrive.identification.signals import zero_phase
from cabledrive.identification.tension import strings
from cabledrive.identification.tension.both import tension_of_both, tensions_from_load_cell
from cabledrive.identification.tension.family_fit import family_tension
from cabledrive.identification.tension.strings import compared, string_of, tension_from_ping
from cabledrive.identification.tension.tones import Tones, fit_tones
from cabledrive.mechanics.network import statics_of
from cabledrive.parameters import NotComputed
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate
from command import answer, refusal
from network_samples import as_routes
from played_spans import SPANS, carrying, errors, held, played

NOISE = 0.05
BELT_A, BELT_B = "motor a to rear right a", "motor b to rear left b"
LENGTH = next(span.length for span in cd.load_drive("corexy").free_spans if span.name == BELT_A)


def with_tension(name, tension):
    return cd.load_drive(name, overrides=[f"cable.pretension={tension}"]).listed


def rung(drive, seed, *, rate=2000.0, decay=2.0):
    """Two seconds of three modes of the upper span alone, with noise of 5 % of their largest value."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(2.0 * rate)) / rate
    modes = cd.modes(drive, count=40).transverse
    frequencies = [m.frequency for m in modes if m.span == "upper" and m.plane == "v"]
    clean = sum(
        np.exp(-0.5 * decay * time) * np.cos(2 * np.pi * f * time + rng.uniform(0, 6)) / (k + 1) ** 2
        for k, f in enumerate(frequencies[:3])
    )
    return time, clean + NOISE * np.abs(clean).max() * rng.normal(size=time.size)


@pytest.fixture(scope="module")
def exact_ping():
    """One second of the exact loop of configuration 3, plucked by 3 mm."""
    drive = cd.load_drive("dissertation-3").listed
    return drive, simulate(
        drive,
        1.5,
        start=Start(plucks=(Pluck(height=3e-3, place=0.3),)),
        scheme=Scheme(segments=60),
        recording=Recording(rate=2000.0),
    )


@pytest.mark.parametrize("seed", range(12))
def test_ping_of_the_exact_loop_gives_its_tension_within_one_per_cent(exact_ping, seed, measured):
    drive, run = exact_ping
    swing = run.midpoint("upper")[:, 2]
    noisy = swing + NOISE * np.abs(swing).max() * np.random.default_rng(seed).normal(size=swing.size)
    log = log_of(run.time, {"upper_position": noisy}, {"upper_position": "m"})
    guess = replace(drive, cable=replace(drive.cable, pretension=12.0))
    one = tension_from_ping(log, guess).spans["upper"]
    measured(f"{100 * (one.tension.value / 7.0 - 1.0):+.3f} %, bare formula {100 * one.bias:+.1f} %")
    assert one.tension.value == pytest.approx(7.0, rel=0.005), one
    assert one.bias == pytest.approx(-drive.cable.prestrain, abs=0.006), (
        "the bare formula forgets the stretch"
    )


def by_the_string_formula(seed):
    """A ping of one of three belts: four tones, 2 or 6 1/s, noise of 1 to 10 %, hum of 0 or 10 %, 2 s."""
    rng = np.random.default_rng(seed)
    belt, decay, hum = seed % 3, (2.0, 6.0)[seed // 3 % 2], (0.0, 0.1)[seed // 6 % 2]
    if belt == 2:
        drive, tension, length = cd.load_drive("corexy"), rng.uniform(15.0, 60.0), LENGTH
        speed = np.sqrt(tension * (1.0 + tension / 19.4e3) / 8.3e-3)
    else:
        drive = cd.load_drive(
            ("dissertation-3", "dissertation-1")[belt], overrides=["layout.gravity=0"]
        ).listed
        cable, length = drive.cable, drive.span_length
        tension = cable.pretension * rng.uniform(0.5, 2.0)
        speed = np.sqrt(tension / cable.mass_per_length / (1.0 + tension / cable.axial_rigidity))
    time = np.arange(3600) / 1800.0
    sound = sum(
        np.exp(-decay * (1.0 + 0.15 * (k - 1) ** 2) * time)
        * np.cos(np.pi * k * speed / length * time + rng.uniform(0.0, 6.0))
        * rng.uniform(0.5, 1.0)
        / k**1.5
        for k in range(1, 5)
    )
    top = np.abs(sound).max()
    mains = sum(np.cos(100.0 * np.pi * k * time + rng.uniform(0.0, 6.0)) / k for k in (1, 2, 3))
    sound = sound + top * (hum * mains + rng.uniform(0.01, 0.1) * rng.normal(size=time.size))
    return log_of(time, {"sound": sound}, {}), drive, tension


@pytest.mark.parametrize(
    "seeds, low, high",
    [(range(24), 0.85, 1.0), pytest.param(range(400), 0.93, 0.97, marks=pytest.mark.verify)],
)
def test_intervals_of_a_ping_hold_the_tension(seeds, low, high, measured):
    """Noise, hum, two decays, three belts; none is off by 1 %; hum beside a tone that fades is refused."""
    held, refused, worst = 0, 0, 0.0
    for seed in seeds:
        log, drive, tension = by_the_string_formula(seed)
        try:
            if seed % 3 == 2:
                one = tension_from_ping(log, drive, span=BELT_A).spans[BELT_A]
            else:
                one = tension_from_ping(log, drive).spans["upper"]
        except cd.NotComputed:
            refused += 1
            continue
        held += one.tension.low <= tension <= one.tension.high
        worst = max(worst, abs(one.tension.value / tension - 1.0))
    given = len(seeds) - refused
    measured(f"{held} of {given} intervals hold, {refused} refused, worst {100 * worst:.3f} %")
    assert low <= held / given <= high, (held, given)
    assert refused <= 0.05 * len(seeds), refused
    assert worst < 0.01, worst


@pytest.mark.parametrize("seeds", [8, pytest.param(24, marks=pytest.mark.verify)])
def test_an_accelerometer_hears_overtones_as_loud_as_the_first_partials(seeds, measured):
    """Twelve partials of a belt: 8 of 24 tensions were four or nine times too high, 2 refused as knocks."""
    drive, time, errors = cd.load_drive("printer-idlers"), np.arange(24_000) / 24e3, []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        tension, length = 30.0 * rng.uniform(0.8, 1.25), drive.machine.free_spans[0].length
        first = np.sqrt(tension * (1.0 + tension / 19.4e3) / 8.3e-3) / (2.0 * length)
        pluck, place = rng.uniform(0.1, 0.5, 2)
        felt = sum(
            np.sin(np.pi * k * pluck) * np.sin(np.pi * k * place) * np.cos(2.0 * np.pi * k * first * time)
            for k in range(1, 13)
        )
        felt = np.exp(-4.0 * time) * felt + 0.01 * rng.normal(size=time.size)
        one = tension_from_ping(log_of(time, {"acceleration": felt}, {}), drive, span="left clamp to motor")
        errors.append(abs(one["left clamp to motor"] / tension - 1.0))
    measured(f"largest error of {len(errors)}: {100 * max(errors):.3f} %")
    assert max(errors) < 1e-3, errors


def both_felt(seed):
    """A loop's accelerometer, 4 s: 4 to 12 partials of each span, tensions up to a factor of 3 apart."""
    rng = np.random.default_rng(seed)
    drive = cd.load_drive("dissertation-2", overrides=["layout.gravity=0"]).listed
    cable, time = drive.cable, np.arange(8000) / 2000.0
    count, tensions, felt = rng.integers(4, 13), 6.0 * (1.0 + rng.uniform(0.01, 0.5) * np.array([1, -1])), 0.0
    for tension, loudness in zip(tensions, (1.0, rng.uniform(0.15, 1.0)), strict=True):
        first = np.sqrt(tension / cable.mass_per_length / (1.0 + tension / cable.axial_rigidity))
        first, (pluck, place) = first / (2.0 * drive.span_length), rng.uniform(0.08, 0.5, 2)
        felt += loudness * sum(
            np.sin(np.pi * k * pluck) * np.sin(np.pi * k * place) * np.cos(2.0 * np.pi * k * first * time)
            for k in range(1, count + 1)
        )
    felt = np.exp(-time) * felt + rng.choice([0.003, 0.01, 0.05]) * rng.normal(size=time.size)
    return drive, tensions, log_of(time, {"acceleration": felt}, {})


@pytest.mark.parametrize(
    "seeds",
    [(5, 7, 72, 80), pytest.param(range(100), marks=pytest.mark.verify)],
    ids=["four", "hundred"],
)
def test_an_accelerometer_gives_both_tensions_of_a_loop(seeds, measured):
    """Loud overtones, first modes that drown, ratios of 3 to 4: three were wrong by factors above 2.3."""
    worst, noted = [], 0
    for seed in seeds:
        drive, tensions, log = both_felt(seed)
        found = tension_of_both(log, drive).spans
        assert list(found) == ["tauter", "looser"], (seed, list(found))
        worst += [abs(one.tension.value / t - 1.0) for one, t in zip(found.values(), tensions, strict=True)]
        noted += any(one.findings for one in found.values())
    measured(f"largest error of {len(worst)} tensions: {100 * max(worst):.3f} %")
    assert max(worst) < 2e-3, worst
    assert noted <= 0.1 * len(seeds), noted


def test_a_loud_tone_beside_both_families_is_a_finding():
    """A bracket that rings at 83 Hz is no partial of either span: both tensions are given with that tone."""
    drive, _, log = both_felt(5)
    bracket = np.exp(-log.time) * np.sin(2.0 * np.pi * 83.0 * log.time)
    found = tension_of_both(
        log_of(log.time, {"acceleration": log.channel("acceleration") + bracket}, {}), drive
    )
    assert all("83 Hz" in one.findings[-1] for one in found.spans.values()), found.spans


def test_a_hanging_carriage_makes_the_string_formula_wrong_and_the_modes_right(measured):
    """A carriage of the span's own mass hangs at its third: the first mode falls by a third."""
    source = cd.load_drive("dissertation-3").listed
    carriage = {"carriage.0.mass": 1.68e-4, "carriage.0.position": 0.3, "carriage.0.guided": "false"}
    base = cd.load_drive(
        "dissertation-transporter", overrides=[f"{k}={v}" for k, v in carriage.items()]
    ).listed
    drive = replace(base, cable=source.cable)
    time, values = rung(drive, 5)
    one = tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive).spans["upper"]
    off = one.tension.value / 7.0 - 1.0
    measured(f"bare formula {100 * one.bias:+.1f} %, by the modes {100 * off:+.3f} %")
    assert one.tension.value == pytest.approx(7.0, rel=0.01), one
    assert one.bias < -0.3, one.bias


def test_a_rope_that_hangs_gives_the_mean_of_its_tension(measured):
    """Below the car 5.65 to 2.94 kN by its weight, frequencies by Bessel functions; it was 2.7 % too low."""
    drive, section = cd.load_drive("elevator").listed, 1
    high, low = (float(end) for end in statics_of(drive.machine).stretches[0][section].tensions)
    length = drive.machine.free_spans[0].length - drive.machine.carriage_places[0][1]
    slope, density = (high - low) / length, drive.cable.mass_per_length

    def ends(f):
        a, b = (4.0 * np.pi * f * np.sqrt(density * tension) / slope for tension in (high, low))
        return special.j0(a) * special.y0(b) - special.j0(b) * special.y0(a)

    mean = np.sqrt(0.5 * (high + low) / density) / (2.0 * length)
    tones = [brentq(ends, (k - 0.3) * mean, (k + 0.2) * mean) for k in range(1, 5)]
    time = np.arange(12_000) / 50.0
    heard = sum(np.exp(-0.02 * time) * np.cos(2.0 * np.pi * f * time) / (k + 1) for k, f in enumerate(tones))
    noisy = heard + 0.01 * np.random.default_rng(2).normal(size=time.size)
    found = tension_from_ping(log_of(time, {"sound": noisy}, {}), drive, span="upper", section=section)
    off = found["upper"] / (0.5 * (high + low)) - 1.0
    measured(f"mean {100 * off:+.3f} %, partials disagree by {100 * found.spans['upper'].spread:.3f} %")
    assert abs(off) < 1.5e-3, off  # of which 0.9e-3: a loop is cut, its length follows the tension
    assert found.spans["upper"].spread < 1e-3


def test_ping_of_a_stiff_belt_gives_its_tension(measured):
    """Partials of a beam clamped where its curvature has grown to that of the pulley, sqrt(EI/T) beyond L."""
    base = cd.load_drive("printer-belt").listed
    length, tension, share = base.pulley_distance, base.cable.pretension, 2e-3
    cable = replace(base.cable, bending_stiffness=share * tension * length**2)
    pulley = tuple(replace(own, radius=0.2 * length) for own in base.pulley)
    drive = replace(base, carriage=(), cable=cable, pulley=pulley)
    first = base.cable.transverse_wave_speed / (2.0 * length)

    def clamped(f):
        """Characteristic equation of a tensioned beam over cosh; in frequency and length of the string."""
        long, steep = 1.0 + 2.0 * np.sqrt(share), 0.5 / share
        root = np.sqrt(steep**2 + (np.pi * f) ** 2 / share)
        a, b = np.sqrt(root + steep), np.sqrt(root - steep)
        left = (a**2 - b**2) * np.tanh(a * long) * np.sin(b * long)
        return left + 2.0 * a * b * (1.0 / np.cosh(a * long) - np.cos(b * long))

    partials = [first * brentq(clamped, k - 0.3, k + 0.4) for k in (1, 2, 3)]
    time, rng = np.arange(16000) / (32.0 * first), np.random.default_rng(3)
    tones = [np.cos(2 * np.pi * f * time + k) / k**2 for k, f in enumerate(partials, start=1)]
    clean = np.exp(-0.02 * first * time) * np.sum(tones, axis=0)
    values = clean + NOISE * np.abs(clean).max() * rng.normal(size=time.size)
    one = tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive).spans["upper"]
    measured(f"{100 * (one.tension.value / tension - 1.0):+.3f} %")
    assert one.tension.value == pytest.approx(tension, rel=2e-3), one


@pytest.mark.parametrize("content", [b"", b"RIFF\x00\x00\x00\x00WAVEfmt ", b"no sound at all" * 9])
def test_a_corrupt_sound_file_is_refused_in_one_line(tmp_path, content):
    (tmp_path / "ping.wav").write_bytes(content)
    assert "ping.wav" in refusal("identify", tmp_path / "ping.wav", "--ping", "elevator")


@pytest.mark.parametrize(
    "name, section", [("dissertation-transporter", 1), ("elevator", 0), ("camera-line", 0), ("ropeway", 0)]
)
def test_pings_of_other_machines_and_sections_give_their_tension(name, section):
    """Guided carriages part a span, hanging ones load it: each section by its own certified modes."""
    from cabledrive.mechanics.spans import transverse_chains
    from cabledrive.modal.tuning import section_frequencies

    drive, rng = cd.load_drive(name).listed, np.random.default_rng(section)
    chains = [chain for chain in transverse_chains(drive) if chain.stretches[0].span == "upper"]
    f = np.array(section_frequencies(chains[section], 3)) / (2 * np.pi)
    rate = max(20.0 * f[0], 12.0 * f[2])
    time = np.arange(round(60.0 * rate / f[0])) / rate
    tones = [np.sin(2 * np.pi * one * time + rng.uniform(0, 6)) / k**2 for k, one in enumerate(f, start=1)]
    swing = np.exp(-time * f[0] / 15.0) * np.sum(tones, axis=0)
    swing += NOISE * np.abs(swing).max() * rng.normal(size=time.size)
    guess = replace(drive, cable=replace(drive.cable, pretension=1.7 * drive.cable.pretension))
    log = log_of(time, {"position": swing}, {"position": "m"})
    one = tension_from_ping(log, guess, section=section).spans["upper"]
    assert one.tension.value == pytest.approx(drive.cable.pretension, rel=0.01), one
    routed = as_routes(guess)
    (again,) = tension_from_ping(log, routed, span=routed.spans[0], section=section).spans.values()
    assert again.tension.value == pytest.approx(one.tension.value, rel=3.0 * guess.cable.prestrain), again


@pytest.mark.parametrize("stiff", [None, 2e-3])
@pytest.mark.parametrize("name", ["dissertation-3", "printer-belt", "camera-line"])
def test_the_modes_of_a_span_do_not_depend_on_how_its_machine_is_written(name, stiff, measured):
    """Stiff ropes alone: parts between guided carriages of routes have no modes of their own names."""
    drive = cd.load_drive(name).listed
    if stiff is not None:
        bending = stiff * drive.cable.pretension * drive.pulley_distance**2
        drive = replace(drive, carriage=(), cable=replace(drive.cable, bending_stiffness=bending))
    routed = as_routes(drive)
    for span, called in zip(drive.spans, routed.spans, strict=True):
        one, other = string_of(drive, span).modes, string_of(routed, called).modes
        off = float(np.abs(other / one - 1.0).max())
        measured(f"{span}: {off:.1e}")
        apart = abs(string_of(drive, span).known / drive.cable.pretension - 1.0) * drive.cable.prestrain
        assert off < apart + 1e-7, (span, off)  # the file's lengths are those at its pretension


def test_a_channel_of_another_span_is_not_read_for_the_named_one():
    """Both spans stand in one log, at 7 N and 8 N; a part has the string formula of its own length."""
    time, upper = rung(with_tension("dissertation-3", 7.0), 1, rate=4000.0)
    _, lower = rung(with_tension("dissertation-3", 8.0), 2, rate=4000.0)
    channels = {"upper_position": upper, "lower_position": lower}
    log, drive = log_of(time, channels, dict.fromkeys(channels, "m")), cd.load_drive("dissertation-3").listed
    for span, tension in (("upper", 7.0), ("lower", 8.0)):
        assert tension_from_ping(log, drive, span=span)[span] == pytest.approx(tension, rel=0.01)
    parted = cd.load_drive("dissertation-transporter").listed
    string = string_of(parted, "upper", 1)
    assert string.bare(string.modes[0]) == pytest.approx(string.known, rel=2.0 * parted.cable.prestrain)


def test_both_spans_of_a_stiff_belt_are_read_from_one_recording():
    """A guided carriage parts one of them: the shorter part is the stiffer one, with other ratios."""
    base = cd.load_drive("printer-belt").listed
    length = base.pulley_distance
    cable = replace(base.cable, bending_stiffness=5e-4 * base.cable.pretension * length**2)
    drive = replace(base, carriage=(cd.Carriage(mass=0.1, position=0.37 * length),), cable=cable)
    found = cd.modes(drive, below=1500.0).transverse
    parts = [[m for m in found if m.span == span and m.plane == "v"] for span in drive.spans]
    tones = [m.frequency for part in parts for m in part if m.section[0] == 0.0][:3]
    tones += [m.frequency for m in parts[1]][:3]
    time, rng = np.arange(32000) / 16e3, np.random.default_rng(0)
    swing = sum(np.cos(2 * np.pi * f * time + i) / (i % 3 + 1) ** 2 for i, f in enumerate(tones))
    swing = np.exp(-5.0 * time) * swing + 0.02 * rng.normal(size=time.size)
    log = log_of(time, {"position": swing}, {"position": "m"})
    for one in tension_of_both(log, drive, plucked="upper").spans.values():
        assert one.tension.value == pytest.approx(base.cable.pretension, rel=2e-3), one


def test_another_span_that_sounds_as_well_is_reported():
    """The lower span at 8 N, half as loud, beside the upper one at 7 N; alone it identifies nothing."""
    time, upper = rung(with_tension("dissertation-3", 7.0), 1, rate=4000.0)
    _, lower = rung(with_tension("dissertation-3", 8.0), 2, rate=4000.0)
    drive = cd.load_drive("dissertation-3").listed
    both = tension_from_ping(log_of(time, {"sound": upper + 0.5 * lower}, {}), drive).spans["upper"]
    assert any("another tone at 108" in finding for finding in both.findings), both.findings
    assert both.tension.value == pytest.approx(7.0, rel=0.01)
    assert tension_from_ping(log_of(time, {"sound": upper}, {}), drive).spans["upper"].findings == ()


def chirp(drive, seconds, rate=2000.0):
    """Constant amplitude through the first tones of a span, as a motor makes that is swept."""
    time = np.arange(round(seconds * rate)) / rate
    first = next(m.frequency for m in cd.modes(drive, count=40).transverse if m.span == "upper")
    low, high = 0.3 * first, 4.0 * first
    return time, np.sin(2 * np.pi * (low * time + 0.5 * (high - low) / seconds * time**2))


@pytest.mark.parametrize("seconds", [5.0, 20.0, 60.0])
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_a_sweep_is_no_ping(seconds, noise, measured):
    drive = cd.load_drive("dissertation-3").listed
    time, values = chirp(drive, seconds)
    values = values + noise * np.random.default_rng(1).normal(size=values.size)
    with pytest.raises(cd.NotComputed) as refused:
        tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive)
    measured(f"sweep of {seconds} s: {str(refused.value)[:60]}")


TIME = np.arange(4000) / 2000.0


def swept_past_its_tone(drive):
    """The span answers the sweep with its resonance, damping ratio 0.01: it swells before it dies away."""
    time, force = chirp(drive, 20.0)
    w = 2 * np.pi * next(m.frequency for m in cd.modes(drive, count=40).transverse if m.span == "upper")
    return time, np.convolve(force, np.exp(-0.01 * w * time) * np.sin(w * time))[: time.size]


def knock(*ratios):
    """One decaying tone, those of a bar with free ends, those of a plate."""
    time = np.arange(4000) / 4000.0
    values = sum(np.exp(-8.0 * time) * np.cos(2 * np.pi * 83.0 * k * time) / k for k in ratios)
    return lambda drive: (time, values + 0.01 * np.random.default_rng(1).normal(size=time.size))


@pytest.mark.parametrize(
    "name, made, words",
    [
        ("dissertation-3", lambda _: (TIME, np.random.default_rng(3).normal(size=TIME.size)), "no tone"),
        ("dissertation-3", swept_past_its_tone, "no ping"),
        ("dissertation-3", lambda drive: rung(drive, 0, decay=0.0), "does not decay"),
        ("elevator", lambda drive: rung(drive, 0), "record longer"),  # its first mode is some Hz
        ("dissertation-3", knock(1.0), "no string"),
        ("dissertation-3", knock(1.0, 2.756, 5.404), "no string"),
        ("dissertation-3", knock(1.0, 1.594, 2.136, 2.296), "no string"),
    ],
)
def test_what_is_no_ping_of_a_string_is_refused(name, made, words, measured):
    drive = cd.load_drive(name).listed
    time, values = made(drive)
    with pytest.raises((cd.NotComputed, cd.InputRefused), match=words) as refused:
        tension_from_ping(log_of(time, {"sound": values}, {}), drive)
    measured(str(refused.value))


@pytest.mark.parametrize("silence", [0.0, 0.1, 1.0])
def test_a_ping_after_a_silence_is_a_ping(silence):
    drive = cd.load_drive("dissertation-3").listed
    time, values = rung(drive, 3)
    quiet = NOISE * np.random.default_rng(4).normal(size=round(silence * 2000.0))
    values = np.concatenate([quiet, values])
    time = np.arange(values.size) / 2000.0
    found = tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive).spans["upper"]
    assert found.tension.value == pytest.approx(7.0, rel=0.01)


# --- Both spans sound in one recording: two families of partials, two tensions, or one line why not
@pytest.mark.parametrize("seed", [10_000, 10_001])
def test_both_tensions_of_the_exact_loop_come_out_within_one_per_cent(seed):
    """Noise 5 %: both values, without labels since the spans have the same modes, and the torque between."""
    one = played(seed)
    found = tension_of_both(one.log, one.drive)
    assert set(found.spans) == {"tauter", "looser"}, found.unidentifiable
    assert max(map(abs, errors(found, one).values())) < 0.002, errors(found, one)
    torque = one.drive.drive_pulley.radius * abs(one.lower - one.upper)
    assert found.standing_torque.value == pytest.approx(torque, rel=0.02)
    assert found.pretension.value == pytest.approx(0.5 * (one.upper + one.lower), rel=0.002)
    assert "same modes" in found.unidentifiable[0]
    assert found.as_dict()["parameters"]["tension_tauter"]["unit"] == "N"


@pytest.mark.parametrize("plucked", SPANS)
def test_the_louder_family_is_that_of_the_span_that_was_plucked_harder(plucked):
    """A positive standing torque makes the upper span looser, whichever was plucked."""
    heights = (2e-3, 0.7e-3) if plucked == "upper" else (0.7e-3, 2e-3)
    one = played(10_010, heights=heights, share=0.1, loudness=(1.0, 1.0))
    found = tension_of_both(one.log, one.drive, plucked=plucked)
    assert list(found.spans) == ["upper", "lower"]
    assert max(map(abs, errors(found, one).values())) < 0.002, errors(found, one)
    assert found.standing_torque.value > 0.0, "upper looser: the torque is positive"


def test_equal_tensions_are_one_family_and_the_line_says_so():
    one = played(10_020, share=0.0, rate=1000.0)
    found = tension_of_both(one.log, one.drive)
    assert not found.identifiable
    assert "one family" in found.unidentifiable[0]
    assert "\n" not in found.unidentifiable[0]
    low, high = found.spans["heard"].tension.low, found.spans["heard"].tension.high
    assert low < one.upper < high, (low, one.upper, high)
    assert np.isnan(found.standing_torque.value)


def test_a_span_that_sounds_alone_is_one_family():
    """With the plucked span named, the tension has its name and its narrow interval."""
    one = played(10_022, heights=(2e-3, 0.0), share=0.15, rate=1000.0)
    found = tension_of_both(one.log, one.drive)
    assert list(found.spans) == ["heard"]
    assert "one family" in found.unidentifiable[0]
    named = tension_of_both(one.log, one.drive, plucked="upper")
    assert named["upper"] == pytest.approx(one.upper, rel=0.002)
    width = [f.high - f.low for f in (named.spans["upper"].tension, found.spans["heard"].tension)]
    assert width[0] < 0.2 * width[1], width


@pytest.mark.parametrize("share", [0.15, 0.0])
def test_a_hanging_carriage_gives_the_labels_by_its_modes(share):
    """No word on what was plucked, at equal tensions too: the ratios of the partials say which span it is."""
    one = played(10_050, drive=carrying(), share=share, probe=0.19)
    found = tension_of_both(one.log, one.drive)
    assert list(found.spans) == ["upper", "lower"]
    assert max(map(abs, errors(found, one).values())) < 0.002, errors(found, one)


def test_beside_a_carrying_span_the_silent_one_is_named():
    one = played(10_051, drive=carrying(), heights=(0.0, 1e-3), probe=0.19)
    found = tension_of_both(one.log, one.drive)
    assert list(found.spans) == ["lower"]
    assert "upper span is not detected" in found.unidentifiable[0]


def test_one_partial_of_each_span_may_be_taken_either_way():
    """Without what lies above 115 Hz one tone is left of each: neither is known to be whose."""
    one = played(10_052, drive=carrying(), pretension=7.0, share=0.1, probe=0.19, noise=0.0)
    low = zero_phase(one.log.channel("sound"), one.log.interval, 115.0, order=8)
    low = low + 0.02 * np.abs(low).max() * np.random.default_rng(1).normal(size=low.size)
    with pytest.raises(cd.NotComputed, match="two assignments") as refusal:
        tension_of_both(log_of(one.log.time, {"sound": low}, {}), one.drive)
    assert "\n" not in str(refusal.value)


def test_overlapping_decaying_tones_are_fitted_without_bias():
    """Two families a third of a line width apart, without noise: factors to 1e-7, decays to 1e-5."""
    time = np.arange(4000) / 2000.0
    tooth = np.array([100.0, 200.0, 300.0])
    scale, decay = (1.0, 1.004), (2.0, 3.0)
    values = sum(
        np.exp(-a * time) * np.cos(2 * np.pi * x * f * time + 1.3 * f * x) / (1 + k)
        for x, a in zip(scale, decay, strict=True)
        for k, f in enumerate(tooth)
    )
    start = Tones(
        family=np.repeat([0, 1], 3),
        tooth=np.tile(tooth, 2),
        number=np.tile([1, 2, 3], 2),
        scale=np.array([0.9995, 1.0045]),
        decay=np.full(6, 2.5),
        rise=np.zeros(6),
    )
    fit = fit_tones(values, 5e-4, start, 2)
    assert fit.tones.scale == pytest.approx(scale, rel=1e-7), fit.tones.scale
    assert fit.tones.decay == pytest.approx(np.repeat(decay, 3), rel=1e-5), fit.tones.decay
    # three partials each four standard errors off: Birge's ratio, and Student's t of two degrees of freedom
    alike, apart = (
        replace(fit, offset=many * fit.offset_error, scale_covariance=1e-6 * np.eye(2)) for many in (0.0, 4.0)
    )
    prepared = SimpleNamespace(interval=5e-4, duration=2.0, channel="sound")
    one, other = (
        family_tension(prepared, each, 0, "upper", (100.0, 2.0, 100.0)).tension for each in (alike, apart)
    )
    wider = (other.high - other.low) / (one.high - one.low)
    assert wider == pytest.approx(np.sqrt(3 * 16 / 2) * 4.3027 / 1.9600, rel=1e-4)


# --- Both spans in fifty recordings of each kind, and in five of the same: errors, intervals, identified
@pytest.mark.verify
def test_fifty_random_recordings_of_both_spans(measured):
    """Every tension within 1 %, nine tenths of the 95 % intervals hold it."""
    worst, inside, identified = 0.0, 0, 0
    for seed in range(20_000, 20_050):
        one = played(seed, duration=3.0, segments=720)
        found = tension_of_both(one.log, one.drive)
        identified += found.identifiable
        inside += held(found, one) if found.identifiable else 0
        worst = max([worst, *map(abs, errors(found, one).values())] if found.identifiable else [worst])
    measured(f"{identified} of 50, worst {100 * worst:.3f} %, {inside} of {2 * identified} intervals hold")
    assert identified >= 48, identified
    assert worst < 0.01, worst
    assert inside >= 0.9 * 2 * identified, (inside, identified)


@pytest.mark.verify
def test_fifty_recordings_of_one_span_are_never_taken_for_two(measured):
    two = 0
    for seed in range(21_000, 21_050):
        heights = np.random.default_rng(seed).permutation([1.5e-3, 0.0])
        one = played(seed, duration=3.0, segments=120, heights=heights)
        two += tension_of_both(one.log, one.drive).identifiable
    measured(f"{two} of 50 taken for two")
    assert two == 0, two


@pytest.mark.verify
def test_fifty_recordings_of_nearly_equal_tensions(measured):
    """Tensions up to 3 % apart: identified within 1 %, or both in the interval that is given instead."""
    worst, missed, identified = 0.0, 0, 0
    for seed in range(22_000, 22_050):
        share = float(np.random.default_rng(seed + 7).uniform(0.0, 0.015))
        one = played(seed, duration=3.0, segments=240, share=share)
        found = tension_of_both(one.log, one.drive)
        identified += found.identifiable
        if found.identifiable:
            worst = max([worst, *map(abs, errors(found, one).values())])
        else:
            prepared = found.spans["heard"].tension
            missed += (
                not prepared.low < min(one.upper, one.lower) <= max(one.upper, one.lower) < prepared.high
            )
    measured(f"{identified} of 50, worst {100 * worst:.3f} %, {missed} of {50 - identified} intervals miss")
    assert worst < 0.01, worst
    assert missed <= 2, missed


# --- The load pulley feels its spans: its encoder shows a ping in counts, its load cell both tensions
@pytest.mark.parametrize("phases", [5, pytest.param(20, marks=pytest.mark.verify)])
@pytest.mark.parametrize(
    "name, tension, height, least",
    [
        ("dissertation-2", 5.0, 8e-3, 1.0),
        ("dissertation-2", 5.0, 5e-3, 1.0),
        ("dissertation-2", 7.0, 8e-3, 0.0),
        ("dissertation-3", 7.0, 8e-3, 0.0),
        ("dissertation-3", 5.0, 8e-3, 0.0),
    ],
)
def test_counts_of_the_load_pulley_in_phases_of_the_count(name, tension, height, least, phases, measured):
    """Either no tone or the tension within 1 %; always the tension at 5 N."""
    drive = cd.load_drive(
        name, overrides=[f"cable.pretension={tension}", "cable.transverse_damping=2"]
    ).listed
    start, recording = Start(plucks=(Pluck(height=height, place=0.4),)), Recording(rate=2000.0)
    run = simulate(drive, 2.0, start=start, scheme=Scheme(segments=40), recording=recording)
    off, refusals, count = [], [], 2 * np.pi / 10_000
    for phase in np.arange(phases) / phases:
        angle = count * np.floor(run.load_angle / count + phase)
        log = log_of(run.time, {"load_angle": angle}, {"load_angle": "rad"})
        try:
            off.append(abs(tension_from_ping(log, drive)["upper"] / tension - 1.0))
        except cd.NotComputed as refusal:
            refusals.append(str(refusal))
    measured(f"{len(off)} of {phases} identified" + (f", worst {100 * max(off):.3f} %" if off else ""))
    assert all("no tone" in one for one in refusals), refusals
    assert len(off) >= least * phases, len(off)
    assert max(off, default=0.0) < 0.01, off


def test_the_load_cell_parts_the_combined_tension_by_the_turning_of_its_pulley(measured):
    """A shaken load pulley: T2 - T1 = J2 a / r2, T1 + T2 = F + 2 rho v^2; noise of the cell 0.05 N."""
    drive, rng = cd.load_drive("dissertation-3").listed, np.random.default_rng(8)
    time = np.arange(20_000) / 1000.0
    swing, omega = 0.3, 2 * np.pi * 3.0
    angle = swing * np.sin(omega * time)
    half = 0.5 * 0.00235 * (-(omega**2)) * angle / 0.04
    rim = 0.04 * swing * omega * np.cos(omega * time)
    density = 0.168e-3 / (1.0 + drive.cable.prestrain)
    force = 2 * 7.0 - 2 * density * rim**2 + 0.4 + 0.05 * rng.normal(size=time.size)
    count = 2 * np.pi / 10_000
    channels = {"force": force, "load_angle": count * np.floor(angle / count)}
    found = tensions_from_load_cell(log_of(time, channels, {}), drive, zero=0.4)
    inside = np.searchsorted(time, found.time)
    for name, exact in (("upper", 7.0 - half), ("lower", 7.0 + half)):
        error = getattr(found, name) - exact[inside]
        ratio = np.sqrt(np.mean(error**2)) / found.deviation
        measured(
            f"{name}: {ratio:.2f} times the stated {found.deviation:.3f} N, apart by {np.ptp(half):.1f} N"
        )
        assert np.sqrt(np.mean(error**2)) < 1.5 * found.deviation, (name, error.std(), found.deviation)
        low, high = getattr(found, f"mean_{name}")[1:]
        assert low - 0.01 < 7.0 < high + 0.01
    assert np.ptp(half) > 5.0, "the two tensions differ by much more than the noise"


def test_a_load_cell_without_angle_halves_its_reading_and_says_so():
    time = np.arange(5000) / 1000.0
    force = 13.0 + 0.05 * np.random.default_rng(1).normal(size=time.size)
    found = tensions_from_load_cell(
        log_of(time, {"force": force}, {}), cd.load_drive("dissertation-1").listed
    )
    assert found.mean_upper[0] == pytest.approx(6.5, abs=0.01)
    assert found.mean_upper[0] == found.mean_lower[0]
    assert "no angle" in found.findings[0]


# --- A ping tells the tension of a named span of a machine with routes, and two pings compare two belts
def ring(tension, seed):
    """Two seconds of three decaying tones of the string formula, with noise, and the time."""
    rng = np.random.default_rng(seed)
    time = np.arange(8000) / 4000.0
    first = np.sqrt(tension * (1.0 + tension / 19.4e3) / 8.3e-3) / (2.0 * LENGTH)
    tones = [np.exp(-2.0 * time) * np.cos(2 * np.pi * k * first * time + k) / k**2 for k in (1, 2, 3)]
    clean = np.sum(tones, axis=0)
    return time, clean + 0.03 * np.abs(clean).max() * rng.normal(size=time.size)


def test_two_belts_are_compared_with_an_interval():
    drive = cd.load_drive("corexy")
    found = {
        span: tension_from_ping(log_of(time, {"sound": sound}, {}), drive, span=span).spans[span]
        for span, (time, sound) in ((BELT_A, ring(30.0, 0)), (BELT_B, ring(26.0, 1)))
    }
    apart, relative = compared(found)
    assert 0.0 < apart.low < 4.0 < apart.high
    assert relative == pytest.approx(4.0 / 28.0, rel=0.02)


def test_the_command_names_spans_and_refuses_in_one_line(tmp_path):
    """Two belts of one tension do not differ; the spans of a loop do by what they were given."""
    files = []
    for name, tension in (("a.wav", 30.0), ("b.wav", 30.0), ("c.wav", 26.0)):
        _, sound = ring(tension, 7)
        path = tmp_path / name
        wavfile.write(path, 4000, np.round(2e4 * sound / np.abs(sound).max()).astype(np.int16))
        files.append(str(path))
    asked = ["--ping", "corexy", "--span", BELT_A, "--span", BELT_B]
    found = answer("identify", *files[:2], *asked)
    assert found["comparison"]["relative"] == pytest.approx(0.0, abs=1e-4)  # spans of 0.42 m to 5e-5
    assert not found["comparison"]["differ"]
    assert "no span of" in refusal("identify", files[0], "--ping", "corexy", "--span", "motor a to nowhere")
    assert "name the span" in refusal("identify", files[0], "--ping", "corexy")
    assert "one --span for each" in refusal("identify", files[0], *asked)
    belt = cd.load_drive("printer-belt").listed
    layout = replace(belt.layout, span_length=None, pulley_distance=LENGTH)
    cd.save_drive(replace(belt, carriage=(), layout=layout), tmp_path / "loop.toml")
    asked = ["--ping", tmp_path / "loop.toml", "--span", "upper", "--span", "lower"]
    found = answer("identify", files[0], files[2], *asked)
    assert found["comparison"]["relative"] == pytest.approx(4.0 / 28.0, rel=1e-3)
    assert 'mean "upper"' in refusal("identify", files[0], "--ping", "elevator", "--span", "uper")


def tones(*rows, seconds=2.0, rate=16_000.0, floor=0.0):
    """Decaying tones (frequency, amplitude, decay) from 0.1 s on, as a log."""
    time = np.arange(round(seconds * rate)) / rate
    on = np.maximum(time - 0.1, 0.0)
    made = sum(a * np.exp(-d * on) * np.sin(2 * np.pi * f * on) for f, a, d in rows)
    noise = floor * np.random.default_rng(1).normal(size=time.size)
    return log_of(time, {"sound": made + noise}, {"sound": "full scale"})


@pytest.mark.parametrize("hertz", [120.0, 180.0, 250.0, 330.0])
def test_one_tone_on_a_silent_floor_is_a_knock(hertz):
    with pytest.raises(NotComputed, match=r"no string|no tone"):
        tension_from_ping(tones((hertz, 1.0, 25.0)), cd.load_drive("dissertation-3").listed, span="upper")


def test_a_common_divisor_of_the_partials_is_that_of_their_numbers():
    made = [
        Tones(
            family=np.zeros(2, int),
            tooth=np.ones(2),
            number=np.array(n),
            scale=np.ones(1),
            decay=np.ones(2),
            rise=np.zeros(2),
        )
        for n in ((2, 4), (2, 3))
    ]
    assert [strings._common(SimpleNamespace(tones=one)) for one in made] == [2, 1]


def test_partials_2_4_and_6_are_no_octave_below_in_silence():
    """Two planes of a string, whose pairs beat: a weak tone between makes a lower family look complete."""
    drive = cd.load_drive("dissertation-3").listed
    first = string_of(drive, "upper").modes[0]
    rows = [(n * first * k, 1.0 / n, 3.0) for n in (1, 2, 3) for k in (1.0, 1.004)]
    found = tension_from_ping(tones(*rows, floor=1e-3), drive, span="upper").spans["upper"]
    assert found.tension.value == pytest.approx(string_of(drive, "upper").known, rel=0.02) or found.findings


def test_a_tension_far_from_that_of_the_file_is_noted():
    drive = cd.load_drive("dissertation-3").listed
    rows = [(n * string_of(drive, "upper").modes[0] * 2.5**0.5, 1.0 / n, 3.0) for n in (1, 2, 3, 4)]
    found = tension_from_ping(tones(*rows, floor=1e-3), drive, span="upper")
    assert found.spans["upper"].findings == ()
    assert "is it another octave?" in found.report.findings[-1]


def test_a_sound_with_samples_that_are_no_numbers_is_refused(tmp_path):
    values = np.full(8000, np.nan, dtype=np.float32)
    wavfile.write(tmp_path / "ping.wav", 8000, values)
    said = refusal("identify", tmp_path / "ping.wav", "--ping", "dissertation-3")
    assert "8000 samples are no numbers" in said
