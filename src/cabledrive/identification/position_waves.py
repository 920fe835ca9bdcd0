"""What an observer has to add: torques of the position, errors of the encoder, the rest."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.innovations import Following

Array = NDArray[np.float64]

MOST_WAVES = 60
"""Per revolution, that are tried."""
EXPLAINED = 0.06
"""Share of the unexplained torque's power from which a wave is named."""
OVERTONE = 0.03
"""The same for its overtones."""
ABOVE = 40.0
"""Of the middle one of all waves, at least."""
RESOLVED = 0.15
"""Of a count of the encoder: a smaller innovation may be the counts' own where a motion repeats itself."""
EVERY = 4
"""Samples between those that are used."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionWave:
    """Waves of a revolution in the unexplained torque."""

    kind: str  # {"torque", "eccentricity"}
    counts: tuple[int, ...]  # per revolution, the strongest first
    amplitude: float  # of the strongest: torque [N m or N], or angle of the encoder's error [rad]
    share: float  # of the unexplained torque's power

    @property
    def words(self) -> str:
        """The waves in a sentence."""
        if self.kind == "eccentricity":
            return (
                f"the encoder's angle is wrong by {self.amplitude:.2g} rad once per revolution: "
                "eccentricity of its disc or a shaft that runs out"
            )
        listed = ", ".join(str(count) for count in self.counts)
        return (
            f"a torque of the position with {listed} period(s) per revolution "
            f"(amplitude {self.amplitude:.2g} N m): cogging, a tooth, or a weight out of balance"
        )


def position_wave(followed: Sequence[Following]) -> PositionWave | None:
    """The wave of a revolution that explains most of what the axis leaves, of the log that shows most.

    ``followed``: logs of an axis that turns.
    Returns none where no wave explains enough.
    """
    found = [one for one in map(_wave_of, followed) if one is not None]
    return max(found, key=lambda one: one.share) if found else None


def _wave_of(one: Following) -> PositionWave | None:
    track, run, width, values = one.track, one.run, one.bandwidth, one.run.values
    hertz = width / (2.0 * np.pi)
    angle = zero_phase(track.position, track.interval, min(2.0 * hertz, 0.2 / track.interval))
    # The observer's correction lags behind what it corrects by about one radian of its bandwidth.
    added = zero_phase(one.added, track.interval, min(hertz, 0.2 / track.interval))
    edge, late = track.position.size // 20, round(np.sqrt(2.0) / (width * track.interval))
    left, place = added[edge + late :: EVERY], angle[edge : added.size - late : EVERY]
    slipping = run.direction[edge : added.size - late : EVERY] != 0.0
    left, place = left[slipping], place[slipping]
    if left.size < 100 * MOST_WAVES // EVERY or np.ptp(place) < 2.0 * np.pi / 3.0:
        return None
    power = float(left @ left)
    shares, sizes = np.zeros(MOST_WAVES), np.zeros(MOST_WAVES)
    for count in range(1, MOST_WAVES + 1):
        shares[count - 1], sizes[count - 1] = _explained(left, np.exp(1j * count * place), power)
    best = int(np.argmax(shares))
    # An error e of the angle asks for the torque J e'' + b e'.
    wave = np.exp(1j * angle)
    speed = difference(wave.real, track.interval) + 1j * difference(wave.imag, track.interval)
    rate = difference(speed.real, track.interval) + 1j * difference(speed.imag, track.interval)
    asked = values[0] * rate + values[1] * speed
    share, size = _explained(left, asked[edge : added.size - late : EVERY][slipping], power)
    moved = float(np.sqrt(max(share, shares[best]) * np.mean(run.innovation**2)))
    if moved < RESOLVED * track.quantum:
        return None
    if share > max(EXPLAINED, shares[best]):
        return PositionWave(kind="eccentricity", counts=(1,), amplitude=size, share=share)
    if shares[best] < EXPLAINED or shares[best] < ABOVE * float(np.median(shares)):
        return None
    whole = best + 1
    over = [n for n in range(2 * whole, MOST_WAVES + 1, whole) if shares[n - 1] > OVERTONE]
    return PositionWave(
        kind="torque", counts=(whole, *over), amplitude=float(sizes[best]), share=float(shares[best])
    )


def _explained(left: Array, wave: NDArray[np.complex128], power: float) -> tuple[float, float]:
    """Share of a power that a complex wave explains, both its parts free, and its amplitude."""
    columns = np.column_stack([wave.real, wave.imag])
    columns = columns - columns.mean(axis=0)
    weights, *_ = np.linalg.lstsq(columns, left, rcond=None)
    rest = left - columns @ weights
    return 1.0 - float(rest @ rest) / power, float(np.hypot(*weights))


LARGE, SMALL, COLOURED = 0.04, 0.002, 3.0
"""Shares of the torque, and the rise, from which it is more than noise."""
ROUNDED, COUNTS = 0.1, 0.5
"""Rise, and innovation in counts of the encoder, below which it is rounding alone, whatever its share."""
LOWEST = 0.3
"""[Hz]."""
LONGEST_SEGMENT = 8.0
"""Of the records whose spectra are averaged [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Unexplained:
    """Unexplained torque."""

    share: float  # its size over that of the torque
    # its power density in the lower quarter of the observer's band over that in the upper half: near 1 where
    # it is white noise of the torque channel, below where it is noise of the encoder
    rise: float
    bandwidth: float  # of the observer [Hz]
    rounded: bool  # whether the rounding of the encoder's angle alone makes as much

    @property
    def beyond(self) -> bool:
        """Whether it is more than noise of the torque and of the encoder make."""
        return (self.share > LARGE and not self.rounded) or (self.share > SMALL and self.rise > COLOURED)

    @property
    def words(self) -> str:
        """The unexplained torque in a sentence."""
        size = (
            f"{100 * self.share:.2g} % of the torque"
            if self.share < 1.0
            else (f"{self.share:.2g} times as much torque as was measured")
        )
        return (
            f"{size} is not explained by a rigid axis with constant friction (below {self.bandwidth:.2g} "
            "Hz): an unmeasured disturbance, or a fault that is not in the list"
        )


def unexplained_torque(followed: Sequence[Following]) -> Unexplained:
    """What the observers that follow the logs best add to the torque, of the log with the largest share."""
    found = []
    for one in followed:
        track, run = one.track, one.run
        added = one.added[track.position.size // 20 :]
        hertz = one.bandwidth / (2.0 * np.pi)
        length = min(round(LONGEST_SEGMENT / track.interval), added.size)
        frequency, power = signal.welch(added, 1.0 / track.interval, nperseg=length)
        low = (frequency >= LOWEST) & (frequency < 0.25 * hertz)
        high = (frequency >= 0.5 * hertz) & (frequency < hertz)
        below = (frequency >= LOWEST) & (frequency < hertz)
        size = float(np.sqrt(power[below].sum() * (frequency[1] - frequency[0])))
        whole = float(np.sqrt(np.mean(track.torque**2)))
        rise = 0.0
        if low.any() and high.any():
            rise = float(power[low].mean() / max(power[high].mean(), 1e-300))
        counts = float(np.sqrt(np.mean(run.innovation**2)))
        rounded = rise < ROUNDED and counts < COUNTS * track.quantum
        found.append(Unexplained(share=size / whole, rise=rise, bandwidth=hertz, rounded=rounded))
    return max(found, key=lambda one: one.share)
