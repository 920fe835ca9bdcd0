"""Two families of partials in one spectrum: each peak belongs to the modes of one span, of both, or of none.

The transverse frequencies of a section keep their ratios at every tension, so that a family is known by one
factor on the certified modes of its span: each peak, taken for each of the lowest modes, proposes one.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal

from cabledrive.parameters.arrays import Array

MOST_PEAKS = 24
STANDING_OUT = 6.0
"""Peak over the level of the spectrum around it."""
DIP = 0.4
"""Fall on both sides of a peak, in the logarithm of the amplitude."""
FAINTEST = 0.003
"""Peak over the largest one, below which window and rounding show."""
SIDELOBE, LOBES = 0.04, 5.0
"""Amplitude over that of a peak fewer bins away, up to which the window makes it."""
PROPOSING = 4
"""Modes for which a peak may be taken when it proposes a family."""
MISSING, FIRST_MISSING = 0.5, 1.5
"""Price of a mode without a peak below the highest one that has one, and what the first costs beyond it."""
PRICED = 6
"""Lowest modes whose absence is paid for."""
WORTH = 0.5
"""What a second family must add to be looked at."""
FAINT = 0.03
"""Its largest own peak over the largest of all, below which it is no span that was plucked."""
OTHERWISE = 0.004
"""Relative difference of its factor from which a family is another one."""
NEAR_OCTAVE = 0.02
"""Relative distance of two factors from a whole ratio below which, on like spans, one is not believed."""
STANDING = 0.85
"""Amplitude of a tone late in a recording over that early, above which it is hum."""
MOST_SINGLES, MOST_PAIRS = 5, 6
ALIKE = 1e-9
"""Relative difference up to which modes of both spans are the same."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Peaks:
    """Peaks of a spectrum."""

    frequency: Array  # (peaks,): [Hz], ascending
    amplitude: Array  # (peaks,)
    weight: Array  # (peaks,): logarithm of the amplitude over what is just a peak
    reach: Array  # (peaks,): how far from it a mode may lie that is still taken for it [Hz]

    def only(self, kept: NDArray[np.bool_]) -> "Peaks":
        """Some of the peaks."""
        return Peaks(**{name: getattr(self, name)[kept] for name in Peaks.__slots__})

    def joined(self, other: "Peaks") -> "Peaks":
        """These peaks, and those of another spectrum that are none of them."""
        if self.frequency.size == 0:
            return other
        distance = np.abs(other.frequency[:, None] - self.frequency)
        nearest = np.argmin(distance, axis=1)
        new = distance.min(axis=1, initial=np.inf) > self.reach[nearest] + other.reach
        rows = {name: np.append(getattr(self, name), getattr(other, name)[new]) for name in Peaks.__slots__}
        for name in ("amplitude", "weight"):
            np.maximum.at(rows[name], nearest[~new], getattr(other, name)[~new])
        order = np.argsort(rows["frequency"])
        return Peaks(**{name: row[order] for name, row in rows.items()})


Family = tuple[str, float]
"""A family of partials that the peaks propose: its span, and the factor on the frequencies of its modes."""
Proposal = tuple[float, tuple[Family, ...]]
"""Weight of the peaks that it explains, less what is missing; one family, or one for each span."""


