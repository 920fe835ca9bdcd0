"""Transverse modes that a motion can excite: at lines of the tension's spectrum, or at half of them."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive
from cabledrive.reduction.static_state import FreeStretch, StaticState, free_stretches

Array = NDArray[np.float64]

ALWAYS = (1, 2, 3, 4)
"""Modes of every stretch that are kept whatever the motion: they carry its slow deflection."""

LEAST_GROWTH = 0.7
"""Logarithm of the growth over the motion below which parametric excitation does not count."""

LEAST_SHARE = 0.3
"""Share of the floor below which direct excitation does not count."""

STRONG = 0.12
"""Relative oscillation of a tension from which the second instability region, at a mode's own frequency,
counts."""

UNSURE = 0.006
"""Relative error of a mode's frequency that the selection allows for: by sag, and by uneven tension."""

WIDE = 0.1
"""Share of a frequency around it whose lines act together."""

HANN = 1.5
"""Sum of the squares of the lines into which the window spreads one."""

HIGHEST = 80


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TensionLines:
    """Spectrum of the tension's oscillation over its value at rest, the largest along the cable.

    Attributes
    ----------
    size : ndarray, shape (n,)
        Relative amplitude of each line [-].
    omega : ndarray, shape (n,)
        [rad/s].
    duration : float
        Of the motion [s].
    """

    size: Array
    omega: Array
    duration: float


def amplitudes(values: Array) -> Array:
    """Amplitudes of the sines in some signals, their means removed.

    ``values``, shape (n, signals).
    Returns shape (n // 2 + 1, signals).
    """
    window = np.hanning(values.shape[0])[:, None]
    spectrum = np.fft.rfft(window * (values - values.mean(axis=0)), axis=0)
    return np.asarray(2.0 * np.abs(spectrum) / window.sum())


def excited_modes(drive: Drive, state: StaticState, lines: TensionLines, floor: float) -> list[list[int]]:
    r"""Numbers of the transverse modes of each free stretch, the most endangered first behind the lowest.

    A tension that oscillates by :math:`\eta T` at :math:`\Omega` makes a mode at :math:`w = \Omega/2`, or two
    whose frequencies add to it, grow by up to :math:`\tfrac18\Omega\eta` per time, within as much in
    frequency; through a sag of slope :math:`\sigma` it shakes a mode at :math:`w = \Omega` to no more than
    :math:`\eta\sigma/\kappa` times :math:`\min(w/\Gamma, \tfrac12 wT)`.

    ``floor``: amplitude below which nothing counts [m].
    """
    return [_of_stretch(drive, state, part, lines, floor) for part in free_stretches(drive, state)]


def _around(lines: TensionLines) -> Array:
    """Amplitude of all lines near each one together: what a chirp or a band of noise has at one time."""
    total = np.concatenate(([0.0], np.cumsum(lines.size**2)))
    place = np.arange(lines.size.size)
    reach = np.maximum((WIDE * place).astype(int), 2)
    high, low = np.minimum(place + reach + 1, place.size), np.maximum(place - reach, 0)
    return np.asarray(np.sqrt((total[high] - total[low]) / HANN))


def _of_stretch(
    drive: Drive, state: StaticState, part: FreeStretch, lines: TensionLines, floor: float
) -> list[int]:
    w = np.arange(1, HIGHEST + 1) * pi / part.travel_time
    omega, size, duration = lines.omega, lines.size, lines.duration
    blurred = 4 * pi / duration
    around = _around(lines)
    growth = 0.125 * omega * size * duration
    width = 0.25 * omega * around + blurred
    growth = np.where(around > STRONG, np.maximum(growth, 0.125 * omega * around * duration), growth)
    score = np.zeros(HIGHEST)
    for first in range(3):  # with itself, with the next, with the one after that
        sums = w[: HIGHEST - first] + w[first:]
        for a, total in enumerate(sums):
            near = np.abs(omega - total) < 2.0 * width + UNSURE * total
            best = float(np.max(growth, where=near, initial=0.0)) * (1.0 if first == 0 else 0.3)
            for one in (a, a + first):
                score[one] = max(score[one], best if best > LEAST_GROWTH else 0.0)
    loss = max(drive.cable.transverse_damping, 1e-300)
    speed = np.sqrt(float(np.max(state.tension[part.segments])) / state.mesh.density)
    steep = float(np.max(np.abs(state.slope[part.segments])))
    for a, own in enumerate(w):
        near = np.abs(omega - own) < 2.0 * blurred + 2.0 * UNSURE * own
        line = float(np.max(size, where=near, initial=0.0))
        wide = np.abs(omega - own) < 2.0 * blurred + WIDE * own
        strong = float(np.max(around, where=wide, initial=0.0))
        shaken = line * steep * speed / own * min(own / loss, 0.5 * own * duration)
        if shaken > LEAST_SHARE * floor:
            score[a] = max(score[a], 1.0 + np.log1p(shaken / floor))
        if strong > STRONG:
            score[a] = max(score[a], 0.125 * own * strong**2 * duration)
    found = [int(a) + 1 for a in np.argsort(-score) if score[a] > 0.0 and int(a) + 1 not in ALWAYS]
    return [*ALWAYS, *found]
