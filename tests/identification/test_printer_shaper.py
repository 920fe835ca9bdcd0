"""The shaper of a printer's axis: known modes found again, Klipper's definitions, files of any content."""

import math

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.identification.printer_spectrum import read_printer_spectrum
from cabledrive.identification.spectrum_peaks import spectrum_peaks
from command import answer, call, object_of, refusal
from printer_logs import samples, write_densities, write_samples

MODES = ((48.3, 0.06, 1.0), (83.0, 0.04, 0.5))


@pytest.fixture(scope="module")
def table():
    return samples(MODES, np.random.default_rng(0))


@pytest.fixture(scope="module")
def logs(table, tmp_path_factory):
    """One test in the three kinds of file."""
    folder = tmp_path_factory.mktemp("logs")
    return {
        "samples": write_samples(folder / "raw_data_x_20260102.csv", table),
        "densities": write_densities(folder / "resonances_x_20260102_030405.csv", table),
        "normalised": write_densities(
            folder / "calibration_data_x_20260102.csv", table, ("zv(59.0)", "mzv(48.2)")
        ),
    }


@pytest.mark.parametrize("kind", ["samples", "densities", "normalised"])
def test_two_modes_are_found_within_their_intervals_in_every_kind_of_file(logs, kind):
    spectrum = read_printer_spectrum(logs[kind])
    assert spectrum.axis == "x"
    peaks = spectrum_peaks(spectrum)
    assert len(peaks) == 2, peaks
    for peak, (frequency, damping, _) in zip(peaks, MODES, strict=True):
        assert peak.frequency_low < frequency < peak.frequency_high, peak
        assert peak.damping_low < damping < peak.damping_high, peak
        assert peak.frequency_high - peak.frequency_low < 0.02 * frequency, peak
        assert peak.damping_high < 1.3 * damping, peak


@pytest.mark.parametrize("count", [6, pytest.param(60, marks=pytest.mark.verify)])
def test_modes_lie_within_intervals_of_95_per_cent(tmp_path, count, measured):
    rng = np.random.default_rng(7)
    held = given_ = left_out = 0
    for _ in range(count):
        first = rng.uniform(30.0, 55.0)
        modes = [
            (first, rng.uniform(0.025, 0.1), 1.0),
            (
                first * rng.uniform(1.4, 1.9),
                rng.uniform(0.025, 0.07),
                rng.uniform(0.5, 1) * rng.choice([-1, 1]),
            ),
        ]
        log = write_densities(tmp_path / "resonances_x.csv", samples(modes, rng))
        for peak in spectrum_peaks(read_printer_spectrum(log)):
            frequency, damping, _ = min(modes, key=lambda mode: abs(mode[0] - peak.frequency))
            if peak.damping is None:
                left_out += 1
                continue
            given_ += 2
            held += peak.frequency_low <= frequency <= peak.frequency_high
            held += peak.damping_low <= damping <= peak.damping_high
    measured(f"{count} printers: {held} of {given_} intervals hold, {left_out} peaks without damping ratio")
    assert held >= 0.9 * given_, f"{held} of {given_}"
    assert given_ >= 3 * count, f"{given_} intervals, {left_out} peaks left out"


def one_by_one(shaper, damping, frequency, density):
    """Remaining vibration by its definition, impulse by impulse and line by line."""
    floor = max(density) / 20.0
    kept = whole = 0.0
    for f, s in zip(frequency, density, strict=True):
        omega = 2 * math.pi * f
        sine = cosine = 0.0
        for size, time in zip(shaper.amplitudes, shaper.times, strict=True):
            weight = size * math.exp(-damping * omega * (shaper.times[-1] - time))
            sine += weight * math.sin(omega * math.sqrt(1 - damping**2) * time)
            cosine += weight * math.cos(omega * math.sqrt(1 - damping**2) * time)
        kept += max(math.hypot(sine, cosine) * s - floor, 0.0)
        whole += max(s - floor, 0.0)
    return kept / whole


def test_remaining_vibration_is_that_of_the_definition(logs):
    found = cd.shaper(logs["densities"])
    assert list(found.to_dataframe()["score"]) == [fit.score for fit in found.shapers]
    spectrum = found.spectra[0]
    for fit in found.shapers:
        worst = max(
            one_by_one(fit.shaper, damping, spectrum.frequency, spectrum.density)
            for damping in (0.075, 0.1, 0.15)
        )
        assert fit.vibration == pytest.approx(worst, abs=1e-12), (
            f"{fit.type}: {fit.vibration} against {worst}"
        )


def test_the_recommended_shaper_quiets_the_machine_that_was_measured(table, logs):
    """The machine itself moves with and without the shaper; nothing of the choice is used to judge it."""
    from printer_logs import RATE, head

    shaper = cd.shaper(logs["densities"]).recommended.shaper
    step = np.zeros(int(0.6 * RATE))
    step[:20] = 1.0
    shaped = np.zeros_like(step)
    for size, time in zip(shaper.amplitudes, shaper.times, strict=True):
        whole = int(time * RATE)
        part = time * RATE - whole
        for moved, share in ((whole, 1 - part), (whole + 1, part)):
            shaped[moved:] += size * share * step[: step.size - moved]
    after = int(0.05 * RATE)
    left = np.abs(head(shaped, MODES)[after:]).max() / np.abs(head(step, MODES)[after:]).max()
    assert left < 0.1, f"observed {left:.3f}"


