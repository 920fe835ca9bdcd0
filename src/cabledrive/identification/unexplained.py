"""The torque that a rigid axis leaves unexplained: what an observer has to add to follow the angle."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from cabledrive.identification.innovations import Following

Array = NDArray[np.float64]

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
    """Unexplained torque.

    Attributes
    ----------
    share : float
        Its size over that of the torque.
    rise : float
        Its power density in the lower quarter of the observer's band over that in the upper half: near 1
        where it is white noise of the torque channel, below where it is noise of the encoder.
    bandwidth : float
        Of the observer [Hz].
    rounded : bool
        Whether the rounding of the encoder's angle alone makes as much.
    """

    share: float
    rise: float
    bandwidth: float
    rounded: bool

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
