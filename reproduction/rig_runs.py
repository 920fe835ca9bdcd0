"""Runs of the control laws of chapter 6 on the virtual rig of configuration 3.

Angle, rise and dwell of the printed pulses are lost, so that a printed error in degrees is held against a
chosen pulse; the phases of the print's encoders are not known either.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import load_drive
from cabledrive.reduction.lumped_chain import rim_spring
from cabledrive.rig import Motion, RigOptions, Tracking, track

Array = NDArray[np.float64]
PULSE, LONG = Motion(order=9), Motion(dwell=1.0, order=9)
ENCODER = 0.036
RISES = (0.6, 0.7, 0.8, 0.9, 1.0)
JOINT_BAND = (60.0, 150.0)
MOTION = "pulse of 45 deg in 0.5 s with 0.5 s dwell chosen, the print's is lost"
LAWS = {
    "darc-3": ("6.5.1", "Model 3", 0.17, 2.1),
    "darc-4": ("6.6.1", "Model 4", 0.055, 2.0),
    "backstepping": ("6.7.2", "backstepping", 0.3, 2.1),
}


@cache
def run(
    law: str,
    bandwidth: float | None = None,
    feedback: str = "motor",
    seed: int = 0,
    plant: str | None = None,
) -> Tracking:
    """One run on the rig of configuration 3.

    ``bandwidth`` [Hz]; as printed unless given; ``feedback``, {"motor", "drive"}; ``plant``: Model 4 unless
    given.
    """
    motion = LONG if law in ("darc-1", "darc-2") else PULSE
    options = RigOptions(feedback=feedback)
    return track(
        load_drive("dissertation-3"),
        controller=law,
        bandwidth=bandwidth,
        motion=motion,
        options=options,
        seed=seed,
        plant=plant,
        gains="dissertation",
    )


@cache
def held_frequency() -> float:
    """The load's mode while the law holds the drive pulley, sqrt(beta)/(2 pi).

    Returns [Hz].
    """
    drive = load_drive("dissertation-3")
    stiffness, _ = rim_spring(drive)
    return float(np.sqrt(stiffness * drive.load_pulley.radius**2 / drive.load_pulley.inertia) / (2 * np.pi))


def slower_rise(law: str, wanted: float, seeds: int) -> str:
    """The shortest of some rises at which an error is reached, as the encoder of the load shows it.

    ``wanted`` [deg]; ``seeds``: encoder phases.
    Returns in words.
    """
    for rise in RISES:
        errors = [
            track(
                load_drive("dissertation-3"),
                controller=law,
                motion=replace(PULSE, rise=rise),
                seed=seed,
                gains="dissertation",
            ).summary["encoder_error_deg"]
            for seed in range(seeds)
        ]
        if (median := float(np.median(errors))) <= wanted:
            return f"45 deg in {rise:g} s: {median:.3f} deg on the load's encoder, median of {seeds} phases"
    return f"not reached with any rise up to {RISES[-1]:g} s"


def dwell_spectrum(found: Tracking, inertia: int) -> tuple[Array, Array]:
    """Amplitude spectrum of an angle's error in the last dwell.

    ``inertia``: from the motor; -1 is the load, -2 the drive pulley.
    Returns ``frequency, amplitude``, shape (n,) [Hz], [deg].
    """
    interval = float(found.time[1])
    still = found.time > found.time[-1] - found.summary["motion"]["dwell"]
    signal = np.degrees(found.angles[still, inertia] - found.reference[still])
    window = np.hanning(signal.size)
    size = 8 * signal.size
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - signal.mean()) * window, size)) / window.sum()
    frequency = np.fft.rfftfreq(size, interval)
    kept = (frequency > 2.0) & (frequency < 200.0)
    return np.asarray(frequency[kept], dtype=float), np.asarray(amplitude[kept], dtype=float)


def peak_of(spectrum: tuple[Array, Array], low: float = 2.0, high: float = 200.0) -> tuple[float, float]:
    """Highest peak of a spectrum in a band.

    ``spectrum``: frequency [Hz] and amplitude; ``low``, ``high`` [Hz].
    """
    frequency, amplitude = spectrum
    band = (frequency >= low) & (frequency <= high)
    best = int(np.argmax(amplitude[band]))
    return float(frequency[band][best]), float(amplitude[band][best])