def peaks_of(frequency: Array, amplitude: Array, band: tuple[float, float], duration: float) -> Peaks:
    """The `MOST_PEAKS` largest peaks that stand out of the spectrum around them, in a band [Hz]."""
    step = float(frequency[1] - frequency[0])
    wide = max(31, round(60.0 / (duration * step)))
    level = ndimage.median_filter(amplitude[:: max(1, wide // 31)], 31, mode="nearest")
    floor = np.interp(frequency, frequency[:: max(1, wide // 31)], level)
    tops = signal.find_peaks(np.log(np.maximum(amplitude, 1e-300)), prominence=DIP)[0]
    inside = (frequency[tops] > band[0]) & (frequency[tops] < band[1])
    tops = tops[inside & (np.minimum(amplitude[tops - 1], amplitude[tops + 1]) > 0.0)]
    least = np.maximum(STANDING_OUT * floor, FAINTEST * amplitude.max())
    tops = tops[amplitude[tops] > least[tops]]
    near = np.abs(frequency[tops][:, None] - frequency[tops]) < LOBES / duration
    loudest = np.where(near, amplitude[tops], 0.0).max(axis=1, initial=0.0)
    tops = tops[amplitude[tops] > SIDELOBE * loudest]
    tops = np.sort(tops[np.argsort(amplitude[tops])[::-1][:MOST_PEAKS]])
    rows = np.log(amplitude[tops[:, None] + np.array([-1, 0, 1])])
    shift = 0.5 * (rows[:, 0] - rows[:, 2]) / (rows[:, 0] - 2.0 * rows[:, 1] + rows[:, 2])
    exact = frequency[tops] + shift * step
    return Peaks(
        frequency=exact,
        amplitude=amplitude[tops],
        weight=np.log(amplitude[tops] / least[tops]) + 0.5,
        reach=1.0 / duration + 0.003 * exact,
    )


def falling(peaks: Peaks, values: Array, interval: float) -> NDArray[np.bool_]:
    """Whether each peak is lower in the last part of a recording than in the first; else it is hum."""
    part = max(1, round(0.4 * values.size))
    window = np.hanning(part)[:, None] * np.exp(
        -2j * np.pi * interval * np.outer(np.arange(part), peaks.frequency)
    )
    first, last = np.abs(values[:part] @ window), np.abs(values[-part:] @ window)
    found = np.asarray(last < STANDING * first)
    return found if found.any() else ~found


def matched(peaks: Peaks, teeth: Array) -> NDArray[np.intp]:
    """Number of the nearest peak within its reach of each mode (modes,) [Hz], or -1."""
    if peaks.frequency.size == 0:
        return np.full(teeth.size, -1, dtype=np.intp)
    distance = np.abs(teeth[:, None] - peaks.frequency)
    nearest = np.argmin(distance, axis=1)
    near = distance[np.arange(teeth.size), nearest] <= peaks.reach[nearest]
    return np.where(near, nearest, -1)


def proposals(
    peaks: Peaks, teeth: dict[str, Array], factor: float, limit: float
) -> tuple[tuple[Proposal, ...], tuple[Proposal, ...]]:
    """The best single families, and the best pairs, `MOST_SINGLES` and `MOST_PAIRS` that differ, best first.

    ``teeth``: modes of each span at the drive's own tension [Hz]; ``factor``: 2 where the recording has twice
    the frequency of the span, else 1; ``limit``: families are searched from 1 / limit to limit.
    """
    found = {span: _scored(peaks, factor * row, limit) for span, row in teeth.items()}
    singles = _distinct(
        [
            (float(peaks.weight[explained].sum()) - price, ((span, scale),))
            for span, row in found.items()
            for scale, explained, price in row
        ],
        MOST_SINGLES,
    )
    if not singles or len(teeth) < 2:
        return singles, ()
    pairs: list[Proposal] = []
    alike = bool(np.allclose(teeth["upper"], teeth["lower"], rtol=ALIKE))
    for (low, one, price), (high, two, other) in product(found["upper"], found["lower"]):
        # on every second or third mode of the other: split partials look like that
        octave = round(high / low) > 1 and abs(high / low / round(high / low) - 1.0) < NEAR_OCTAVE
        if alike and (low > high or octave):
            continue
        total = float(peaks.weight[one | two].sum()) - price - other
        own = (peaks.amplitude[mask].max(initial=0.0) for mask in (one & ~two, two & ~one))
        if total >= singles[0][0] + WORTH and min(own) >= FAINT * peaks.amplitude.max():
            pairs.append((total, (("upper", low), ("lower", high))))
    return singles, _distinct(pairs, MOST_PAIRS)


def _distinct(every: list[Proposal], most: int) -> tuple[Proposal, ...]:
    """The best of some proposals that differ."""

    def differs(one: Proposal, other: Proposal) -> bool:
        pairs = zip(one[1], other[1], strict=True)
        return any(a != b or abs(x / y - 1.0) > OTHERWISE for (a, x), (b, y) in pairs)

    distinct: list[Proposal] = []
    for one in sorted(every, key=lambda one: -one[0]):
        if len(distinct) < most and all(differs(one, other) for other in distinct):
            distinct.append(one)
    return tuple(distinct)


def _scored(peaks: Peaks, teeth: Array, limit: float) -> list[tuple[float, NDArray[np.bool_], float]]:
    """Factors that peaks propose, the peaks that each explains and what it pays for what is missing."""
    scales = (peaks.frequency[:, None] / teeth[None, :PROPOSING]).ravel()
    scales = np.sort(scales[(scales > 1.0 / limit) & (scales < limit)])
    found = []
    for scale in scales[np.diff(scales, prepend=-1.0) > 1e-5].tolist():
        taken = matched(peaks, scale * teeth)
        explained = np.zeros(peaks.frequency.size, dtype=bool)
        explained[taken[taken >= 0]] = True
        heard = np.flatnonzero(taken[:PRICED] >= 0)
        silent = taken[: heard[-1]] < 0 if heard.size else np.ones(1, dtype=bool)
        price = MISSING * float(silent.sum()) + FIRST_MISSING * float(silent[:1].sum())
        found.append((scale, explained, price))
    return found
