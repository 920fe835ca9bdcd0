"""The tension of a span from a ping."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.io import wavfile

from cabledrive.identification.logs.log import log_of
from cabledrive.identification.tension import read_ping, read_wav, tension_from_ping
from cabledrive.identification.tension.from_ping import tension_for
from cabledrive.modal import modes
from cabledrive.parameters import InputRefused, NotComputed, load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate

NOISE = 0.05


def with_tension(name, tension):
    return load_drive(name, overrides=[f"cable.pretension={tension}"])


def rung(drive, seed, *, duration=2.0, rate=2000.0, decay=2.0, span="upper", partials=3):
    """A ping by its modes alone, with noise of 5 % of its largest value; the drive's own guess is off."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(duration * rate)) / rate
    frequencies = [
        m.frequency for m in modes(drive, count=40).transverse if m.span == span and m.plane == "v"
    ]
    clean = sum(
        np.exp(-0.5 * decay * time) * np.cos(2 * np.pi * f * time + rng.uniform(0, 6)) / (k + 1) ** 2
        for k, f in enumerate(frequencies[:partials])
    )
    return time, clean + NOISE * np.abs(clean).max() * rng.normal(size=time.size)


@pytest.fixture(scope="module")
def exact_ping():
    """One second of the exact loop of configuration 3, plucked by 3 mm."""
    drive = load_drive("dissertation-3")
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


def pinged(seeds):
    """How many 95 % intervals hold the tension, 2 to 12 N, and the largest relative error."""
    held, worst = 0, 0.0
    for seed in seeds:
        tension = float(np.random.default_rng(seed).uniform(2.0, 12.0))
        drive = with_tension("dissertation-3", tension)
        time, values = rung(drive, seed)
        one = tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive).spans["upper"]
        held += one.tension.low <= tension <= one.tension.high
        worst = max(worst, abs(one.tension.value / tension - 1.0))
    return held, worst


@pytest.mark.verify
def test_intervals_of_a_ping_hold_the_tension(measured):
    """200 pings by their modes: the 95 % interval holds at least nine tenths of them, none is off by 1 %."""
    held, worst = pinged(range(200))
    measured(f"{held} of 200 intervals hold, worst {100 * worst:.3f} %")
    assert held >= 180, held
    assert worst < 0.01, worst


def test_a_hanging_carriage_makes_the_string_formula_wrong_and_the_modes_right(measured):
    """A carriage of the span's own mass hangs at its third: the first mode falls by a third."""
    source = load_drive("dissertation-3")
    carriage = {"carriage.0.mass": 1.68e-4, "carriage.0.position": 0.3, "carriage.0.guided": "false"}
    base = load_drive("dissertation-transporter", overrides=[f"{k}={v}" for k, v in carriage.items()])
    drive = replace(base, cable=source.cable)
    time, values = rung(drive, 5)
    one = tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive).spans["upper"]
    off = one.tension.value / 7.0 - 1.0
    measured(f"bare formula {100 * one.bias:+.1f} %, by the modes {100 * off:+.3f} %")
    assert one.tension.value == pytest.approx(7.0, rel=0.01), one
    assert one.bias < -0.3, one.bias


def test_tension_is_the_inverse_of_the_certified_modes():
    drive = with_tension("dissertation-3", 9.0)
    drive = replace(drive, layout=replace(drive.layout, gravity=0.0))
    first = next(m.frequency for m in modes(drive, count=8).transverse if m.span == "lower")
    assert tension_for(load_drive("dissertation-3"), "lower", 1, first) == pytest.approx(9.0, rel=1e-10)


def test_both_spans_of_a_log_are_assigned_by_their_names():
    upper, lower = with_tension("dissertation-3", 7.5), with_tension("dissertation-3", 6.5)
    time, high = rung(upper, 1)
    _, low = rung(lower, 2)
    log = log_of(time, {"upper_position": high, "lower_position": low}, {})
    found = tension_from_ping(log, load_drive("dissertation-3"))
    assert found["upper"] == pytest.approx(7.5, rel=0.01)
    assert found["lower"] == pytest.approx(6.5, rel=0.01)
    assert found.as_dict()["parameters"]["tension_lower"]["unit"] == "N"


def test_noise_alone_has_no_tension():
    time = np.arange(4000) / 2000.0
    log = log_of(time, {"position": np.random.default_rng(3).normal(size=time.size)}, {"position": "m"})
    with pytest.raises(NotComputed, match="no tone"):
        tension_from_ping(log, load_drive("dissertation-3"))


