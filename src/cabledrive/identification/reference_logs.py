"""Logs of a sound axis that moves as a measured one did: what a method finds in them is its own error."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_lyapunov

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.innovation_kernels import shadow
from cabledrive.identification.innovations import Track, observer_gains, predicted_angles
from cabledrive.identification.regression import MOST_SEGMENTS

Array = NDArray[np.float64]

COUNT = 4
"""Places of the encoder that are tried."""
SERVO = 1.0
"""Bandwidth of the servo that keeps the sound axis along the measured motion [Hz]."""
SMOOTH = 20.0
"""Bandwidth of the motion that it is kept along [Hz]."""


def reference_tracks(
    tracks: Sequence[Track], values: Array, bandwidths: Sequence[float], rng: np.random.Generator
) -> Iterator[list[Track]]:
    """Logs of a rigid axis with Coulomb friction beside the measured ones.

    A soft servo adds to the measured torque what keeps the axis near the measured motion; that torque is
    known. The angle is rounded as the encoder does, and the torque is as noisy as the innovations call for.

    ``values``, shape (4,); ``bandwidths``: of the observers [rad/s].
    Returns one for each track, `COUNT` times.
    """
    moved = [_beside(track, values) for track in tracks]
    noises = [_noises(track, values, width) for track, width in zip(tracks, bandwidths, strict=True)]
    for k in range(COUNT):
        made = []
        for track, (angle, torque), (rough, noisy) in zip(tracks, moved, noises, strict=True):
            q = track.quantum
            seen = (
                q * np.floor(angle / q + k / COUNT) if q > 0 else angle + rough * rng.normal(size=angle.size)
            )
            white = noisy * rng.normal(size=angle.size + 1)
            made.append(replace(track, position=seen, torque=torque + 0.5 * (white[1:] + white[:-1])))
        yield made


def _beside(track: Track, values: Array) -> tuple[Array, Array]:
    """Angle of the sound axis and the torque that acts on it."""
    smooth = min(SMOOTH, 0.2 / track.interval)
    along = zero_phase(track.position, track.interval, smooth)
    speed = difference(along, track.interval)
    omega = 2 * np.pi * SERVO
    gains = np.array([values[0] * omega**2, 2 * values[0] * omega])
    moved, acting = np.empty_like(along), np.empty_like(along)
    shadow(values, gains, track.torque, along, speed, track.interval, moved, acting)
    return moved, acting


def _noises(track: Track, values: Array, bandwidth: float) -> tuple[float, float]:
    """Deviations of the noise of angle and torque, from the power that innovations usually have."""
    parts = np.array_split(predicted_angles(track, values, bandwidth).innovation ** 2, MOST_SEGMENTS)
    power = float(np.median([part.mean() for part in parts]))
    by_angle, by_torque = innovation_powers(values[0], bandwidth, track.interval)
    rough = track.quantum**2 / 12.0 if track.quantum > 0.0 else 0.5 * power / by_angle
    return float(np.sqrt(rough)), float(np.sqrt(max(power - by_angle * rough, 0.0) / by_torque))


def innovation_powers(inertia: float, bandwidth: float, interval: float) -> tuple[float, float]:
    """Power of the innovation for white noise of power 1 in the angle, and in the torque.

    ``bandwidth``: of the observer [rad/s]; ``interval`` [s].
    Returns ``by_angle, by_torque``: of the second the unit is [rad^2/(N m)^2].
    """
    gains = observer_gains(bandwidth, interval)
    forward = np.array([[1.0, interval], [0.0, 1.0]])
    corrected = forward @ (np.eye(2) - np.outer(gains, [1.0, 0.0]))
    noise = forward @ gains, np.array([0.5 * interval**2, interval]) / inertia
    angle, torque = (solve_discrete_lyapunov(corrected, np.outer(b, b))[0, 0] for b in noise)
    return 1.0 + float(angle), float(torque)
