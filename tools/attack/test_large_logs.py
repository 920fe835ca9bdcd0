"""Logs far larger than memory: read in constant memory, with progress, and ended by an interrupt."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from command import listening

PERIOD = 1 << 18
"""Samples after which the log of these tests repeats itself."""
LARGEST = 2 << 30
CONFIG = '[log]\nsample_rate = "1 kHz"\n'


def period():
    """Torque and angle of one period, whose end is its beginning: rigid, with Coulomb friction."""
    phase = 2 * np.pi * np.arange(PERIOD) / PERIOD
    lines = (97, 311, 577, 1201)  # 0.4 to 4.6 Hz at 1 kHz
    rate = 2 * np.pi * 1000.0 / PERIOD
    angle = sum(np.sin(k * phase + k) / k for k in lines) * 60.0
    speed = sum(np.cos(k * phase + k) for k in lines) * 60.0 * rate
    acceleration = -sum(k * np.sin(k * phase + k) for k in lines) * 60.0 * rate**2
    noise = np.random.default_rng(0).normal(size=PERIOD)
    torque = 2e-3 * acceleration + 3e-3 * speed + 0.02 * np.sign(speed) + 1e-3 * noise
    return torque, angle


def watched(folder, name, seconds):
    """Status after an interrupt, the lines on standard error, and the largest memory on the way [bytes]."""
    (folder / "log.toml").write_text(CONFIG)
    command = [sys.executable, "-m", "cabledrive", "identify", name, "--config", "log.toml", "--no-check"]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(
        command, cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
        preexec_fn=listening,
    )  # fmt: skip
    peaks, began = [], time.monotonic()
    while process.poll() is None and time.monotonic() - began < seconds:
        status = Path(f"/proc/{process.pid}/status").read_text()
        peaks += [1024 * int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")]
        time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    return process.returncode, errors.splitlines(), peaks


def ended_as_asked(status, lines, peaks, measured):
    measured(f"{lines[-2] if len(lines) > 1 else lines}; {max(peaks) / 2**20:.0f} MiB; status {status}")
    assert status == 130, lines
    assert "interrupted" in lines[-1], lines
    progress = [line for line in lines if " rows" in line]
    assert len(progress) >= 3, lines
    assert max(peaks) < LARGEST, peaks
    half = peaks[len(peaks) // 2]
    assert peaks[-1] < 1.2 * half, peaks


@pytest.mark.verify
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_text_log_of_four_gigabytes_is_read_in_constant_memory(tmp_path, measured):
    torque, angle = period()
    rows = "".join(f"{a:.9f},{b:.9f}\n" for a, b in zip(torque, angle, strict=True)).encode()
    with (tmp_path / "log.csv").open("wb") as file:
        file.write(b"torque [N m],angle [rad]\n")
        for _ in range((4 << 30) // len(rows) + 1):
            file.write(rows)
    assert (tmp_path / "log.csv").stat().st_size > 4 << 30
    try:
        ended_as_asked(*watched(tmp_path, "log.csv", 90.0), measured)
    finally:
        (tmp_path / "log.csv").unlink()


@pytest.mark.verify
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_an_hdf5_log_of_a_hundred_gigabytes_is_read_in_constant_memory(tmp_path, measured):
    """Its first period is written; the chunks of the rest are not, and read as zeros."""
    import h5py

    with h5py.File(tmp_path / "log.h5", "w") as file:
        for name, values, unit in zip(("torque", "angle"), period(), ("N m", "rad"), strict=True):
            data = file.create_dataset(name, shape=(6_500_000_000,), chunks=(1 << 18,), dtype="f8")
            data[:PERIOD] = values
            data.attrs["units"] = unit
    ended_as_asked(*watched(tmp_path, "log.h5", 60.0), measured)
