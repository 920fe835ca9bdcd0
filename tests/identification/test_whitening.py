"""The weight of a residual: white in its band, from the lowest frequency up, at any sample rate."""

import numpy as np
import pytest
from scipy import signal

from cabledrive.identification.whitening import whitened, whitener

BANDWIDTH = 50.0
BANDS = ((0.03, 0.2), (0.2, 0.6), (0.6, 2.0), (2.0, 10.0), (10.0, 35.0))
"""Between the lowest frequencies of a minute and the part of the band that is used [Hz]."""


def residual_of_an_axis(rng, interval, duration=70.0, corner=0.6):
    """Speed under white torque noise, which grows below a corner no more, and an encoder's rounding."""
    count = round(duration / interval)
    kept = np.exp(-2 * np.pi * corner * interval)
    drift = signal.lfilter([interval], [1.0, -kept], rng.normal(size=count) / np.sqrt(interval))
    rounding = np.diff(rng.uniform(-0.5, 0.5, count + 1)) * 2e-3 * np.sqrt(interval)
    low_pass = signal.butter(4, BANDWIDTH, fs=1.0 / interval, output="sos")
    return signal.sosfiltfilt(low_pass, drift + rounding)


def density(row, interval):
    frequency = np.fft.rfftfreq(row.size, interval)
    power = np.abs(np.fft.rfft(row)) ** 2 * 2 * interval / row.size
    return [float(power[(frequency >= low) & (frequency < high)].mean()) for low, high in BANDS]


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
def test_a_weighted_residual_is_white_from_the_lowest_frequency_up(rate):
    """Density 1/Hz within a fifth in every band; unweighted it falls by nearly three decades."""
    rng = np.random.default_rng(31)
    raw, seen = [], []
    for _ in range(12):
        residual = residual_of_an_axis(rng, 1.0 / rate)
        weights = whitener([residual], 1.0 / rate, BANDWIDTH)
        raw.append(density(residual, 1.0 / rate))
        seen.append(density(whitened(residual[:, None], weights)[:, 0], 1.0 / rate))
    level = np.mean(raw, axis=0)
    assert level.max() / level.min() > 300.0, f"observed {level}"
    white = np.mean(seen, axis=0)
    assert np.all(np.abs(white - 1.0) < 0.2), f"observed {white}"