def test_several_places_of_the_head_are_judged_by_the_worst(table, logs, tmp_path):
    moved = samples([(62.0, 0.05, 1.0)], np.random.default_rng(3))
    other = write_densities(tmp_path / "resonances_x_corner.csv", moved)
    both = cd.shaper([logs["densities"], other])
    assert both.spread[0] == pytest.approx(48.3, abs=0.3)
    assert both.spread[1] == pytest.approx(83.0, abs=0.3)
    alone = {fit.type: fit.vibration for fit in cd.shaper(logs["densities"]).shapers}
    assert all(fit.vibration >= alone[fit.type] - 0.02 for fit in both.shapers), alone
    assert not any("one place" in note for note in both.notes)


def test_a_smoothing_that_is_asked_for_is_kept(logs):
    found = answer("shaper", logs["densities"], "--max-smoothing", "0.06 mm", "--corner-speed", "8 mm/s")
    assert all(fit["smoothing"] <= 6e-5 for fit in [*found["shapers"], found["recommended_shaper"]])
    assert "no shaper is smooth within" in refusal("shaper", logs["densities"], "--max-smoothing", "1 nm")


def test_axes_of_logs_are_not_mixed(logs, tmp_path):
    other = tmp_path / "resonances_y_1.csv"
    other.write_text(logs["densities"].read_text())
    assert "logs of the axes x, y" in refusal("shaper", logs["densities"], other)
    message = answer("shaper", other, "--axis", "x")
    assert message["findings"][0]["code"] == "axis-contradicts"
    plain = tmp_path / "log.csv"
    plain.write_text(logs["densities"].read_text())
    unknown = answer("shaper", plain)
    assert (unknown["axis"], unknown["findings"][0]["code"]) == (None, "axis-unknown")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("time,torque\n0,1\n1,2\n2,3\n", "no columns freq and psd_xyz, nor time and accel_x"),
        ("freq,psd_xyz\n" + "".join(f"{k},0\n" for k in range(20)), "no vibration was measured"),
        ("freq,psd_xyz\n" + "".join(f"{k},{1 - k}\n" for k in range(20)), "psd_xyz = -1 must be"),
        ("freq,psd_xyz\n1,1\n2,1\n", "only 2 rows"),
        ("freq,psd_xyz\n" + "".join(f"{k % 5},1\n" for k in range(20)), "does not follow"),
        ("#time,accel_x\n" + "".join(f"{k / 100},1\n" for k in range(20)), "shorter than a window"),
        ("#time,accel_x\n" + "".join(f"{k},1\n" for k in range(20)), "Hz, below"),
        ("#time,accel_x\n" + "".join(f"{k / 100},1\n" for k in range(200)), "no vibration was measured"),
    ],
)
def test_a_file_without_a_spectrum_is_refused(tmp_path, content, words):
    (tmp_path / "a.csv").write_text(content)
    assert words in refusal("shaper", tmp_path / "a.csv")


@pytest.mark.parametrize("interval", [1.5625, 0.5, 0.2])
def test_a_density_made_without_a_window_has_its_damping_ratio_too(tmp_path, interval):
    frequency = np.arange(0.0, 200.0, interval)
    ratio = frequency / 52.0
    density = frequency**2 / ((1 - ratio**2) ** 2 + (0.1 * ratio) ** 2)
    rows = [f"{f:.4f},{s:.4e}" for f, s in zip(frequency, density, strict=True)]
    (tmp_path / "resonances_x.csv").write_text("\n".join(["freq,psd_xyz", *rows]))
    (peak,) = spectrum_peaks(read_printer_spectrum(tmp_path / "resonances_x.csv"))
    assert peak.frequency_low < 52.0 < peak.frequency_high, peak
    assert peak.damping_low < 0.05 < peak.damping_high, peak


@pytest.mark.parametrize(
    ("name", "rows", "code"),
    [("noise", slice(None), "no-peak"), ("sweep", slice(0, 2560), "test-broken-off")],
)
def test_noise_and_a_test_that_broke_off_give_no_lines(tmp_path, name, rows, code):
    modes = [] if name == "noise" else [(48.0, 0.05, 1.0)]
    sweep = {"per_hertz": 0.0} if name == "noise" else {}
    table = samples(modes, np.random.default_rng(3), **sweep)[rows]
    for write in (write_samples, write_densities):
        found = cd.shaper(write(tmp_path / f"{write.__name__}_x.csv", table))
        assert code in [finding.code for finding in found.findings]
        assert (found.configuration, found.refused is None) == ("", False)
    told = call("shaper", str(tmp_path / "write_samples_x.csv"), "--json", "-o", str(tmp_path / "found.json"))
    assert object_of(told.stdout)["recommended"] is None
    assert "recommends no shaper" in refusal(
        "export", str(tmp_path / "found.json"), "--format", "klipper", "-o", str(tmp_path / "lines")
    )


def test_no_shaper_lies_above_the_highest_frequency_of_the_firmware(tmp_path):
    table = samples([(172.0, 0.03, 1.0)], np.random.default_rng(3), end=196.0)
    found = cd.shaper(write_samples(tmp_path / "resonances_x.csv", table))
    assert max(fit.frequency for fit in found.shapers) < 150.0
    assert "peak-above-shapers" in [finding.code for finding in found.findings]
