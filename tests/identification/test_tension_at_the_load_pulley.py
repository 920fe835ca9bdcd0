"""The load pulley feels its spans: its encoder shows a ping in counts, its load cell both tensions."""

import numpy as np
import pytest

from cabledrive.identification.logs.log import log_of
from cabledrive.identification.tension import tension_from_ping, tensions_from_load_cell
from cabledrive.parameters import NotComputed, load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate


def turning(name, tension, height):
    """Two seconds of a plucked loop, which turns its load pulley."""
    drive = load_drive(name, overrides=[f"cable.pretension={tension}", "cable.transverse_damping=2"])
    plucks = (Pluck(height=height, place=0.4),)
    recording = Recording(rate=2000.0)
    return drive, simulate(
        drive, 2.0, start=Start(plucks=plucks), scheme=Scheme(segments=40), recording=recording
    )


def tension_by_counts(drive, run, phase):
    count = 2 * np.pi / 10_000
    angle = count * np.floor(run.load_angle / count + phase)
    log = log_of(run.time, {"load_angle": angle}, {"load_angle": "rad"})
    return tension_from_ping(log, drive).spans["upper"].tension.value


@pytest.mark.parametrize(
    "name, tension, height, least",
    [
        ("dissertation-2", 5.0, 8e-3, 20),
        ("dissertation-2", 5.0, 5e-3, 20),
        ("dissertation-2", 7.0, 8e-3, 0),
        ("dissertation-3", 7.0, 8e-3, 0),
        ("dissertation-3", 5.0, 8e-3, 0),
    ],
)
def test_counts_of_the_load_pulley_in_twenty_phases(name, tension, height, least, measured):
    """Either no tone or the tension within 1 %; always the tension at 5 N."""
    drive, run = turning(name, tension, height)
    off, refusals = [], []
    for phase in np.arange(20) / 20:
        try:
            off.append(abs(tension_by_counts(drive, run, phase) / tension - 1.0))
        except NotComputed as refusal:
            refusals.append(str(refusal))
    measured(f"{len(off)} of 20 identified" + (f", worst {100 * max(off):.3f} %" if off else ""))
    assert all("no tone" in one for one in refusals), refusals
    assert len(off) >= least, len(off)
    assert max(off, default=0.0) < 0.01, off


def test_the_load_cell_parts_the_combined_tension_by_the_turning_of_its_pulley(measured):
    """A shaken load pulley: T2 - T1 = J2 a / r2, T1 + T2 = F + 2 rho v^2; noise of the cell 0.05 N."""
    drive, rng = load_drive("dissertation-3"), np.random.default_rng(8)
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
    found = tensions_from_load_cell(log_of(time, {"force": force}, {}), load_drive("dissertation-1"))
    assert found.mean_upper[0] == pytest.approx(6.5, abs=0.01)
    assert found.mean_upper[0] == found.mean_lower[0]
    assert "no angle" in found.findings[0]


def test_the_virtual_rig_of_chapter_4_has_a_load_cell():
    """Model 4, 8 s: both spans at 7 N in the mean, parted by J2 a / r2 as the pulley turns."""
    from cabledrive.rig.bench.experiment import Excitation, experiment

    drive = load_drive("dissertation-3", overrides=["sensors.sample_rate=1 kHz"])
    log = experiment(drive, Excitation(duration=8.0), seed=3)
    found = tensions_from_load_cell(log, drive)
    for name in ("upper", "lower"):
        value, low, high = getattr(found, f"mean_{name}")
        assert value == pytest.approx(7.0, abs=0.02), (name, value)
        assert low < 7.0 < high, (name, low, high)
    assert np.std(found.upper - found.lower) > 2.0 * found.deviation
    assert np.std(found.upper + found.lower) < 0.05