@pytest.mark.parametrize("kind", ["int16", "float32", "uint8"])
def test_a_sound_file_is_a_log(tmp_path, kind):
    _, values = rung(load_drive("dissertation-3"), 4, rate=8000.0)
    loud = 0.5 * values / np.abs(values).max()
    stored = {"int16": loud * 32767, "float32": loud, "uint8": 128 + 127 * loud}[kind].astype(kind)
    wavfile.write(tmp_path / "ping.wav", 8000, stored)
    log = read_ping(tmp_path / "ping.wav")
    assert log.sample_rate == pytest.approx(8000.0, rel=1e-6)
    assert np.abs(log.channel("sound") - loud).max() < 0.02
    assert tension_from_ping(log, load_drive("dissertation-3"))["upper"] == pytest.approx(7.0, rel=0.01)


@pytest.mark.parametrize("content", [b"", b"RIFF\x00\x00\x00\x00WAVEfmt ", b"no sound at all" * 9])
def test_a_corrupt_sound_file_is_refused_in_one_line(tmp_path, content):
    (tmp_path / "ping.wav").write_bytes(content)
    with pytest.raises(InputRefused, match=r"ping\.wav") as refusal:
        read_wav(tmp_path / "ping.wav")
    assert "\n" not in str(refusal.value)


def test_a_clipped_recording_is_reported(tmp_path):
    _, values = rung(load_drive("dissertation-3"), 4, rate=8000.0)
    wavfile.write(tmp_path / "ping.wav", 8000, (np.clip(3 * values, -1, 1) * 32767).astype("int16"))
    assert "clipped" in read_wav(tmp_path / "ping.wav").report.findings[0]


@pytest.mark.parametrize(
    "name, section", [("dissertation-transporter", 1), ("elevator", 0), ("camera-line", 0), ("ropeway", 0)]
)
def test_pings_of_other_machines_and_sections_give_their_tension(name, section):
    """Guided carriages part a span, hanging ones load it: each section by its own certified modes."""
    from cabledrive.mechanics.spans import transverse_chains
    from cabledrive.modal.tuning import section_frequencies

    drive, rng = load_drive(name), np.random.default_rng(section)
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


def test_another_span_that_sounds_as_well_is_reported():
    """The lower span at 8 N, half as loud, beside the upper one at 7 N; alone it identifies nothing."""
    time, upper = rung(with_tension("dissertation-3", 7.0), 1, rate=4000.0)
    _, lower = rung(with_tension("dissertation-3", 8.0), 2, rate=4000.0)
    drive = load_drive("dissertation-3")
    both = tension_from_ping(log_of(time, {"sound": upper + 0.5 * lower}, {}), drive).spans["upper"]
    assert any("another tone at 108" in finding for finding in both.findings), both.findings
    assert both.tension.value == pytest.approx(7.0, rel=0.01)
    assert tension_from_ping(log_of(time, {"sound": upper}, {}), drive).spans["upper"].findings == ()


def chirp(drive, seconds, rate=2000.0):
    """Constant amplitude through the first tones of a span, as a motor makes that is swept."""
    time = np.arange(round(seconds * rate)) / rate
    first = next(m.frequency for m in modes(drive, count=40).transverse if m.span == "upper")
    low, high = 0.3 * first, 4.0 * first
    return time, np.sin(2 * np.pi * (low * time + 0.5 * (high - low) / seconds * time**2))


@pytest.mark.parametrize("seconds", [5.0, 20.0, 60.0])
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_a_sweep_is_no_ping(seconds, noise, measured):
    drive = load_drive("dissertation-3")
    time, values = chirp(drive, seconds)
    values = values + noise * np.random.default_rng(1).normal(size=values.size)
    with pytest.raises(NotComputed) as refused:
        tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive)
    measured(f"sweep of {seconds} s: {str(refused.value)[:60]}")


def test_a_sweep_past_the_tone_of_the_span_is_no_ping():
    """The span answers the sweep with its resonance, damping ratio 0.01: it swells before it dies away."""
    drive = load_drive("dissertation-3")
    time, force = chirp(drive, 20.0)
    first = next(m.frequency for m in modes(drive, count=40).transverse if m.span == "upper")
    w = 2 * np.pi * first
    kernel = np.exp(-0.01 * w * time) * np.sin(w * time)
    values = np.convolve(force, kernel)[: time.size]
    with pytest.raises(NotComputed, match="no ping"):
        tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive)


def test_a_hum_is_no_ping():
    drive = load_drive("dissertation-3")
    time, values = rung(drive, 0, decay=0.0)
    with pytest.raises(NotComputed, match="does not decay"):
        tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive)


@pytest.mark.parametrize("silence", [0.0, 0.1, 1.0])
def test_a_ping_after_a_silence_is_a_ping(silence):
    drive = load_drive("dissertation-3")
    time, values = rung(drive, 3)
    quiet = NOISE * np.random.default_rng(4).normal(size=round(silence * 2000.0))
    values = np.concatenate([quiet, values])
    time = np.arange(values.size) / 2000.0
    found = tension_from_ping(log_of(time, {"position": values}, {"position": "m"}), drive).spans["upper"]
    assert found.tension.value == pytest.approx(7.0, rel=0.01)
