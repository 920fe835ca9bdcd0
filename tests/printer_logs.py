"""Logs of a printer whose modes are known, tested as Klipper's firmware does, in the files that it writes.

Nothing here shares code with what is tested: modes are integrated sample by sample, the spectrum is made by a
discrete Fourier transform of each window.
"""

import numpy as np
from scipy import signal

RATE = 1600.0
"""Samples per second; the sensor's own 3200 add nothing below 200 Hz."""


def excitation(start=8.0, end=132.0, rate=2.0, per_hertz=75.0):
    """Time [s] and acceleration [mm/s^2] of a sweep of pulses that grow with the frequency."""
    time = np.arange(int((end - start) / rate * RATE)) / RATE
    frequency = start + rate * time
    phase = 2 * np.pi * (start * time + rate * time**2 / 2)
    return time, per_hertz * frequency * np.sign(np.sin(phase))


def head(drive, modes):
    """Acceleration of the head; modes as (frequency [Hz], damping ratio, share)."""
    total = np.zeros_like(drive)
    for frequency, damping, share in modes:
        omega = 2 * np.pi * frequency
        system = ([2 * damping * omega, omega**2], [1.0, 2 * damping * omega, omega**2])
        numerator, denominator, _ = signal.cont2discrete(system, 1 / RATE, "foh")
        total += share * signal.lfilter(numerator.ravel(), denominator, drive)
    return total


def samples(modes, rng, noise=300.0, **sweep):
    """Rows of time, accel_x, accel_y, accel_z, the x axis excited."""
    time, drive = excitation(**sweep)
    table = noise * rng.standard_normal((time.size, 4))
    table[:, 0] = 1234.5 + time
    table[:, 1] += head(drive, modes)
    table[:, 3] += 9810.0
    return table


def densities(table):
    """Frequency and power spectral densities x, y, z, window by window."""
    length = 1 << int(RATE * 0.5 - 1).bit_length()
    window = np.kaiser(length, 6.0)
    found = []
    for column in table[:, 1:].T:
        power = [
            np.abs(np.fft.rfft(window * (part - part.mean()))) ** 2
            for part in (column[k : k + length] for k in range(0, column.size - length + 1, length // 2))
        ]
        found.append(2.0 * np.mean(power, axis=0) / (RATE * np.sum(window**2)))
    return np.fft.rfftfreq(length, 1 / RATE), np.array(found)


def write_samples(path, table):
    np.savetxt(path, table, delimiter=",", fmt="%.6f", header="time,accel_x,accel_y,accel_z", comments="#")
    return path


def write_densities(path, table, shapers=()):
    """As TEST_RESONANCES writes them; with shapers, normalised, as SHAPER_CALIBRATE does."""
    frequency, parts = densities(table)
    if shapers:
        parts = parts / (frequency + 0.1)
        parts[:, frequency < 10.0] *= np.exp(1.0 - (10.0 / (frequency[frequency < 10.0] + 0.1)) ** 2)
    head = "freq,psd_x,psd_y,psd_z,psd_xyz" + (",shapers:," + ",".join(shapers) if shapers else "")
    lines = [head]
    for f, *row in zip(frequency, *parts, parts.sum(axis=0), strict=True):
        if f >= 200.0:
            break
        cells = [f"{f:.1f}", *(f"{value:.3e}" for value in row)]
        lines.append(",".join(cells + (["", *["0.500"] * len(shapers)] if shapers else [])))
    path.write_text("\n".join(lines) + "\n")
    return path
